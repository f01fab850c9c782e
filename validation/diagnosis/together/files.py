"""Several recordings read from files: every run of a dataset, each with its own reference."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim.dataset import read_recording
from sim.dataset.manifest import file_of, read_manifest
from sim.scenario import ModelSpec, load_model
from validation.calibrating.fitting import reference_of
from validation.diagnosis.files import with_actuators
from validation.diagnosis.policy import STANDARD, Policy
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.problem.pose import posed
from validation.diagnosis.together.result import Together
from validation.diagnosis.together.workflow import diagnose_together


@dataclass(frozen=True)
class Source:
    """A file with one recording, by a name that tells it from the others."""

    name: str
    file: Path
    run: int


def sources(measured: Sequence[Path], run: int | None) -> tuple[Source, ...]:
    """The files that users name; of a dataset with several runs all of them, unless one is asked for.

    Raises InputError for runs that are not there.
    """
    found = []
    for path in measured:
        runs = range(read_manifest(path).runs) if path.is_dir() and run is None else (run or 0,)
        several = " run {}" if len(runs) > 1 else ""
        found += [Source(_stem(path) + several.format(one), file_of(path, one), one) for one in runs]
    return _told_apart(found)


def _stem(path: Path) -> str:
    return path.resolve().name if path.is_dir() else path.stem


def _told_apart(found: Sequence[Source]) -> tuple[Source, ...]:
    """The same where equal names have their folder before them, and their number if that is equal too."""
    count = Counter(one.name for one in found)
    apart = [f"{one.file.resolve().parent.name} {one.name}" if count[one.name] > 1 else one.name for one in found]
    again = Counter(apart)
    names = [f"{name} {i + 1}" if again[name] > 1 else name for i, name in enumerate(apart)]
    return tuple(Source(name, one.file, one.run) for name, one in zip(names, found, strict=True))


def diagnose_files(
    measured: Sequence[Source],
    model: str | None,
    *,
    enu: Sequence[float] | None = None,
    strength_nT: float | None = None,
    maps: Sequence[str] = (),
    actuators: Sequence[str] = (),
    policy: Policy = STANDARD,
    say: Callable[[str], object] = lambda what: None,
) -> Together:
    """Diagnose files together against a model file or scenario; without one against fitted iron and white noise.

    The reference is what the caller states, else the model's field, else what each file says of its own.
    Raises InputError for files, columns, models and references that cannot be used.
    """
    spec = load_model(model) if model else ModelSpec()

    def problem(one: Source) -> LinearProblem:
        vector = strength = None
        if enu is not None or strength_nT is not None or spec.field is None:
            known = reference_of(one.file, strength_nT, enu)
            vector = None if known.field_enu_nT is None else np.array(known.field_enu_nT)
            strength = known.strength_nT
        recording = with_actuators(read_recording(one.file, run=one.run, maps=maps), actuators, one.file)
        return posed(recording, spec, vector, strength, iron_known=model is not None, policy=policy)

    problems = [problem(one) for one in measured]
    return diagnose_together([one.name for one in measured], problems, spec, say=say)
