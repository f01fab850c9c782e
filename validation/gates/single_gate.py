"""Single gate with trials computed in the calling process, so the calibrator may be an object in memory."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from pydantic import ValidationError

from scenarios.errors import InputError
from scenarios.problems import first_problem, problem_at
from sim.scenario import Scenario
from validation.calibrating.calibrator_entry import CalibratorEntry
from validation.calibrating.processes import TIME_LIMIT_S
from validation.calibrating.selection import select_calibrator
from validation.comparison.design import Design, DesignPoint
from validation.comparison.trial import run_trial
from validation.gates.gate_file import GateFile
from validation.gates.gate_groups import GateEntry, row_in
from validation.gates.gate_outcome import GateOutcome, GateProgress
from validation.gates.gate_plan import plan_gate
from validation.gates.score_baseline import read_baseline
from validation.scoring.evaluation import UNCORRECTED

OF_SENSOR = re.compile(r"([^{}]+)(@\d+)")
"""`name@2` or `module:object@2`; a command has braces."""
LONGEST_NAME = 100
REFERENCE = "reference"
"""Name of a reference whose name would equal the calibrator's."""


@dataclass(frozen=True)
class GateSubject:
    """Calibrator read by a gate, None for the raw measurement; at_sensor : `@2` for sensor 2 of an array."""

    entry: CalibratorEntry | None
    at_sensor: str = ""

    @classmethod
    def of(cls, found: object, time_limit_s: float = TIME_LIMIT_S) -> Self:
        """Resolve `uncorrected`, or any argument of `select_calibrator`; a text may end with the sensor."""
        sensed = OF_SENSOR.fullmatch(found) if isinstance(found, str) else None
        which, at_sensor = sensed.groups() if sensed else (found, "")
        one = None if which == UNCORRECTED else select_calibrator(which, time_limit_s)
        if one and one.name == UNCORRECTED:
            raise InputError(f"{UNCORRECTED!r} is the raw measurement's name", do="rename the calibrator")
        return cls(one, at_sensor)

    @property
    def row(self) -> str:
        """Row name in a trial."""
        return (self.entry.name if self.entry else UNCORRECTED) + self.at_sensor


def decide_single_gate(
    calibrator: object,
    reference: object | None,
    scenario: Scenario,
    keys: Mapping[str, Any],
    options: Mapping[str, Any],
) -> GateOutcome:
    """Run trials one by one until a gate on a scenario is decided or out of trials.

    keys : further keys of a [[gate]]. options : top-level keys of a gate file. A value of None means the default.
    Raises InputError for invalid keys, options, calibrators and references.
    """
    time_limit_s = options.get("time_limit_s") or TIME_LIMIT_S
    with _named("calibrator"):
        first = GateSubject.of(calibrator, time_limit_s)
    with _named("reference"):
        second = None if reference is None else _renamed(GateSubject.of(reference, time_limit_s), first)
    names = {"calibrator": first.row, "reference": second.row if second else None, "scenario": scenario.name}
    file = _checked({**keys, **names}, options)
    found = tuple(one.entry for one in (first, second) if one and one.entry)
    design = Design((DesignPoint({}, scenario),), found, scenario.seed if file.seed is None else file.seed)
    return _decided(file, design)


def _decided(file: GateFile, design: Design) -> GateOutcome:
    (gate,) = file.gate
    plan = plan_gate(gate, file.rate, "assert_accuracy")
    with _named("calibrator"):
        row = row_in(design, gate.calibrator)
    with _named("reference"):
        reference = None if gate.reference is None else row_in(design, gate.reference)
    baseline = None
    if gate.baseline is not None:
        baseline = read_baseline(Path(gate.baseline), design, row, gate.score_definition.name, plan.max_trials)
    progress = GateProgress(plan)
    entry = GateEntry(progress, row, reference, baseline)
    while not progress.finished:
        run = len(progress.trials)
        rows = {one.calibrator: one for one in run_trial(design, 0, run).rows}
        progress.add(entry.read_trial(run, rows))
    return GateOutcome.of(progress)


def _renamed(reference: GateSubject, calibrator: GateSubject) -> GateSubject:
    """Rename the reference where its name equals the calibrator's."""
    if reference.entry and calibrator.entry and reference.entry.name == calibrator.entry.name:
        return replace(reference, entry=replace(reference.entry, name=REFERENCE))
    return reference


def _checked(gate: Mapping[str, Any], options: Mapping[str, Any]) -> GateFile:
    name = f"{gate['calibrator']} on {gate['scenario']}"[:LONGEST_NAME]
    try:
        return GateFile.model_validate({"gate": ({"name": name, **_stated(gate)},), **_stated(options)})
    except ValidationError as error:
        path, what, do = first_problem(error, GateFile)
        raise problem_at("", path[2:] if path[0] == "gate" else path, what, do) from None


def _stated(keys: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in keys.items() if value is not None}


@contextmanager
def _named(argument: str) -> Iterator[None]:
    """Name an argument as the place of an InputError."""
    try:
        yield
    except InputError as error:
        raise InputError(error.what, where=argument, do=error.do) from None
