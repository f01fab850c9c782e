"""The question of a diagnosis, of model, known field and channels of motors, its sources, and its answer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from calib.numerics.threads import one_thread
from calib.reference import Reference
from diagnosis.next_leg.advice import advised
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.sensors import BY_MODEL, model_of_sensor, needs_field, one_sensor, with_actuators
from diagnosis.result import Diagnosis
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.transfer import confirmed
from diagnosis.several.workflow import check_apart, diagnose_sensors, diagnose_together
from diagnosis.workflow import Progress, diagnose
from recordings import Recording, read_recording
from recordings.channels import may_be_cause
from recordings.importer import sensors_in
from recordings.manifest import file_of, is_dataset, read_manifest
from recordings.reading import Reading
from scenarios.arrays import Array
from scenarios.errors import InputError, errors_relocated
from sim.pool import Tasks
from sim.scenario import Model, ModelSpec, load_model
from validation.calibrating.reference import reference_of, told_field

CONFIRM = "--confirm"
Field = tuple[Array | None, float | None]
"""The field vector (3,) and the strength in nT; None where unknown."""
Stated = Callable[[float | None, Sequence[float] | None, str], Reference]
"""(strength in nT, field vector in nT, further remedy) -> the stated reference, else the source's own."""


@dataclass(frozen=True)
class Source:
    """A recording before it is read.

    name : unique among the sources. place : file, for error messages. read, reference : see `Stated`.
    run : of a dataset. sensor, reference_sensor : of an array, counted from 1.
    """

    name: str
    place: Path
    read: Callable[[], Recording]
    reference: Stated
    run: int = 0
    sensor: int | None = None
    reference_sensor: int | None = None

    @classmethod
    def of_file(cls, file: Path, name: str, run: int = 0, reading: Reading | None = None) -> Self:
        """The source of one run's file or measured log."""
        return cls(name, file, partial(read_recording, file, reading=reading), partial(reference_of, file), run)


def file_sources(
    paths: Sequence[Path],
    run: int | None,
    sensor: int | None = None,
    reading: Reading | None = None,
    reference_sensor: int | None = None,
) -> tuple[Source, ...]:
    """The sources in files and dataset directories; of a dataset all runs unless `run` selects one.

    Of a single recording by an array every sensor is a source, as `name@1` and so on, unless `sensor` selects one.
    Raises InputError for a run that does not exist, and for several recordings by an array without a sensor.
    """
    found: list[Source] = []
    for path in paths:
        runs = range(read_manifest(path).runs) if is_dataset(path) and run is None else (run or 0,)
        suffix = " run {}" if len(runs) > 1 else ""
        stem = path.resolve().name if path.is_dir() else path.stem
        found += [Source.of_file(file_of(path, k), stem + suffix.format(k), k, reading) for k in runs]
    separate = _by_sensor(_distinct(found), sensor, reading, reference_sensor)
    return tuple(replace(source, reference_sensor=reference_sensor) for source in separate)


def _by_sensor(
    found: Sequence[Source], sensor: int | None, reading: Reading | None, reference_sensor: int | None
) -> Sequence[Source]:
    """The selected sensor of each source; else all sensors of a single array but the reference."""
    if sensor is not None:
        return [replace(source, sensor=sensor) for source in found]
    arrays = [sensors_in(source.place, reading) for source in found]
    if len(found) == 1 and len(arrays[0]) > 1:
        (whole,) = found
        return [replace(whole, name=f"{whole.name}@{k}", sensor=k) for k in arrays[0] if k != reference_sensor]
    for source, sensors in zip(found, arrays, strict=True):
        if len(sensors) > 1:
            what = f"an array of {len(sensors)} sensors among several recordings"
            raise InputError(what, where=str(source.place), do="select one with --sensor, or give one recording")
    return found


def _distinct(found: Sequence[Source]) -> list[Source]:
    """The sources with their folder before equal names, and a number after names that are still equal."""
    count = Counter(source.name for source in found)
    names = [f"{s.place.resolve().parent.name} {s.name}" if count[s.name] > 1 else s.name for s in found]
    again = Counter(names)
    unique = [f"{name} {i + 1}" if again[name] > 1 else name for i, name in enumerate(names)]
    return [replace(source, name=name) for source, name in zip(found, unique, strict=True)]


def of_one_array(found: Sequence[Source]) -> bool:
    """Whether the sources are the sensors of one recording."""
    return len({s.sensor for s in found}) == len(found) > 1 == len({(s.place, s.run) for s in found})


def check_single(found: Sequence[Source], option: str) -> None:
    """InputError where an option for one recording is given beside several, or beside all sensors of an array."""
    if len(found) > 1:
        kind, do = ("sensor", "select one with --sensor") if of_one_array(found) else ("recording", "give one, or all")
        raise InputError(f"needs one {kind}, and there are {len(found)}", where=option, do=do)


@dataclass(frozen=True)
class Question:
    """The question put to every recording.

    model : compared with the recording; with `fitted_base` its hard and soft iron are unknown and fitted.
    field_enu_nT, strength_nT : the stated reference; None: the model's field, else the reference of the source.
    actuators : channels treated like motor currents. policy : the numbers that decide.
    """

    model: Model = field(default_factory=ModelSpec)
    fitted_base: bool = False
    field_enu_nT: Sequence[float] | None = None
    strength_nT: float | None = None
    actuators: Sequence[str] = ()
    policy: Policy = STANDARD

    @classmethod
    def about(cls, model: str | Path | None, **stated: Any) -> Self:
        """The question about a scenario or model file; without one iron and white noise are fitted.

        Raises InputError for a model that cannot be used.
        """
        return cls(load_model(model) if model else ModelSpec(), model is None, **stated)

    def model_for(self, source: Source) -> Model:
        """The model of the source's sensor."""
        return model_of_sensor(self.model, source.sensor)

    def recording(self, source: Source) -> Recording:
        """The recording of one sensor, with its reference sensor and actuators; InputError for bad files and names."""
        whole = one_sensor(source.read().in_nT(str(source.place)), source.sensor, source.reference_sensor, source.place)
        kept = {name: x for name, x in whole.channels.items() if may_be_cause(name) or name in self.actuators}
        return with_actuators(replace(whole, channels=kept), self.actuators, source.place)

    def known_field(self, source: Source, recording: Recording) -> Field:
        """The reference of a recording; both None where the model or a second magnetometer gives the field."""
        stated = self.field_enu_nT is not None or self.strength_nT is not None
        if not needs_field(recording, self.model_for(source), stated=stated):
            return None, None
        known = source.reference(
            *told_field(self.strength_nT, self.field_enu_nT, recording.origin, recording.mag_nT), BY_MODEL
        )
        return None if known.field_enu_nT is None else np.array(known.field_enu_nT), known.strength_nT

    def posed(self, source: Source) -> LinearProblem:
        """The linear problem of a source; InputError where model and recording do not fit."""
        recording, iron_known = self.recording(source), not self.fitted_base
        with errors_relocated(source.name, "recording"):
            known = self.known_field(source, recording)
            return pose_model(recording, self.model_for(source), *known, iron_known=iron_known, policy=self.policy)


@one_thread()
def answer(
    question: Question,
    sources: Sequence[Source],
    confirm: Source | None = None,
    say: Progress = lambda what: None,
    cluster: Tasks | None = None,
) -> Diagnosis | PooledDiagnosis:
    """Diagnose the sources: a single recording, several recordings together, or the sensors of an array.

    confirm : a second recording, in which the causes found in a single recording must hold too.
    say : called with each stage. cluster : examines several recordings, each a task.
    Raises InputError for files, columns, models and references that cannot be used.
    """
    if len(sources) == 1:
        return _answer_single(question, sources[0], confirm, say)
    problems = [question.posed(source) for source in sources]
    names, models = [source.name for source in sources], [question.model_for(source) for source in sources]
    if of_one_array(sources):
        return diagnose_sensors(names, problems, models, say=say)
    return diagnose_together(names, problems, models[0], cluster=cluster, say=say)


def _answer_single(question: Question, source: Source, confirm: Source | None, say: Progress) -> Diagnosis:
    model, recording = question.model_for(source), question.recording(source)
    second = None if confirm is None else question.recording(confirm)
    if second is not None:
        check_apart(recording, second, CONFIRM)
    known = question.known_field(source, recording)
    found = diagnose(recording, model, *known, fitted_base=question.fitted_base, policy=question.policy, say=say)
    if second is not None:
        say("the second recording")
        with errors_relocated(CONFIRM, "recording"):
            found = confirmed(found, second, model, *known)
    say("what to fly next")
    return advised(found)
