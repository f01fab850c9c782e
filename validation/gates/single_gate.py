"""One gate by itself, its trials computed in this process: its calibrator may be an object in memory."""

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
"""What a reference is called that has its calibrator's name."""


@dataclass(frozen=True)
class GateSubject:
    """Whose rows a gate reads: a candidate's, None for the raw measurement, and of an array which sensor's (`@2`)."""

    candidate: CalibratorEntry | None
    at_sensor: str = ""

    @classmethod
    def of(cls, found: object, time_limit_s: float = TIME_LIMIT_S) -> Self:
        """By `uncorrected`, or by what `candidate` takes; a text may end with the sensor."""
        sensed = OF_SENSOR.fullmatch(found) if isinstance(found, str) else None
        which, at_sensor = sensed.groups() if sensed else (found, "")
        one = None if which == UNCORRECTED else select_calibrator(which, time_limit_s)
        if one and one.name == UNCORRECTED:
            raise InputError(f"{UNCORRECTED!r} is the raw measurement's name", do="call the calibrator otherwise")
        return cls(one, at_sensor)

    @property
    def row(self) -> str:
        """The name of its row in a trial."""
        return (self.candidate.name if self.candidate else UNCORRECTED) + self.at_sensor


def decide_single_gate(
    calibrator: object,
    reference: object | None,
    scenario: Scenario,
    keys: Mapping[str, Any],
    options: Mapping[str, Any],
) -> GateOutcome:
    """Run trials one after the other until a gate on this scenario is decided, or out of trials.

    keys : the other keys of a [[gate]]; options : those at the top of a file of gates; None: as in a file that does not
    say. Raises InputError for whatever of these is not allowed or not there.
    """
    time_limit_s = options.get("time_limit_s") or TIME_LIMIT_S
    with _named("calibrator"):
        first = GateSubject.of(calibrator, time_limit_s)
    with _named("reference"):
        second = None if reference is None else _apart(GateSubject.of(reference, time_limit_s), first)
    names = {"calibrator": first.row, "reference": second.row if second else None, "scenario": scenario.name}
    file = _checked({**keys, **names}, options)
    found = tuple(one.candidate for one in (first, second) if one and one.candidate)
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
        progress.take(entry.reading(run, rows))
    return GateOutcome.of(progress)


def _apart(reference: GateSubject, calibrator: GateSubject) -> GateSubject:
    """The reference under another name, where the calibrator has its own."""
    if reference.candidate is None or calibrator.candidate is None:
        return reference
    if reference.candidate.name != calibrator.candidate.name:
        return reference
    return replace(reference, candidate=replace(reference.candidate, name=REFERENCE))


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
    """InputErrors from within name the argument."""
    try:
        yield
    except InputError as error:
        raise InputError(error.what, where=argument, do=error.do) from None
