"""`magbench.diagnose`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, cast

from magbench.api.inputs import (
    Data,
    in_keywords,
    locked,
    path_of,
    reading_from,
    recording_from,
    reference_from,
    stated_field,
    tasks_on,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from calib.reference import Reference
    from diagnosis.policy import Policy
    from diagnosis.question import Question, Source
    from magbench.api.diagnosis_results import DiagnosisResult, PooledDiagnosisResult
    from recordings.reading import Reading


@in_keywords()
def diagnose(
    data: Data | Sequence[str | PathLike[str]],
    model: str | Path | None = None,
    *,
    field_strength_nT: float | None = None,
    field_enu_nT: Sequence[float] | None = None,
    confirm: Data | None = None,
    time_s: ArrayLike | None = None,
    policy: Policy | None = None,
    actuators: Sequence[str] = (),
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int | None = 0,
    sensor: int | None = None,
    reference_sensor: int | None = None,
    scheduler: str | None = None,
    out: str | PathLike[str] | None = None,
    say: Callable[[str], object] = lambda what: None,
) -> DiagnosisResult | PooledDiagnosisResult:
    """Find where a recording and a model disagree, and name the missing effect; data and reference as in `calibrate`.

    data : or a list of paths: several recordings of one instrument, diagnosed together.
    model : a scenario's name, or a file of it or of its [field] and [effects.*] alone; without it hard iron, soft iron
        and white noise, fitted; so with a calibration's file, as of `magbench.recheck`, whose answer is in the result's
        `stated`, the page and the JSON. confirm : a second recording, in which the finding must hold too. actuators :
        channels to treat like motor currents. time_s : (n,) of `data`, where that is an array. policy : the numbers
        that decide.
        run : of a dataset directory; None: all of its runs together. sensor : which of an array of sensors, counted
        from 1. reference_sensor : the one whose reading is the field.
    scheduler : address of a Dask cluster, which examines several recordings; no figure changes.
    out : directory for report.html, diagnosis.json, model.toml and recording.rrd. say : called with each stage.

    Raises InputError for data, models and references that cannot be used.

    >>> import magbench
    >>> import numpy as np
    >>> recording, truth = magbench.simulate("tumble", overrides=["phases.0.duration_s=60"])
    >>> strength_nT = float(np.linalg.norm(truth.field_nT[0]))
    >>> found = magbench.diagnose(recording, field_strength_nT=strength_nT)
    >>> found.verdict.explained, len(found.named) > 0
    (True, True)
    """
    from diagnosis.question import answer
    from magbench.api.diagnosis_results import diagnosis_result
    from magbench.api.stated_calibration import stated_iron

    read = reading_from(data, maps, reading)
    sources = _sources(data, time_s, read, run, sensor, reference_sensor)
    field = stated_field(field_strength_nT, field_enu_nT, read)
    question = _question(model, field, actuators, policy)
    with locked(out) as place:
        stated = stated_iron(model, sources, *field)
        seen = answer(question, sources, _second(confirm, sources, read), say, tasks_on(scheduler))
        found = diagnosis_result(seen, stated)
        _write(found, place, sources, say)
    return found


def _question(
    model: str | Path | None,
    field: tuple[float | None, Sequence[float] | None],
    actuators: Sequence[str],
    policy: Policy | None,
) -> Question:
    """The question about a model, and the field's strength and vector; iron is fitted in place of a calibration."""
    from diagnosis.policy import STANDARD
    from diagnosis.question import Question
    from magbench.api.stated_calibration import is_calibration

    return Question.about(
        None if is_calibration(model) else model,
        strength_nT=field[0],
        field_enu_nT=field[1],
        actuators=actuators,
        policy=policy or STANDARD,
    )


def _second(confirm: Data | None, sources: Sequence[Source], reading: Reading) -> Source | None:
    """The recording that confirms, of the same run and sensors as the first; InputError beside several."""
    from diagnosis.question import CONFIRM, check_single

    if confirm is None:
        return None
    check_single(sources, CONFIRM)
    first = sources[0]
    (second,) = _sources(confirm, None, reading, first.run, first.sensor, first.reference_sensor)
    return second


def _write(
    found: DiagnosisResult | PooledDiagnosisResult,
    out: Path | None,
    sources: Sequence[Source],
    say: Callable[[str], object],
) -> None:
    if out is None:
        return
    from magbench.api.diagnosis_results import DiagnosisResult
    from reports.outputs.diagnosis import write_diagnosis, write_pooled_diagnosis

    say("report and recording")
    if isinstance(found, DiagnosisResult):
        write_diagnosis(found.presented, out, f"Diagnosis of {sources[0].name}")
    else:
        folders = write_pooled_diagnosis(found.presented, out, f"Diagnosis of {len(sources)} {found.scope.key}")
        say(f"each by itself: {', '.join(folders)}")


def _sources(
    data: Data | Sequence[str | PathLike[str]],
    time_s: ArrayLike | None,
    reading: Reading,
    run: int | None,
    sensor: int | None,
    reference_sensor: int | None,
) -> tuple[Source, ...]:
    """The recordings of the argument: files, or one recording in memory."""
    from diagnosis.question import Source, file_sources

    if isinstance(data, str | PathLike):
        return file_sources([path_of(data)], run, sensor, reading, reference_sensor)
    if isinstance(data, list | tuple) and data and all(isinstance(one, str | PathLike) for one in data):
        return file_sources([path_of(one) for one in data], run, sensor, reading, reference_sensor)
    name, place = "recording", Path("recording")
    read = partial(recording_from, data, time_s=time_s, reading=reading)
    return (Source(name, place, read, partial(_own_reference, cast("Data", data)), 0, sensor, reference_sensor),)


def _own_reference(
    data: Data, strength_nT: float | None, field_enu_nT: Sequence[float] | None, remedy: str
) -> Reference:
    return reference_from(data, 0, strength_nT, field_enu_nT)
