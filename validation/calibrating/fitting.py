"""Calibrators fitted to a recording, sensor by sensor."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib import Calibration, Reference
from recordings import Recording
from validation.calibrating.calibrator_entry import CalibratorEntry


@dataclass(frozen=True)
class SensorFit:
    """Calibration of a sensor by a calibrator.

    key : `name`, or `name@sensor` of an array, sensors counted from 1. sensor : the index counted from 0.
    recording : of this sensor alone. cpu_s : processor time of the fit, of all sensors for a whole-array method.
    """

    key: str
    sensor: int
    recording: Recording
    calibration: Calibration
    cpu_s: float


def fit_all(recording: Recording, reference: Reference, chosen: Sequence[CalibratorEntry]) -> dict[str, Calibration]:
    """Fit every chosen calibrator and return the calibrations by `SensorFit.key`."""
    return {fit.key: fit.calibration for fit in sensor_fits(recording, reference, chosen)}


def sensor_fits(
    recording: Recording,
    reference: Reference,
    chosen: Sequence[CalibratorEntry],
    rng: Callable[[], np.random.Generator] = lambda: np.random.default_rng(0),
    progress: Callable[[float], object] = lambda part: None,
) -> Iterator[SensorFit]:
    """Fit every chosen calibrator to every sensor; a whole-array method fits once and yields one result per sensor.

    rng : makes a new generator for each fit. progress : called with the completed fraction.
    """
    for done, entry in enumerate(chosen):
        progress(done / len(chosen))
        parts = sensor_recordings(recording, entry.name)
        whole = entry.fit_timed(recording, reference, rng()) if entry.whole_array else None
        for sensor, (key, part) in enumerate(parts.items()):
            fit = whole or entry.fit_timed(part, reference, rng())
            calibration = whole.calibration.of_sensor(sensor) if whole else fit.calibration
            yield SensorFit(key, sensor, part, calibration, fit.cpu_s)


def sensor_recordings(recording: Recording, name: str) -> dict[str, Recording]:
    """Return each sensor's recording under the key of the sensor's calibration: `name`, of an array `name@1` ..."""
    if recording.array_mag_nT is None:
        return {name: recording}
    return {f"{name}@{k + 1}": recording.sensor(k) for k in range(len(recording.array_mag_nT))}


def not_applicable(results: Mapping[str, Calibration]) -> list[str]:
    """Return one line for each calibrator that was not applicable to the recording."""
    return [
        f"{name} was not applicable: {found.status.reason}"
        for name, found in results.items()
        if found.status.kind == "not_applicable"
    ]
