"""Proposed gate file from a comparison: a decidable limit for each calibrator, and the trials needed."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tomlkit

from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.files import parsed_json, read_text
from scenarios.names import scenario_names
from sim.scenario import Scenario, load
from validation.calibrating.invocation import Invocation
from validation.calibrating.processes import TIME_LIMIT_S
from validation.comparison.design import FORMAT
from validation.comparison.journal import COMPARISON, JOURNAL
from validation.comparison.statistics import rate
from validation.comparison.trial_table import TrialTable
from validation.gates.gate_file import FALSE_FAIL_RATE, POWER, QUANTILE
from validation.gates.power import MOST_TRIALS, factor_seen, fewest_trials, smallest_exceedance, trials_to_pass
from validation.gates.sequential import SequentialTest
from validation.scoring.definitions import ScoreDefinition
from validation.scoring.evaluation import UNCORRECTED
from validation.text import counted, figure

LADDER = (1.1, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""Limits tried, as multiples of the reference score, for the reference of the median score."""
AFFORDABLE = 150
"""Largest number of trials to pass a proposed limit; a stricter limit is mentioned with the trials needed."""
USUALLY = 0.5
"""Probability of the typical number of trials, reported in addition to the gates' power."""
ANEW = "compare anew"


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


def gate_proposals(table: TrialTable, score: ScoreDefinition) -> list[GateProposal]:
    """Propose a gate for every calibrator with an estimate in most trials; the best is the reference of the rest.

    A calibrator worse than the best by more than LADDER[-1] gets an absolute limit. Raises InputError where no
    calibrator gives an estimate in most trials.
    """
    named = [name for name in table.calibrators if name.split("@")[0] != UNCORRECTED]
    scores = {name: table.values(score.column, name) for name in named}
    medians = {name: float(np.median(scores[name])) for name in named}
    usable = sorted((name for name in named if math.isfinite(medians[name])), key=lambda name: medians[name])
    if not usable:
        raise InputError("no calibrator gives an estimate in most trials", do="compare others")
    test = SequentialTest(1.0 - QUANTILE, FALSE_FAIL_RATE / len(usable), 1.0 - POWER)
    best = scores[usable[0]]
    found = [_proposal(usable[0], None, best, medians[usable[0]], test)]
    for name in usable[1:]:
        ratios = scores[name] / best
        if np.median(ratios) > LADDER[-1]:
            found.append(_proposal(name, None, scores[name], medians[name], test))
        else:
            found.append(_proposal(name, usable[0], ratios, 1.0, test))
    return found


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


@dataclass(frozen=True)
class FinishedComparison:
    """Result of a comparison's directory: table, scenario of the first point, seed and calibrators.

    invocations : by the calibrator's name; None for an object in memory.
    """

    table: TrialTable
    scenario: Scenario
    seed: int
    invocations: Mapping[str, Invocation | None]

    @classmethod
    def read(cls, out: Path) -> FinishedComparison:
        """Read a directory; InputError for no comparison, a different version, and a sweep of several points."""
        table = TrialTable.read(out)
        if len(table.points) > 1:
            what = f"compares at {len(table.points)} points of a sweep"
            raise InputError(what, where=str(out), do="give a comparison without --sweep: a gate holds one scenario")
        text = read_text(out / JOURNAL, "give a directory that `magbench compare` wrote").partition("\n")[0]
        first = parsed_json(text, str(out / JOURNAL), ANEW)
        identity = first.get(COMPARISON, {}) if isinstance(first, dict) else {}
        if identity.get("format") != FORMAT:
            raise InputError("is of another version's comparison", where=str(out / JOURNAL), do=ANEW)
        scenario = Scenario.model_validate_json(json.dumps(identity["points"][0]["scenario"]))
        invocations = {
            name: one["asked"] and Invocation.read(one["asked"]) for name, one in identity["calibrators"].items()
        }
        return cls(table, scenario, identity["seed"], invocations)

    @property
    def of_the_catalogue(self) -> bool:
        """Whether the scenario equals the catalogue's scenario of equal name."""
        return self.scenario.name in scenario_names() and load(self.scenario.name) == self.scenario

    @property
    def time_limit_s(self) -> float:
        """Largest time limit of the calibrators that are not built in."""
        limits = [one.time_limit_s for one in self.invocations.values() if one and one.time_limit_s]
        return max(limits, default=TIME_LIMIT_S)

    def invocation_of(self, row: str) -> Invocation:
        """Return the invocation of a row's calibrator, with the sensor of an array."""
        name, at, sensor = row.partition("@")
        found = self.invocations[name] or Invocation(name)
        return replace(found, calibrator=found.calibrator + at + sensor)


def gates_toml(compared: FinishedComparison, found: Sequence[GateProposal], score: ScoreDefinition) -> str:
    """Return the text of a gate file, with the trials needed for each limit as comments."""
    document = tomlkit.document()
    trials = counted(len(compared.table.runs()), "trial")
    document.add(tomlkit.comment(f"Begun from a comparison of {trials}; `magbench gate` says what a limit measures."))
    document["false_fail_rate"] = FALSE_FAIL_RATE
    if compared.seed != compared.scenario.seed:
        document["seed"] = compared.seed
    if compared.time_limit_s != TIME_LIMIT_S:
        document["time_limit_s"] = compared.time_limit_s
    tables = tomlkit.aot()
    for one in found:
        tables.append(_table(one, compared, score))
    document["gate"] = tables
    return str(tomlkit.dumps(document))


def _table(one: GateProposal, compared: FinishedComparison, score: ScoreDefinition) -> tomlkit.items.Table:
    table, invocation = tomlkit.table(), compared.invocation_of(one.calibrator)
    for line in _comments(one, compared, score):
        table.add(tomlkit.comment(line))
    table["name"] = f"{one.calibrator} {score.name}"
    table["scenario"] = compared.scenario.name + ("" if compared.of_the_catalogue else ".toml")
    table["calibrator"] = invocation.calibrator
    if invocation.words:
        table["exec"] = invocation.exec
    if invocation.needs:
        table["needs"] = list(invocation.needs)
    table["score"] = score.column
    if one.reference is None:
        table["limit"] = one.limit.value
    else:
        table["ratio"] = one.limit.value
        table["reference"] = compared.invocation_of(one.reference).calibrator
    table["max_trials"] = one.max_trials
    return table


def _comments(one: GateProposal, compared: FinishedComparison, score: ScoreDefinition) -> list[str]:
    """Return comment lines: measured value, trials needed, detectable defect, and the price of a stricter limit."""
    of = score.unit if one.reference is None else f"x {one.reference}"
    median = float(np.median(one.values))
    lines = [f"Measured {figure(median)} {of}. {_cost(one.limit)}."]
    if np.isfinite(one.caught):
        lines.append(f"Catches {figure(one.caught * median)} {of}, {figure(one.caught)} times what was measured.")
    if one.stricter is not None:
        lines.append(f"Costly: a limit of {figure(one.stricter.value)}. {_cost(one.stricter)}.")
    if compared.invocations[one.calibrator.partition("@")[0]] is None:
        lines.append('To do: it was an object in memory; put it into a module: calibrator = "module:object".')
    return lines


def _cost(limit: ProposedLimit) -> str:
    if limit.trials is None:
        return f"Passing takes more than {MOST_TRIALS:,} trials"
    return (
        f"Passing takes {limit.usually} trials in half of the runs, {limit.trials} at most in {100 * POWER:g} % of them"
    )
