"""One sensor of an array: its recording, and the model as it is of this sensor."""

from __future__ import annotations

from scenarios.errors import InputError
from sim.dataset import Recording
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
        raise InputError(f"there is no sensor {sensor}: the recording has {found}", where=where, do="give one of these")
    return recording if array is None else recording.sensor((sensor or 1) - 1)


def model_of_sensor(model: Model, sensor: int | None) -> Model:
    """A scenario of several sensors as one of this sensor alone, counted from 1; any other model as it is."""
    if not isinstance(model, Scenario) or sensor is None or not 1 <= sensor <= len(model.vectors) > 1:
        return model
    own = model.vectors[sensor - 1]
    kept = tuple(one for k, one in enumerate(model.sensors) if k in (own, model.scalar))
    return model.model_copy(update={"sensors": kept, "vary": {}})
