"""Selection of one sensor of an array, in the recording and in the model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from recordings import Recording
from recordings.channels import REFERENCE
from scenarios.errors import InputError
from sim.scenario import Model, Scenario


def of_sensor(recording: Recording, sensor: int | None, where: str) -> Recording:
    """The recording of one sensor of an array, counted from 1; a recording of a single magnetometer is unchanged.

    Raises InputError for a number out of range, and for an array without a number.
    """
    array = recording.array_mag_nT
    count = 1 if array is None else len(array)
    if sensor is None and count > 1:
        raise InputError(f"an array of {count} sensors", where=where, do="say which with --sensor, counted from 1")
    if sensor is not None and not 1 <= sensor <= count:
        found = "one magnetometer" if array is None else f"the sensors 1 to {count}"
        raise InputError(f"there is no sensor {sensor}: the recording has {found}", where=where, do=_instead(recording))
    return recording if array is None else recording.sensor((sensor or 1) - 1)


def _instead(recording: Recording) -> str:
    """Advice for a sensor number out of range."""
    if recording.array_mag_nT is None and REFERENCE[0] in recording.channels:
        return f"leave the option out: {REFERENCE[0]} and its like are the reference"
    return "leave the option out" if recording.array_mag_nT is None else "give one of these"


def one_sensor(recording: Recording, sensor: int | None, reference: int | None, path: Path) -> Recording:
    """The recording of one sensor of a file's array, with a second sensor as reference if given; see `of_sensor`."""
    if reference is not None:
        return with_reference(recording, sensor, reference, f"{path}: --reference-sensor")
    return of_sensor(recording, sensor, f"{path}: --sensor")


def with_reference(recording: Recording, sensor: int | None, reference: int, where: str) -> Recording:
    """The recording of one sensor of an array with a second sensor as its reference, counted from 1.

    Raises InputError for numbers out of range, and for equal numbers.
    """
    if reference == (1 if recording.array_mag_nT is None else sensor):
        raise InputError(f"sensor {reference} is no reference of itself", where=where, do="give two sensors")
    reference_sensor = of_sensor(recording, reference, where)
    own = of_sensor(recording, sensor, where)
    return replace(own, channels=own.channels | dict(zip(REFERENCE, reference_sensor.mag_nT.T, strict=True)))


def model_of_sensor(model: Model, sensor: int | None) -> Model:
    """A scenario of several sensors reduced to one vector sensor, counted from 1; all other models unchanged."""
    if not isinstance(model, Scenario) or sensor is None or not 1 <= sensor <= len(model.vectors) > 1:
        return model
    own = model.vectors[sensor - 1]
    kept = tuple(part for k, part in enumerate(model.sensors) if k in (own, model.scalar))
    return model.model_copy(update={"sensors": kept, "vary": {}})
