"""Gates grouped by scenario and overrides; the gates of a group share trials."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.names import closest
from sim.scenario import Scenario, load
from validation.calibrating.calibrator_entry import CalibratorEntry
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design, DesignPoint
from validation.comparison.trial import TrialRow
from validation.gates.bound_reference import BoundReference
from validation.gates.gate_file import BOUND, FAILURE, Gate, GateFile
from validation.gates.gate_outcome import GateProgress, GateTrial
from validation.gates.gate_plan import plan_gate
from validation.gates.score_baseline import read_baseline
from validation.scoring.evaluation import UNCORRECTED

NO_LIMIT = "no limit: the reference fails"


@dataclass(frozen=True)
class GateEntry:
    """A gate in a group: the rows of a trial that are read, the progress so far, and the reference of the limit."""

    progress: GateProgress
    calibrator: str
    reference: str | None = None
    baseline: Array | None = None
    bound: BoundReference | None = None

    def read_trial(self, run: int, rows: Mapping[str, TrialRow]) -> GateTrial:
        """Return the score and the reference score of a trial, rows by calibrator."""
        row, gate = rows[self.calibrator], self.progress.plan.gate
        score = gate_score(row, gate)
        if self.baseline is not None:
            reference_score = float(self.baseline[run])
        elif self.reference is not None:
            reference_score = gate_score(rows[self.reference], gate)
        else:
            reference_score = 1.0 if self.bound is None else self.bound.in_run(run)
        missing = "" if np.isfinite(reference_score) else NO_LIMIT
        return GateTrial(score, reference_score, missing if np.isfinite(score) else f"{row.status}: {row.reason}")


@dataclass(frozen=True)
class GateGroup:
    """Gates that share trials; `design` holds the scenario at point `number`, which identifies the group's trials."""

    number: int
    design: Design
    entries: tuple[GateEntry, ...]

    @property
    def finished(self) -> bool:
        """Whether every gate is decided or out of trials."""
        return all(entry.progress.finished for entry in self.entries)

    @property
    def max_trials(self) -> int:
        """Number of trials after which every gate is finished."""
        return max(entry.progress.plan.max_trials for entry in self.entries)

    @property
    def trials_done(self) -> int:
        """Number of trials done; max_trials once every gate is finished."""
        return self.max_trials if self.finished else max(len(entry.progress.trials) for entry in self.entries)


def gate_score(row: TrialRow, gate: Gate) -> float:
    """Return the score of a gate in a trial's row; infinite where missing, and for a status other than "ok"."""
    failed = row.status != "ok"
    if gate.score_definition.name == FAILURE:
        return float(failed)
    return math.inf if failed else row.scores.get(gate.score_definition.column, math.inf)


def group_gates(
    file: GateFile,
    path: Path,
    seed: int | None = None,
    time_limit_s: float | None = None,
    *,
    baselines: bool = True,
) -> tuple[GateGroup, ...]:
    """Group the gates of a file at `path`; scenarios and baselines are looked up in the directory of the file.

    seed, time_limit_s : default the file's. baselines : whether to read baselines. Raises InputError for a missing
    scenario, calibrator, baseline or bound, and for two commands of equal name.
    """
    stated = {"seed": seed, "time_limit_s": time_limit_s}
    file = file.model_copy(update={key: value for key, value in stated.items() if value is not None})
    shared: dict[tuple[str, tuple[str, ...]], list[int]] = {}
    for index, gate in enumerate(file.gate):
        shared.setdefault((gate.scenario, gate.set_), []).append(index)
    builder = _Builder(file, path, _commands(file, path), baselines)
    return tuple(builder.group(number, indices) for number, indices in enumerate(shared.values()))


def _commands(file: GateFile, path: Path) -> dict[str, str]:
    """Return the --exec commands of a file by calibrator name, valid for every gate with the name."""
    found: dict[str, str] = {}
    for index, gate in enumerate(file.gate):
        name = gate.calibrator.partition("@")[0]
        if gate.command and found.setdefault(name, gate.command) != gate.command:
            where = f"{path}: gate.{index}.exec"
            raise InputError(f"{name!r} is another command in a gate before", where=where, do="choose another name")
    return found


@dataclass(frozen=True)
class _Builder:
    """Builds the groups of a file: resolves scenarios, calibrators, references and baselines."""

    file: GateFile
    path: Path
    commands: Mapping[str, str]
    baselines: bool

    def group(self, number: int, indices: Sequence[int]) -> GateGroup:
        """Return the group of the gates `indices`, which share a scenario."""
        with self._at(indices[0], "scenario"):
            scenario = self._scenario(self.file.gate[indices[0]])
        found: dict[str, CalibratorEntry] = {}
        for index in indices:
            self._add_candidates(found, index)
        self._check_names(found, indices[0])
        seed = scenario.seed if self.file.seed is None else self.file.seed
        design = Design((DesignPoint({}, scenario),) * (number + 1), tuple(found.values()), seed)
        rows = {text: one.name for text, one in found.items()} | {UNCORRECTED: UNCORRECTED}
        return GateGroup(number, design, tuple(self._entry(index, design, rows) for index in indices))

    def _scenario(self, gate: Gate) -> Scenario:
        file = self.path.parent / gate.scenario
        return load(file if file.is_file() else gate.scenario, gate.set_)

    def _add_candidates(self, found: dict[str, CalibratorEntry], index: int) -> None:
        gate = self.file.gate[index]
        reference = None if gate.reference == BOUND else gate.reference
        for key, text in (("calibrator", gate.calibrator), ("reference", reference)):
            name = (text or UNCORRECTED).partition("@")[0]
            if name not in found and name != UNCORRECTED:
                with self._at(index, key):
                    command = self.commands.get(name)
                    named, programs = ((), (command,)) if command else ((name,), ())
                    (found[name],) = select_calibrators(named, programs, self.file.time_limit_s)

    def _check_names(self, found: Mapping[str, CalibratorEntry], index: int) -> None:
        names = [one.name for one in found.values()]
        twice = next((name for name in names if names.count(name) > 1 or name == UNCORRECTED), None)
        if twice:
            where = f"{self.path}: gate.{index}.calibrator"
            do = "rename one of them: NAME=module:object"
            raise InputError(f"two calibrators are called {twice!r}", where=where, do=do)

    def _entry(self, index: int, design: Design, rows: Mapping[str, str]) -> GateEntry:
        gate = self.file.gate[index]
        plan = plan_gate(gate, self.file.rate, f"{self.path}: gate.{index}")
        with self._at(index, "calibrator"):
            calibrator = _row_of(gate.calibrator, rows, design)
        with self._at(index, "reference"):
            bounded = gate.reference == BOUND
            reference = None if bounded or gate.reference is None else _row_of(gate.reference, rows, design)
            bound = BoundReference.of(gate, calibrator, design) if bounded else None
        values = None
        if gate.baseline is not None and self.baselines:
            with self._at(index, "baseline"):
                file = self.path.parent / gate.baseline
                values = read_baseline(file, design, calibrator, gate.score_definition.name, plan.max_trials)
        return GateEntry(GateProgress(plan), calibrator, reference, values, bound)

    @contextmanager
    def _at(self, index: int, key: str) -> Iterator[None]:
        """Add the gate and the key to the place named by an InputError."""
        try:
            yield
        except InputError as error:
            where = f"{self.path}: gate.{index}.{key}"
            raise InputError(error.what, where=": ".join(filter(None, (where, error.where))), do=error.do) from None


def _row_of(text: str, rows: Mapping[str, str], design: Design) -> str:
    """Return the row of a trial for a calibrator text with or without sensor."""
    name, at, sensor = text.partition("@")
    return row_in(design, rows[name] + at + sensor)


def row_in(design: Design, row: str) -> str:
    """Return `row` where trials hold the row; InputError for an unknown row or a missing sensor."""
    if row not in design.calibrators:
        do = closest(row, design.calibrators, most=len(design.calibrators))
        raise InputError(f"{row!r} is none of the trial's rows", do=do)
    return row
