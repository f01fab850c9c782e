"""Sensors of a recording: one magnetometer of an array, its reference, and channels that are motor currents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from recordings import Recording
from recordings.channels import REFERENCE, SCALAR, current_name
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.scenario import Model, Scenario

BY_MODEL = ", or a --model whose [field] has latitude_deg, longitude_deg and date"
"""Alternative to a stated field, for messages."""


def of_sensor(recording: Recording, sensor: int | None, where: str) -> Recording:
    """The recording of one sensor of an array, counted from 1; a recording of a single magnetometer is unchanged.

    Raises InputError for a number out of range, and for an array without a number.
    """
    array = recording.array_mag_nT
    count = 1 if array is None else len(array)
    if sensor is None and count > 1:
        raise InputError(f"an array of {count} sensors", where=where, do="say which with --sensor, counted from 1")
    if sensor is not None and not 1 <= sensor <= count:
        found, do = f"the sensors 1 to {count}", "give one of these"
        if array is None:
            beside = f": {REFERENCE[0]} and its like are the reference" if REFERENCE[0] in recording.channels else ""
            found, do = "one magnetometer", f"leave the option out{beside}"
        raise InputError(f"there is no sensor {sensor}: the recording has {found}", where=where, do=do)
    return recording if array is None else recording.sensor((sensor or 1) - 1)


def one_sensor(recording: Recording, sensor: int | None, reference: int | None, path: Path) -> Recording:
    """The recording of one sensor of a file's array, with a second sensor as its reference if given, counted from 1.

    Raises InputError as `of_sensor` does, and for equal numbers.
    """
    if reference is None:
        return of_sensor(recording, sensor, f"{path}: --sensor")
    where = f"{path}: --reference-sensor"
    if reference == (1 if recording.array_mag_nT is None else sensor):
        raise InputError(f"sensor {reference} is no reference of itself", where=where, do="give two sensors")
    beside, own = of_sensor(recording, reference, where), of_sensor(recording, sensor, where)
    return replace(own, channels=own.channels | dict(zip(REFERENCE, beside.mag_nT.T, strict=True)))


def model_of_sensor(model: Model, sensor: int | None) -> Model:
    """A scenario of several sensors reduced to one vector sensor, counted from 1; all other models unchanged."""
    if not isinstance(model, Scenario) or sensor is None or not 1 <= sensor <= len(model.vectors) > 1:
        return model
    own = model.vectors[sensor - 1]
    kept = tuple(part for k, part in enumerate(model.sensors) if k in (own, model.scalar))
    return model.model_copy(update={"sensors": kept, "vary": {}})


def recorded_reference(recording: Recording) -> Array | None:
    """Reading (n, 3) in nT of the reference magnetometer, None without a reference.

    Raises InputError for a missing axis, and for rows without a field.
    """
    there = [name for name in REFERENCE if name in recording.channels]
    if not there:
        return None
    if missing := [name for name in REFERENCE if name not in there]:
        what = f"there is no column {missing[0]} beside {there[0]}"
        raise InputError(what, where="recording", do="give all three axes of the reference")
    reference_nT = np.column_stack([recording.channels[name] for name in REFERENCE])
    if not np.isfinite(reference_nT).all() or not reference_nT.any(axis=1).all():
        what = f"{REFERENCE[0]} and its like have rows without a field"
        raise InputError(what, where="recording", do="give a field in nT in every row")
    return reference_nT


def measured_strength(recording: Recording) -> Array | None:
    """Strength (n, 1) in nT of a recorded scalar magnetometer, None without complete values.

    Raises InputError for values that are not positive.
    """
    known_nT = recording.channels.get(SCALAR)
    if known_nT is None or not np.isfinite(known_nT).all():
        return None
    if known_nT.min() <= 0:
        what = f"{SCALAR} is the strength of a field in nT, found {known_nT.min():g}"
        raise InputError(what, where="recording", do="give it another name if it is something else")
    return known_nT[:, None]


def needs_field(recording: Recording, model: Model, *, stated: bool) -> bool:
    """Whether the Earth's field must be given; InputError for a field stated besides a reference magnetometer."""
    if recorded_reference(recording) is None:
        return stated or (model.field is None and measured_strength(recording) is None)
    if stated:
        what = "another magnetometer is the reference, and a field is stated too"
        raise InputError(what, where="reference", do="leave out one of the two")
    return False


def with_actuators(recording: Recording, names: Sequence[str], path: Path) -> Recording:
    """The recording with some channels appended to its motor currents, numbered after them.

    Raises InputError for an unknown channel.
    """
    columns = [] if recording.current_A is None else list(recording.current_A.T)
    last = max(recording.motors, default=0)
    motors = (*recording.motors, *range(last + 1, last + 1 + len(names)))
    for name in names:
        if name not in recording.channels:
            do = "the channels are " + (", ".join(recording.channels) or "none")
            raise InputError(f"there is no channel {name!r}", where=f"{path}: --actuator", do=do)
        columns.append(recording.channels[name])
    return replace(recording, current_A=np.stack(columns, axis=1), motor_numbers=motors) if names else recording


def as_currents(recording: Recording) -> dict[str, str]:
    """Channels equal to a motor current, each with the name of the current."""
    currents_A = [] if recording.current_A is None else list(recording.current_A.T)
    return {
        channel: current_name(number)
        for number, current_A in zip(recording.motors, currents_A, strict=bool(currents_A))
        for channel, values in recording.channels.items()
        if np.array_equal(values, current_A)
    }
