"""Several recordings read from files: every run of a dataset, each with its own reference."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.actuators import with_actuators
from diagnosis.problem.array_sensor import model_of_sensor, one_sensor
from diagnosis.problem.formulation import posed
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.relative import BY_MODEL, needs_field
from diagnosis.several.array import diagnose_sensors
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.workflow import diagnose_together
from recordings import read_recording
from recordings.importer import sensors_in
from recordings.manifest import file_of, read_manifest
from scenarios.errors import InputError, errors_relocated
from sim.scenario import Model, ModelSpec, load_model
from validation.calibrating.reference import reference_of


@dataclass(frozen=True)
class Source:
    """A file with one recording, by a name that tells it from the others.

    sensor: which of an array, from 1; reference: the sensor that is its reference.
    """

    name: str
    file: Path
    run: int
    sensor: int | None = None
    reference: int | None = None


def sources(
    measured: Sequence[Path],
    run: int | None,
    sensor: int | None = None,
    maps: Sequence[str] = (),
    reference: int | None = None,
) -> tuple[Source, ...]:
    """The files that users name; of a dataset with several runs all of them, unless one is asked for.

    Of one recording by an array every sensor, as `name@1` and so on, unless one is asked for.
    Raises InputError for runs that are not there, and for several recordings by an array without a sensor.
    """
    found = []
    for path in measured:
        runs = range(read_manifest(path).runs) if path.is_dir() and run is None else (run or 0,)
        several = " run {}" if len(runs) > 1 else ""
        found += [Source(_stem(path) + several.format(one), file_of(path, one), one) for one in runs]
    return tuple(replace(one, reference=reference) for one in _by_sensor(_told_apart(found), sensor, maps, reference))


def _by_sensor(
    found: Sequence[Source], sensor: int | None, maps: Sequence[str], reference: int | None
) -> tuple[Source, ...]:
    """The same by one sensor of each, where it is asked for; else by all of the one recording but a reference."""
    if sensor is not None:
        return tuple(replace(one, sensor=sensor) for one in found)
    arrays = [sensors_in(one.file, maps) for one in found]
    if len(found) == 1 and len(arrays[0]) > 1:
        return tuple(replace(found[0], name=f"{found[0].name}@{k}", sensor=k) for k in arrays[0] if k != reference)
    for one, sensors in zip(found, arrays, strict=True):
        if len(sensors) > 1:
            what = f"an array of {len(sensors)} sensors among several recordings"
            raise InputError(what, where=str(one.file), do="say which sensor with --sensor, or give one recording")
    return tuple(found)


def of_one_array(found: Sequence[Source]) -> bool:
    """Whether these are the sensors of one recording."""
    return len({one.sensor for one in found}) == len(found) > 1 == len({(one.file, one.run) for one in found})


def _stem(path: Path) -> str:
    return path.resolve().name if path.is_dir() else path.stem


def _told_apart(found: Sequence[Source]) -> tuple[Source, ...]:
    """The same where equal names have their folder before them, and their number if that is equal too."""
    count = Counter(one.name for one in found)
    apart = [f"{one.file.resolve().parent.name} {one.name}" if count[one.name] > 1 else one.name for one in found]
    again = Counter(apart)
    names = [f"{name} {i + 1}" if again[name] > 1 else name for i, name in enumerate(apart)]
    return tuple(Source(name, one.file, one.run) for name, one in zip(names, found, strict=True))


def check_one(found: Sequence[Source], option: str) -> None:
    """InputError where an option for one recording is given beside several, or beside all sensors of an array."""
    if len(found) > 1:
        array = of_one_array(found)
        what = f"is asked beside one {'sensor' if array else 'recording'}, and here are several"
        do = "say which with --sensor" if array else "give one, or all without it: they are held against each other"
        raise InputError(what, where=option, do=do)


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
) -> PooledDiagnosis:
    """Diagnose files together against a model file or scenario; without one against fitted iron and white noise.

    The sensors of one array are compared, see `diagnose_sensors`.
    The reference is what the caller states, else the model's field, else what each file says of its own.
    Raises InputError for files, columns, models and references that cannot be used.
    """
    whole = load_model(model) if model else ModelSpec()

    def problem(one: Source) -> LinearProblem:
        spec = model_of_sensor(whole, one.sensor)
        vector = strength = None
        whole_one = read_recording(one.file, run=one.run, maps=maps)
        read = one_sensor(whole_one, one.sensor, one.reference, one.file)
        if needs_field(read, spec, stated=enu is not None or strength_nT is not None):
            known = reference_of(one.file, strength_nT, enu, BY_MODEL)
            vector = None if known.field_enu_nT is None else np.array(known.field_enu_nT)
            strength = known.strength_nT
        recording = with_actuators(read, actuators, one.file)
        with errors_relocated(one.name, "recording"):
            return posed(recording, spec, vector, strength, iron_known=model is not None, policy=policy)

    return _compared(measured, [problem(one) for one in measured], whole, say)


def _compared(
    measured: Sequence[Source], problems: Sequence[LinearProblem], model: Model, say: Callable[[str], object]
) -> PooledDiagnosis:
    names, models = [one.name for one in measured], [model_of_sensor(model, one.sensor) for one in measured]
    if of_one_array(measured):
        return diagnose_sensors(names, problems, models, say=say)
    return diagnose_together(names, problems, models[0], say=say)
