"""The families: one function and one line each."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks.diagnosis.wide import faults, field, sensor, vehicle
from benchmarks.diagnosis.wide.forms import Family
from benchmarks.diagnosis.wide.noises import Noise
from recordings import Recording
from scenarios.arrays import Array

FIELD, VEHICLE, SENSOR = "field", "vehicle", "sensor"


class Hidden(NamedTuple):
    """Where an effect acts, its family, and what of the causes it needs beside attitude, place and temperature."""

    stage: str
    family: Family
    needs: frozenset[str] = frozenset()


CURRENTS = frozenset({"currents"})
FAMILIES: dict[str, Hidden] = {
    "regional_field": Hidden(FIELD, field.constant_error),
    "diurnal_drift": Hidden(FIELD, field.day),
    "field_gradient": Hidden(FIELD, field.gradient),
    "local_dipole": Hidden(FIELD, field.body),
    "attitude_misalignment": Hidden(FIELD, field.turned),
    "hard_iron_drift": Hidden(VEHICLE, vehicle.settling_iron),
    "eddy_current": Hidden(VEHICLE, vehicle.eddies),
    "motor_current": Hidden(VEHICLE, vehicle.thrusters, CURRENTS),
    "current_ripple": Hidden(VEHICLE, vehicle.pulses, CURRENTS),
    "nonlinearity": Hidden(SENSOR, sensor.bent),
    "temperature_scale": Hidden(SENSOR, sensor.warm_scale),
    "temperature_offset": Hidden(SENSOR, sensor.warm_offset),
    "hysteresis": Hidden(SENSOR, sensor.plays),
    "bandwidth": Hidden(SENSOR, sensor.filtered),
    "latency": Hidden(SENSOR, sensor.late),
    "offset_jump": Hidden(SENSOR, sensor.jump),
}
"""The effect that a form is one of, by its name in the library -> how it is made."""
FAULTS: dict[str, Callable[[np.random.Generator, Recording, Noise], Array]] = {
    "spikes": faults.bursts,
    "dropouts": faults.holds,
    "quantisation": faults.steps,
    "saturation": faults.full_scale,
    "offset_random_walk": faults.wander,
    "flicker_noise": faults.flicker,
}
"""The same of what is done to the values: (rng, recording, noise) -> values (n, 3)."""
PAIRS = (
    ("motor_current", "hysteresis"), ("eddy_current", "temperature_offset"), ("offset_jump", "nonlinearity"),
    ("diurnal_drift", "motor_current"), ("local_dipole", "current_ripple"), ("hard_iron_drift", "latency"),
    ("bandwidth", "motor_current"), ("field_gradient", "offset_jump"), ("temperature_offset", "local_dipole"),
    ("regional_field", "hysteresis"), ("nonlinearity", "eddy_current"), ("temperature_scale", "latency"),
)  # fmt: skip
"""What is hidden two at a time."""
