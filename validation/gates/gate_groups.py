"""From a file of gates to what is to be run: gates on one scenario with the same overrides share its trials."""

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
from validation.bound.ratio import knowledge_of
from validation.bound.runs import RunBounds
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


@dataclass(frozen=True)
class GateEntry:
    """A gate among the trials of its group: which rows it reads, and how far it got; least: what its limit is of."""

    progress: GateProgress
    calibrator: str
    reference: str | None = None
    baseline: Array | None = None
    least: BoundReference | None = None

    def reading(self, run: int, rows: Mapping[str, TrialRow]) -> GateTrial:
        """What one trial, its rows by calibrator, says to the gate."""
        row, gate = rows[self.calibrator], self.progress.plan.gate
        score, other = value_of(row, gate), 1.0 if self.least is None else self.least.of(run)
        if self.reference is not None:
            other = value_of(rows[self.reference], gate)
        if self.baseline is not None:
            other = float(self.baseline[run])
        return GateTrial(score, other, "" if np.isfinite(score) else f"{row.status}: {row.reason}")


@dataclass(frozen=True)
class GateGroup:
    """Gates that share trials; `design` has its scenario at point `number`, which tells its trials from others'."""

    number: int
    design: Design
    entries: tuple[GateEntry, ...]

    @property
    def finished(self) -> bool:
        """Whether none of its gates needs another trial."""
        return all(entry.progress.finished for entry in self.entries)

    @property
    def most(self) -> int:
        """Trials after which all of its gates are finished."""
        return max(entry.progress.plan.max_trials for entry in self.entries)

    @property
    def looked(self) -> int:
        """Trials done with: all of them as soon as every gate is finished."""
        return self.most if self.finished else max(len(entry.progress.trials) for entry in self.entries)


def value_of(row: TrialRow, gate: Gate) -> float:
    """The gate's score in a row, infinite where there is none."""
    if gate.score_definition.name == FAILURE:
        return float(row.status != "ok")
    return row.scores.get(gate.score_definition.column, math.inf)


def group_gates(
    file: GateFile,
    path: Path,
    seed: int | None = None,
    time_limit_s: float | None = None,
    *,
    baselines: bool = True,
) -> tuple[GateGroup, ...]:
    """The groups of a file's gates, in its order; `path` is the file, beside which scenarios and baselines are.

    seed, time_limit_s : default the file's. baselines : whether they are read. Raises InputError for whatever a gate
    names and is not there, and for two commands of one name.
    """
    stated = {"seed": seed, "time_limit_s": time_limit_s}
    file = file.model_copy(update={key: value for key, value in stated.items() if value is not None})
    shared: dict[tuple[str, tuple[str, ...]], list[int]] = {}
    for index, gate in enumerate(file.gate):
        shared.setdefault((gate.scenario, gate.set_), []).append(index)
    builder = _Builder(file, path, _commands(file, path), baselines)
    return tuple(builder.group(number, indices) for number, indices in enumerate(shared.values()))


def _commands(file: GateFile, path: Path) -> dict[str, str]:
    """The commands of a file's programs, as --exec takes them, by name; they hold for every gate that says the name."""
    found: dict[str, str] = {}
    for index, gate in enumerate(file.gate):
        name = _name(gate.calibrator)
        if gate.command and found.setdefault(name, gate.command) != gate.command:
            where = f"{path}: gate.{index}.exec"
            raise InputError(f"{name!r} is another command in a gate before", where=where, do="choose another name")
    return found


def _name(text: str) -> str:
    """Of a calibrator without the sensor."""
    return text.partition("@")[0]


def _least_of(gate: Gate, calibrator: str, design: Design) -> BoundReference:
    """What any method reaches which is told as much; InputError where none is known in the first run."""
    scenario = design.points[-1].scenario
    one = next((one for one in design.candidates if one.name == _name(calibrator)), None)
    knowledge = None
    if one is not None:
        knowledge = knowledge_of(calibrator, one.needs, attitude_free=one.attitude_free, eddy=one.eddy)
    bounds = RunBounds(scenario, design.seed, frozenset({knowledge} if knowledge else ()))
    least = BoundReference(bounds, knowledge or "", gate.score_definition.column)
    if knowledge is None or not 0 < least.of(0) < math.inf:
        what = f"no bound is known on {gate.score_definition.name} of {calibrator} in {scenario.name}"
        raise InputError(what, do="name a calibrator as the reference, or give a limit")
    return least


@dataclass(frozen=True)
class _Builder:
    file: GateFile
    path: Path
    commands: Mapping[str, str]
    baselines: bool

    def group(self, number: int, indices: Sequence[int]) -> GateGroup:
        """The gates of these indices on their one scenario."""
        with self._at(indices[0], "scenario"):
            scenario = self._scenario(self.file.gate[indices[0]])
        found: dict[str, CalibratorEntry] = {}
        for index in indices:
            self._add_candidates(found, index)
        self._check_told_apart(found, indices[0])
        seed = scenario.seed if self.file.seed is None else self.file.seed
        design = Design((DesignPoint({}, scenario),) * (number + 1), tuple(found.values()), seed)
        rows = {text: one.name for text, one in found.items()} | {UNCORRECTED: UNCORRECTED}
        return GateGroup(number, design, tuple(self._entry(index, design, rows) for index in indices))

    def _scenario(self, gate: Gate) -> Scenario:
        beside = self.path.parent / gate.scenario
        return load(beside if beside.is_file() else gate.scenario, gate.set_)

    def _add_candidates(self, found: dict[str, CalibratorEntry], index: int) -> None:
        gate = self.file.gate[index]
        reference = None if gate.reference == BOUND else gate.reference
        for key, text in (("calibrator", gate.calibrator), ("reference", reference)):
            name = _name(text or UNCORRECTED)
            if name not in found and name != UNCORRECTED:
                with self._at(index, key):
                    command = self.commands.get(name)
                    named, programs = ((), (command,)) if command else ((name,), ())
                    (found[name],) = select_calibrators(named, programs, self.file.time_limit_s)

    def _check_told_apart(self, found: Mapping[str, CalibratorEntry], index: int) -> None:
        names = [one.name for one in found.values()]
        twice = next((name for name in names if names.count(name) > 1 or name == UNCORRECTED), None)
        if twice:
            where = f"{self.path}: gate.{index}.calibrator"
            do = "call one of them otherwise: NAME=module:object"
            raise InputError(f"two calibrators are called {twice!r}", where=where, do=do)

    def _entry(self, index: int, design: Design, rows: Mapping[str, str]) -> GateEntry:
        gate = self.file.gate[index]
        plan = plan_gate(gate, self.file.rate, f"{self.path}: gate.{index}")
        with self._at(index, "calibrator"):
            calibrator = _row_of(gate.calibrator, rows, design)
        with self._at(index, "reference"):
            bounded = gate.reference == BOUND
            reference = None if bounded or gate.reference is None else _row_of(gate.reference, rows, design)
            least = _least_of(gate, calibrator, design) if bounded else None
        values = None
        if gate.baseline is not None and self.baselines:
            with self._at(index, "baseline"):
                file = self.path.parent / gate.baseline
                values = read_baseline(file, design, calibrator, gate.score_definition.name, plan.max_trials)
        return GateEntry(GateProgress(plan), calibrator, reference, values, least)

    @contextmanager
    def _at(self, index: int, key: str) -> Iterator[None]:
        """InputErrors from within name the gate and its key."""
        try:
            yield
        except InputError as error:
            where = f"{self.path}: gate.{index}.{key}"
            raise InputError(error.what, where=": ".join(filter(None, (where, error.where))), do=error.do) from None


def _row_of(text: str, rows: Mapping[str, str], design: Design) -> str:
    """The row of a trial that a name stands for."""
    name, at, sensor = text.partition("@")
    return row_in(design, rows[name] + at + sensor)


def row_in(design: Design, row: str) -> str:
    """A row that trials have; of an array it has to say which sensor's. InputError for any other."""
    if row not in design.calibrators:
        do = closest(row, design.calibrators, most=len(design.calibrators))
        raise InputError(f"{row!r} is none of the trial's rows", do=do)
    return row
