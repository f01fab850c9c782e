"""A file of gates to begin with: a limit for each calibrator of a comparison that can be decided, and what it costs."""

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
"""Limits that are tried, as multiples of the reference's score, or for the reference itself of its median."""
AFFORDABLE = 150
"""Trials that a limit may take to pass; a stricter one that takes more is named with its price."""
USUALLY = 0.5
"""The other probability, beside the gates' power, with which a number of trials is told."""
ANEW = "compare anew"


@dataclass(frozen=True)
class ProposedLimit:
    """A limit, and the trials within which a calibrator as bad as what was measured allows keeps it.

    trials: with the gates' power; usually: in half of the runs.
    """

    limit: float
    trials: int | None
    usually: int | None


@dataclass(frozen=True)
class GateProposal:
    """A gate for one calibrator.

    reference : None where the limit is in the score's unit. values (n,) : what the limit is held against.
    stricter : the limit before it on the ladder, which takes more trials; None where what was measured is over it.
    """

    calibrator: str
    reference: str | None
    values: Array
    test: SequentialTest
    step: ProposedLimit
    stricter: ProposedLimit | None

    @property
    def max_trials(self) -> int:
        """Enough to pass, and for a calibrator that got much worse to fail."""
        return max(self.step.trials or MOST_TRIALS, 2 * fewest_trials(self.test))

    @property
    def caught(self) -> float:
        """The defect that fails within max_trials, as a factor on what was measured."""
        return factor_seen(self.values / self.step.limit, smallest_exceedance(self.test, self.max_trials, POWER))


def gate_proposals(table: TrialTable, score: ScoreDefinition) -> list[GateProposal]:
    """A gate for every calibrator that gives an estimate in most trials, the best first; the others refer to it.

    One that is worse than the best by more than the ladder has gets a limit of its own.
    Raises InputError where there is none.
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
    """The lowest limit of the ladder that can be afforded, else the highest."""
    stricter: ProposedLimit | None = None
    for rung in LADDER:
        step = _step(rung * unit, values, test)
        if step.trials is not None and step.trials <= AFFORDABLE:
            break
        if rung != LADDER[-1]:
            stricter = step if step.limit > np.median(values) else None
    return GateProposal(name, reference, values, test, step, stricter)


def _step(wanted: float, values: Array, test: SequentialTest) -> ProposedLimit:
    limit = float(f"{wanted:.3g}")
    # the upper end: what so few trials leave open counts against the limit
    over = rate(int(np.count_nonzero(values > limit)), len(values)).high
    if over >= test.allowed:
        return ProposedLimit(limit, None, None)
    return ProposedLimit(limit, trials_to_pass(test, over, POWER), trials_to_pass(test, over, USUALLY))


@dataclass(frozen=True)
class FinishedComparison:
    """What a comparison's directory holds: its table, its first point's scenario, its seed, who took part.

    asked : by the calibrator's name; None for one that no words name.
    """

    table: TrialTable
    scenario: Scenario
    seed: int
    asked: Mapping[str, Invocation | None]

    @classmethod
    def read(cls, out: Path) -> FinishedComparison:
        """InputError for a directory that no comparison wrote, or another version's, and for one of several points."""
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
        asked = {name: one["asked"] and Invocation.read(one["asked"]) for name, one in identity["calibrators"].items()}
        return cls(table, scenario, identity["seed"], asked)

    @property
    def of_the_catalogue(self) -> bool:
        """Whether the scenario is the catalogue's of its name, unchanged."""
        return self.scenario.name in scenario_names() and load(self.scenario.name) == self.scenario

    @property
    def time_limit_s(self) -> float:
        """What a fit of a calibrator that is not magbench's could take."""
        limits = [one.time_limit_s for one in self.asked.values() if one and one.time_limit_s]
        return max(limits, default=TIME_LIMIT_S)

    def asked_for(self, row: str) -> Invocation:
        """By which words a gate names the calibrator of a row; of an array with the sensor."""
        name, at, sensor = row.partition("@")
        found = self.asked[name] or Invocation(name)
        return replace(found, calibrator=found.calibrator + at + sensor)


def gates_toml(compared: FinishedComparison, found: Sequence[GateProposal], score: ScoreDefinition) -> str:
    """The file, with what each limit costs as comments."""
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
    table, asked = tomlkit.table(), compared.asked_for(one.calibrator)
    for line in _comments(one, compared, score):
        table.add(tomlkit.comment(line))
    table["name"] = f"{one.calibrator} {score.name}"
    table["scenario"] = compared.scenario.name + ("" if compared.of_the_catalogue else ".toml")
    table["calibrator"] = asked.calibrator
    if asked.words:
        table["exec"] = asked.exec
    if asked.needs:
        table["needs"] = list(asked.needs)
    table["score"] = score.column
    if one.reference is None:
        table["limit"] = one.step.limit
    else:
        table["ratio"] = one.step.limit
        table["reference"] = compared.asked_for(one.reference).calibrator
    table["max_trials"] = one.max_trials
    return table


def _comments(one: GateProposal, compared: FinishedComparison, score: ScoreDefinition) -> list[str]:
    """What was measured, what the limit costs, what it catches, and what a stricter one would cost."""
    of = score.unit if one.reference is None else f"x {one.reference}"
    median = float(np.median(one.values))
    lines = [f"Measured {figure(median)} {of}. {_cost(one.step)}."]
    if np.isfinite(one.caught):
        lines.append(f"Catches {figure(one.caught * median)} {of}, {figure(one.caught)} times what was measured.")
    if one.stricter is not None:
        lines.append(f"Costly: a limit of {figure(one.stricter.limit)}. {_cost(one.stricter)}.")
    if compared.asked[one.calibrator.partition("@")[0]] is None:
        lines.append('To do: it was an object in memory; put it into a module: calibrator = "module:object".')
    return lines


def _cost(step: ProposedLimit) -> str:
    if step.trials is None:
        return f"Passing takes more than {MOST_TRIALS:,} trials"
    return (
        f"Passing takes {step.usually} trials in half of the runs, {step.trials} at most in {100 * POWER:g} % of them"
    )
