"""One sensor of an array: its recording, and the model as it is of this sensor."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from recordings import Recording
from recordings.channels import REFERENCE
from scenarios.errors import InputError
from sim.scenario import Model, Scenario


def of_sensor(recording: Recording, sensor: int | None, where: str) -> Recording:
    """The recording of one sensor of an array, counted from 1; of a single magnetometer the recording as it is.

    Raises InputError for a sensor that is not there, and for an array of which none is asked for.
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
    """What to do where a sensor is asked for that is not there."""
    if recording.array_mag_nT is None and REFERENCE[0] in recording.channels:
        return f"leave the option out: {REFERENCE[0]} and its like are the reference"
    return "leave the option out" if recording.array_mag_nT is None else "give one of these"


def one_sensor(recording: Recording, sensor: int | None, reference: int | None, path: Path) -> Recording:
    """The recording of one sensor of a file's array, beside a reference where one is given; see `of_sensor`."""
    if reference is not None:
        return beside_reference(recording, sensor, reference, f"{path}: --reference-sensor")
    return of_sensor(recording, sensor, f"{path}: --sensor")


def beside_reference(recording: Recording, sensor: int | None, reference: int, where: str) -> Recording:
    """The recording of one sensor of an array with another, counted from 1, as its reference.

    Raises InputError for sensors that are not there, and for one that is its own reference.
    """
    if reference == (1 if recording.array_mag_nT is None else sensor):
        raise InputError(f"sensor {reference} is no reference of itself", where=where, do="give two sensors")
    other = of_sensor(recording, reference, where)
    one = of_sensor(recording, sensor, where)
    return replace(one, channels=one.channels | dict(zip(REFERENCE, other.mag_nT.T, strict=True)))


def model_of_sensor(model: Model, sensor: int | None) -> Model:
    """A scenario of several sensors as one of this sensor alone, counted from 1; any other model as it is."""
    if not isinstance(model, Scenario) or sensor is None or not 1 <= sensor <= len(model.vectors) > 1:
        return model
    own = model.vectors[sensor - 1]
    kept = tuple(one for k, one in enumerate(model.sensors) if k in (own, model.scalar))
    return model.model_copy(update={"sensors": kept, "vary": {}})
