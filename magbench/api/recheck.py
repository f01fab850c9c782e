"""`magbench.recheck`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.api.inputs import Data, in_keywords, path_of, reading_from, recording_from, reference_from
from scenarios.errors import InputError

if TYPE_CHECKING:
    from calib.reference import Reference
    from calib.result import Calibration
    from magbench.api.recheck_result import RecheckResult
    from recordings import Recording
    from recordings.reading import Reading

APPLIED = "applied"
"""In place of a file: the calibration that the autopilot had in force when it wrote the log."""


@in_keywords()
def recheck(
    old: Calibration | str | PathLike[str],
    data: Data,
    field_strength_nT: float | None = None,
    *,
    field_enu_nT: Sequence[float] | None = None,
    tolerance_deg: float | None = None,
    compass: str | None = None,
    old_unit: str | None = None,
    old_norm: float | None = None,
    sensor: int | None = None,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
) -> RecheckResult:
    """Whether an old calibration still holds for the instrument that wrote a log: valid, changed, cannot tell.

    old : a Calibration; a calibration.json; parameters of PX4, ArduPilot, Betaflight, INAV; MotionCal's, Magneto's and
        imu_calib's results; a C header or YAML of `calibrate`; "applied": the calibration in force in the log.
    data, field_strength_nT, field_enu_nT, maps, reading, run : as in `calibrate`. Without a field the strength is taken
        as the old calibration gives it.
    tolerance_deg : heading error by a change from which on the change matters, 1 degree by default.
    compass : which calibration of the file. old_unit : unit of a file that tells none: uT, ..., counts=NT_A_COUNT.
    old_norm : length of the field as the file's matrix gives it, such as 1. sensor : of an array, from 1.

    Raises InputError for a file that holds no calibration, a log that cannot be read, and a missing unit.

    >>> import magbench
    >>> import numpy as np
    >>> recording, truth = magbench.simulate("tumble", overrides=["phases.0.duration_s=60"])
    >>> strength_nT = float(np.linalg.norm(truth.field_nT[0]))
    >>> found = magbench.calibrate(recording, strength_nT)
    >>> magbench.recheck(found, recording, strength_nT).verdict
    'valid'
    """
    read = reading_from(data, maps, reading)
    whole = recording_from(data, reading=read, run=run)
    number = _sensor(whole, sensor)
    recording = whole if number is None else whole.sensor(number - 1)
    field = _field(data, run, field_strength_nT, field_enu_nT, read, recording)
    return judged(
        old, recording, field, tolerance_deg=tolerance_deg, compass=compass, scale=(old_unit, old_norm), sensor=number
    )


def judged(
    old: Calibration | str | PathLike[str],
    recording: Recording,
    field: Reference | None,
    *,
    tolerance_deg: float | None = None,
    compass: str | None = None,
    scale: tuple[str | None, float | None] = (None, None),
    sensor: int | None = None,
) -> RecheckResult:
    """The answer on a recording of one magnetometer; `sensor` is its number in an array."""
    from magbench.api.recheck_result import RecheckResult
    from validation.rechecking import recheck as judge

    known = _calibration(old, recording, compass, (*scale, field.strength_nT if field else None), sensor)
    found = judge.recheck(known, recording, field, judge.TOLERANCE_DEG if tolerance_deg is None else tolerance_deg)
    return RecheckResult.of(found, known, recording)


def _sensor(recording: Recording, sensor: int | None) -> int | None:
    """The sensor of an array, by default the first; None for a single magnetometer."""
    count = 1 if recording.array_mag_nT is None else len(recording.array_mag_nT)
    if sensor is not None and not 1 <= sensor <= count:
        raise InputError(f"there is no sensor {sensor}", where="--sensor", do=f"choose among 1 to {count}")
    return None if recording.array_mag_nT is None else sensor or 1


def _field(
    data: Data,
    run: int,
    strength_nT: float | None,
    enu_nT: Sequence[float] | None,
    reading: Reading,
    recording: Recording,
) -> Reference | None:
    """The reference of `calibrate`; None where nothing tells the field, and for counts."""
    if recording.origin.unit != "nT":
        return None
    try:
        return reference_from(data, run, strength_nT, enu_nT, reading, recording)
    except InputError:
        if strength_nT is not None or enu_nT is not None:
            raise
        return None


def _calibration(
    old: Calibration | str | PathLike[str],
    recording: Recording,
    compass: str | None,
    scale: tuple[str | None, float | None, float | None],
    sensor: int | None,
) -> Calibration:
    """The old calibration; counts of a log in counts are its own."""
    from calib.result import Calibration
    from validation.calibrating.parameter_files import chosen, read_parameter_file
    from validation.calibrating.parameter_files.file_format import FileScale

    if isinstance(old, Calibration):
        return old
    if str(old) == APPLIED and not Path(old).exists():
        return _in_force(recording)
    stated = FileScale.stated(*scale)
    if stated.nT is None and recording.origin.unit != "nT":
        stated = FileScale(1.0, stated.norm, stated.strength_nT)
    found = read_parameter_file(path_of(old), stated)
    applied = recording.origin.applied
    likely = [str(applied.compass)] if applied else []
    if sensor is not None:
        likely += [name for name in found if name.endswith(f"@{sensor}")]
    return found[chosen(found, compass, "--compass", likely)]


def _in_force(recording: Recording) -> Calibration:
    """The calibration that the log's autopilot applied; InputError for a log without."""
    from calib.result import Calibration, Status

    applied = recording.origin.applied
    if applied is None:
        do = "give a calibration.json, or the autopilot's parameters"
        raise InputError("the log tells of no calibration in force", where=APPLIED, do=do)
    name = f"{applied.autopilot}, compass {applied.compass}, in force"
    return Calibration(name=name, status=Status("ok"), offset_nT=applied.offset_nT, matrix=applied.matrix)
