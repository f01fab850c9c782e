"""Proposed gate file from a comparison: a decidable limit for each calibrator, and the trials needed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.comparison.ranking import frequent_reason, quoted
from validation.comparison.statistics import rate
from validation.comparison.trial_table import TrialTable
from validation.gates.gate_file import FALSE_FAIL_RATE, POWER, QUANTILE
from validation.gates.power import MOST_TRIALS, factor_seen, fewest_trials, smallest_exceedance, trials_to_pass
from validation.gates.sequential import SequentialTest
from validation.scoring.definitions import ScoreDefinition
from validation.text import counted

LADDER = (1.1, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""Limits tried, as multiples of the reference score, for the reference of the median score."""
AFFORDABLE = 150
"""Largest number of trials to pass a proposed limit; a stricter limit is mentioned with the trials needed."""
USUALLY = 0.5
"""Probability of the typical number of trials, reported in addition to the gates' power."""


@dataclass(frozen=True)
class ProposedLimit:
    """A limit and the trials to pass for a calibrator at the upper end of the measured exceedance interval.

    trials : with the power of the gates. usually : in half of the runs.
    """

    value: float
    trials: int | None
    usually: int | None


@dataclass(frozen=True)
class GateProposal:
    """Proposed gate of a calibrator.

    reference : None for a limit in the unit of the score. values (n,) : compared with the limit. stricter : the next
    lower limit of LADDER, which needs more trials; None where the measured median exceeds the limit.
    """

    calibrator: str
    reference: str | None
    values: Array
    test: SequentialTest
    limit: ProposedLimit
    stricter: ProposedLimit | None

    @property
    def max_trials(self) -> int:
        """Trials sufficient to pass, and to fail a calibrator that became much worse."""
        return max(self.limit.trials or MOST_TRIALS, 2 * fewest_trials(self.test))

    @property
    def caught(self) -> float:
        """Defect that fails within max_trials, as a factor on the measured values."""
        return factor_seen(self.values / self.limit.value, smallest_exceedance(self.test, self.max_trials, POWER))


@dataclass(frozen=True)
class GateProposals:
    """Proposed gates, the first the reference of ratios, and why the other calibrators are left out, by name."""

    gates: tuple[GateProposal, ...]
    left_out: Mapping[str, str]


def gate_proposals(table: TrialTable, score: ScoreDefinition) -> GateProposals:
    """Propose a gate for every calibrator that a gate can guard; the best is the reference of the rest.

    Left out: a calibrator that fails in most trials, or keeps no limit of LADDER within MOST_TRIALS trials. A failed
    trial counts as an infinite score, as in a gate. A calibrator worse than the best by more than LADDER[-1] gets an
    absolute limit. Raises InputError where no calibrator is left.
    """
    scores = {name: _judged(table, score, name) for name in table.candidates}
    left_out = {name: why for name in scores if (why := _unguarded(table, score, name, scores[name]))}
    usable = sorted(scores.keys() - left_out.keys(), key=lambda name: (np.median(scores[name]), name))
    test = SequentialTest(1.0 - QUANTILE, FALSE_FAIL_RATE / max(1, len(usable)), 1.0 - POWER)
    found: list[GateProposal] = []
    for name in usable:
        one = _against(found[0].calibrator if found else None, name, scores, test)
        if one.limit.trials is None:
            left_out[name] = f"{_failures(table, name)}: {cost(one.limit).lower()}, whatever the limit"
        else:
            found.append(one)
    if not found:
        reasons = "; ".join(f"{name} {why}" for name, why in left_out.items())
        raise InputError(f"no gate would guard anything: {reasons}", do="compare others, or more trials")
    return GateProposals(tuple(found), left_out)


def _judged(table: TrialTable, score: ScoreDefinition, name: str) -> Array:
    """Return the scores (n,) of a calibrator as a gate counts them: infinite in a failed trial."""
    return np.where(table.failed(name), np.inf, table.values(score.column, name))


def _unguarded(table: TrialTable, score: ScoreDefinition, name: str, values: Array) -> str:
    """Return why a gate on a calibrator would guard nothing, "" where it would."""
    if len(values) and math.isfinite(np.median(values)):
        return ""
    return _failures(table, name) if table.failed(name).any() else f"gives no {score.name}"


def _failures(table: TrialTable, name: str) -> str:
    failed = table.failed(name)
    return (
        f"fails in {np.count_nonzero(failed)} of {counted(len(failed), 'trial')}{quoted(frequent_reason(table, name))}"
    )


def _against(best: str | None, name: str, scores: Mapping[str, Array], test: SequentialTest) -> GateProposal:
    """Propose a gate with the best calibrator as the reference, or with a limit in the unit of the score."""
    if best is not None:
        known = np.isfinite(scores[best])
        ratios = np.divide(scores[name], scores[best], out=np.full(len(known), np.inf), where=known)
        if np.median(ratios) <= LADDER[-1]:
            return _proposal(name, best, ratios, 1.0, test)
    return _proposal(name, None, scores[name], float(np.median(scores[name])), test)


def _proposal(name: str, reference: str | None, values: Array, unit: float, test: SequentialTest) -> GateProposal:
    """Propose the lowest limit of LADDER that passes within AFFORDABLE trials, else the highest."""
    stricter: ProposedLimit | None = None
    for rung in LADDER:
        limit = _limit(rung * unit, values, test)
        if limit.trials is not None and limit.trials <= AFFORDABLE:
            break
        if rung != LADDER[-1]:
            stricter = limit if limit.value > np.median(values) else None
    return GateProposal(name, reference, values, test, limit, stricter)


def _limit(wanted: float, values: Array, test: SequentialTest) -> ProposedLimit:
    limit = float(f"{wanted:.3g}")
    # upper end of the interval: uncertainty from few trials counts against the limit
    over = rate(int(np.count_nonzero(values > limit)), len(values)).high
    if over >= test.allowed:
        return ProposedLimit(limit, None, None)
    return ProposedLimit(limit, trials_to_pass(test, over, POWER), trials_to_pass(test, over, USUALLY))


def cost(limit: ProposedLimit) -> str:
    """Return the trials needed to pass a limit, in words."""
    if limit.trials is None:
        return f"Passing takes more than {MOST_TRIALS} trials"
    return (
        f"Passing takes {limit.usually} trials in half of the runs, {limit.trials} at most in {100 * POWER:g} % of them"
    )
