"""Calibrators on a recording: which reference holds, every sensor of an array, results to disk."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib import Calibration, Reference
from recordings import Recording, read_recording
from recordings.checks import FIELD_RANGE_NT
from recordings.manifest import file_of
from recordings.reader import parameters_of
from recordings.units import likely_unit
from scenarios.errors import InputError
from validation.calibrating.candidates import CalibratorEntry


@dataclass(frozen=True)
class SensorFit:
    """A calibrator's answer on one sensor.

    key: `name`, or `name@sensor` of an array, sensors counted from 1; sensor: the same from 0; recording: what that
    sensor gave; cpu_s: processor time of the fit, of whole arrays that of all sensors.
    """

    key: str
    sensor: int
    recording: Recording
    calibration: Calibration
    cpu_s: float


def fits(
    recording: Recording,
    reference: Reference,
    chosen: Sequence[CalibratorEntry],
    rng: Callable[[], np.random.Generator] = lambda: np.random.default_rng(0),
    progress: Callable[[float], object] = lambda part: None,
) -> Iterator[SensorFit]:
    """Every chosen calibrator on a recording, of an array on every sensor; each fit begins with a generator of its own.

    A calibrator of whole arrays gets the recording once, and each sensor its part of the result.
    `progress` is told the part that is done.
    """
    for done, candidate in enumerate(chosen):
        progress(done / len(chosen))
        parts = sensors(recording, candidate.name)
        whole = candidate.timed(recording, reference, rng()) if candidate.whole_array else None
        for sensor, (key, one) in enumerate(parts.items()):
            if whole is None:
                found = candidate.timed(one, reference, rng())
                yield SensorFit(key, sensor, one, found.calibration, found.cpu_s)
            else:
                yield SensorFit(key, sensor, one, whole.calibration.of_sensor(sensor), whole.cpu_s)


def fit_all(recording: Recording, reference: Reference, chosen: Sequence[CalibratorEntry]) -> dict[str, Calibration]:
    """Every chosen calibrator's calibration, by the key of its fit."""
    return {fit.key: fit.calibration for fit in fits(recording, reference, chosen)}


def sensors(recording: Recording, name: str) -> dict[str, Recording]:
    """The recording of each sensor under the key of its calibration: `name`, or `name@1` ... for an array."""
    if recording.array_mag_nT is None:
        return {name: recording}
    return {f"{name}@{k + 1}": recording.sensor(k) for k in range(len(recording.array_mag_nT))}


def recording_and_reference(
    path: Path,
    *,
    run: int = 0,
    maps: Sequence[str] = (),
    strength_nT: float | None = None,
    enu: Sequence[float] | None = None,
) -> tuple[Recording, Reference]:
    """What a run, a dataset or a measured log holds, and the reference: what is stated, else what a run's file says.

    Raises InputError for a file that cannot be used and where no reference is known.
    """
    file = file_of(path, run)
    return read_recording(file, maps=maps), reference_of(file, strength_nT, enu)


def not_applicable(results: Mapping[str, Calibration]) -> list[str]:
    """A line for each calibrator that could not be used on the recording."""
    refused = {name: found.status for name, found in results.items() if found.status.kind == "not_applicable"}
    return [f"{name} was not applicable: {status.reason}" for name, status in refused.items()]


def reference_of(file: Path, strength_nT: float | None, enu: Sequence[float] | None, otherwise: str = "") -> Reference:
    """The reference that the caller states, else the field that a simulated run's file names.

    Raises InputError for none, with what else would do `otherwise`.
    """
    if strength_nT is not None or enu is not None:
        return stated_reference(str(file), strength_nT, enu)
    known = parameters_of(file).get("field_enu_nT")
    if known is None:
        raise _unknown_field(str(file), otherwise)
    return stated_reference(str(file), None, known, f"{file}: field_enu_nT of its metadata")


def _unknown_field(where: str, otherwise: str = "") -> InputError:
    do = f"give --field-strength-nT F or --field-enu-nT E,N,U{otherwise}"
    return InputError("the field at this place is not known", where=where, do=do)


def stated_reference(
    where: str, strength_nT: float | None, enu: Sequence[float] | None, enu_from: str = "--field-enu-nT"
) -> Reference:
    """The reference of a strength, of a vector (east, north, up), or of both, nT; InputError for neither."""
    if strength_nT is None and enu is None:
        raise _unknown_field(where)
    if strength_nT is not None:
        _check_strength(strength_nT, "--field-strength-nT")
    if enu is None:
        assert strength_nT is not None
        return Reference(strength_nT)
    if len(enu) != 3:
        raise InputError(f"{enu!r} is not a field vector", where=enu_from, do="give east, north and up in nT")
    _check_strength(math.hypot(*enu), enu_from)
    strength = float(np.linalg.norm(enu)) if strength_nT is None else strength_nT
    return Reference(strength, (enu[0], enu[1], enu[2]))


def _check_strength(strength_nT: float, where: str) -> None:
    """The range that measured logs are held to; a strength in uT would scale every result by a thousand."""
    low, high = FIELD_RANGE_NT
    if not low <= strength_nT <= high:
        unit = likely_unit(strength_nT)
        guess = f": it looks like {unit}" if unit else ""
        what = f"a field of {strength_nT:g} nT is not between {low:,.0f} and {high:,.0f} nT{guess}"
        raise InputError(what, where=where, do="give it in nT")
