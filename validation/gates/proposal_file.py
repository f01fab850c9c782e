"""File of proposed gates, written from the directory of a finished comparison."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from scenarios.errors import InputError
from scenarios.files import read_text
from scenarios.names import scenario_names
from sim.scenario import Scenario, load
from validation.calibrating.invocation import Invocation
from validation.calibrating.processes import TIME_LIMIT_S
from validation.comparison.design import FORMAT
from validation.comparison.journal import COMPARISON, JOURNAL
from validation.comparison.ranking import uncorrected_row
from validation.comparison.sealed_lines import unsealed
from validation.comparison.trial_table import TRIALS, TrialTable
from validation.gates.gate_file import FALSE_FAIL_RATE
from validation.gates.proposal import GateProposal, GateProposals, cost
from validation.scoring.definitions import ScoreDefinition
from validation.text import counted, figure

ANEW = "compare anew"


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
        identity = _identity(out / JOURNAL)
        scenario = Scenario.model_validate_json(json.dumps(identity["points"][0]["scenario"]))
        invocations = {
            name: one["asked"] and Invocation.read(one["asked"]) for name, one in identity["calibrators"].items()
        }
        other = next((row for row in table.candidates if row.partition("@")[0] not in invocations), None)
        if other is not None:
            raise InputError(f"has rows of {other!r}, which {JOURNAL} does not name", where=str(out / TRIALS), do=ANEW)
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


def _identity(journal: Path) -> dict[str, Any]:
    """Return what a comparison's journal tells of its design; InputError unless the first line matches its checksum."""
    text = read_text(journal, "give a directory that `magbench compare` wrote").partition("\n")[0]
    first = unsealed(f"{text}\n".encode())
    if first is None:
        raise InputError("is no journal of a comparison, or its first line is damaged", where=str(journal), do=ANEW)
    identity: dict[str, Any] = first.get(COMPARISON, {})
    if identity.get("format") != FORMAT:
        raise InputError("is of another version's comparison", where=str(journal), do=ANEW)
    return identity


def gates_toml(compared: FinishedComparison, found: GateProposals, score: ScoreDefinition) -> str:
    """Return the text of a gate file; comments give the trials needed for each limit, and who is left out."""
    document = tomlkit.document()
    trials = counted(len(compared.table.runs()), "trial")
    document.add(tomlkit.comment(f"Begun from a comparison of {trials}; `magbench gate` says what a limit measures."))
    document["false_fail_rate"] = FALSE_FAIL_RATE
    if compared.seed != compared.scenario.seed:
        document["seed"] = compared.seed
    if compared.time_limit_s != TIME_LIMIT_S:
        document["time_limit_s"] = compared.time_limit_s
    for name, why in found.left_out.items():
        document.add(tomlkit.comment(_one_line(f"Left out: {name} {why}")))
    tables = tomlkit.aot()
    for one in found.gates:
        tables.append(_table(one, compared, score))
    document["gate"] = tables
    return str(tomlkit.dumps(document))


def _one_line(text: str) -> str:
    """Return printable text, which a comment of TOML can hold."""
    return "".join(character if character.isprintable() else " " for character in text)


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
    lines = [f"Measured {figure(median)} {of}. {cost(one.limit)}."]
    if np.isfinite(one.caught):
        lines.append(f"Catches {figure(one.caught * median)} {of}, {figure(one.caught)} times what was measured.")
    name, table = one.calibrator, compared.table
    kept, raw = (float(np.median(table.values(score.column, row))) for row in (name, uncorrected_row(name)))
    if not kept < raw:
        lines.append(f"No better than the raw measurement ({figure(raw)} {score.unit}): guards against worse alone.")
    if one.stricter is not None:
        lines.append(f"Costly: a limit of {figure(one.stricter.value)}. {cost(one.stricter)}.")
    if compared.invocations[one.calibrator.partition("@")[0]] is None:
        lines.append('To do: it was an object in memory; put it into a module: calibrator = "module:object".')
    return lines
