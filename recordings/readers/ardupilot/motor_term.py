"""The field that ArduPilot adds for the motors, from its parameters, for logs that do not hold this term itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from recordings.readers.ardupilot.compass import suffix
from recordings.readers.ardupilot.parameters import Parameters
from recordings.streams import Stream, ordered_rows
from scenarios.arrays import Array

BY_THROTTLE, BY_CURRENT = 1.0, 2.0
"""COMPASS_MOTCT of a term that follows the throttle, or the battery's current."""
EXPONENT = 0.65
"""COMPASS_PMOT_EXP where the log does not give it."""
MOTORS = (1, 2, 3, 4)
"""The motors that COMPASS_PMOT knows."""
PER_MOTOR_FROM = {"copter": (3, 6), "plane": (3, 9), "rover": (3, 3), "sub": (3, 6)}
"""By vehicle, the release that brought COMPASS_PMOT, and the motors' term added after the soft iron."""


@dataclass(frozen=True, eq=False)
class Drive:
    """What a motors' term may follow, each a stream of one column, None where the log lacks it.

    Parameters
    ----------
    throttle : 0 to 1. current : of the battery, A. voltage : of the battery, V.
    outputs : by the motor's number from 1, its command from 0 to 1.
    """

    throttle: Stream | None = None
    current: Stream | None = None
    voltage: Stream | None = None
    outputs: Mapping[int, Stream] = field(default_factory=dict)


def motors_come_first(parameters: Parameters, vehicle: str, release: tuple[int, int], *, old_names: bool) -> bool:
    """Return whether the firmware adds the motors' term before the soft iron.

    old_names : whether MAG names the term MOfsX, which decides where neither parameters nor texts tell the release.
    """
    if any(name.startswith(("COMPASS_PMOT", "COMPASS_SCALE", "COMPASS_PRIO")) for name in parameters.last):
        return False
    newer = PER_MOTOR_FROM.get(vehicle)
    return release < newer if newer and release > (0, 0) else old_names


def motor_names(compass: int) -> list[str]:
    """Return the parameters that make up the motors' term of a compass."""
    per_motor = [f"COMPASS_PMOT{k}_{axis}" for k in MOTORS for axis in "XYZ"] if compass == 1 else []
    own = [f"COMPASS_MOT{suffix(compass)}_{axis}" for axis in "XYZ"]
    return ["COMPASS_MOTCT", "COMPASS_PMOT_EN", "COMPASS_PMOT_EXP", *own, *per_motor]


def motor_term(parameters: Parameters, compass: int, at_s: Array, drive: Drive) -> tuple[Array, str]:
    """Return k p in mG (n, 3) at times (n,), and a line where the log lacks what the term follows.

    COMPASS_PMOT_EN, first compass: sum over motors of c_i (V u_i)^EXP; COMPASS_MOTCT 1: COMPASS_MOT times throttle; 2:
    times current [ArduPilot: Compass_PerMotor.cpp, AP_Compass_Backend.cpp].
    """
    if compass == 1 and parameters.get("COMPASS_PMOT_EN"):
        return _per_motor(parameters, at_s, drive)
    gain_mG = parameters.vector(f"COMPASS_MOT{suffix(compass)}")
    kind = parameters.get("COMPASS_MOTCT")
    if kind not in (BY_THROTTLE, BY_CURRENT) or not gain_mG.any():
        return np.zeros((len(at_s), 3)), ""
    stream = drive.throttle if kind == BY_THROTTLE else drive.current
    if stream is None:
        return _unknown(at_s, compass, "COMPASS_MOT", "throttle" if kind == BY_THROTTLE else "battery's current")
    return _at(stream, at_s)[:, None] * gain_mG, ""


def _per_motor(parameters: Parameters, at_s: Array, drive: Drive) -> tuple[Array, str]:
    gains = {k: parameters.vector(f"COMPASS_PMOT{k}") for k in MOTORS}
    used = {k: gain for k, gain in gains.items() if gain.any()}
    if used and (drive.voltage is None or not used.keys() <= drive.outputs.keys()):
        return _unknown(at_s, 1, "COMPASS_PMOT", "battery's voltage or the motors' outputs")
    exponent, total = parameters.get("COMPASS_PMOT_EXP", EXPONENT), np.zeros((len(at_s), 3))
    for k, gain_mG in used.items():
        volt = _at(drive.voltage, at_s) if drive.voltage else 0.0
        total += (np.maximum(volt * _at(drive.outputs[k], at_s), 0.0) ** exponent)[:, None] * gain_mG
    return total, ""


def _unknown(at_s: Array, compass: int, name: str, lacking: str) -> tuple[Array, str]:
    note = f"compass {compass}: the motors' term ({name}) is not undone, the log lacks the {lacking}"
    return np.zeros((len(at_s), 3)), note


def _at(stream: Stream, at_s: Array) -> Array:
    """Return the values of a stream's one column at times (n,), constant beyond its ends."""
    (values,) = stream.columns.values()
    rows, _ = ordered_rows(np.where(np.isfinite(values), stream.times_s, np.nan))
    return np.interp(at_s, stream.times_s[rows], values[rows]) if len(rows) else np.zeros(len(at_s))
