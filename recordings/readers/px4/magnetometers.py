"""The magnetometers of a PX4 log: which sensor, which topic, what PX4 did to the field, and the raw field again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from recordings.applied import AppliedCalibration
from recordings.body_frame import DOWN, flu_from_frd
from recordings.readers.px4.calibration import Correction, Formula
from recordings.readers.px4.contents import ULog, UlogTopic
from recordings.readers.px4.history import CalibrationHistory, formula_by_samples, usual_formula
from recordings.readers.px4.parameters import ParameterState, parameter_states
from recordings.readers.px4.sensors import LoggedSensor, logged_sensors
from recordings.readers.vehicle_log import vector_columns
from recordings.streams import Stream

NT_PER_GAUSS = 1e5
FLIP = np.array(DOWN)
PARAMETERS = ("CAL_MAG", "SENS_BOARD", "TC_M")


@dataclass(frozen=True, eq=False)
class Px4Magnetometer:
    """A magnetometer of the log.

    Parameters
    ----------
    name : n of CAL_MAGn_*, else the device's number. sensor : its topic sensor_mag, where logged.
    stream : the raw field along the body's axes, FLU, nT. applied : what PX4 had in force for most of the log.
    notes : what was read, turned and undone.
    """

    name: str
    sensor: UlogTopic | None
    stream: Stream
    applied: AppliedCalibration
    notes: tuple[str, ...]


def magnetometers(log: ULog) -> list[Px4Magnetometer]:
    """Return the log's magnetometers, the main one, which PX4 navigates by, first."""
    states = parameter_states(log, PARAMETERS)
    sensors = logged_sensors(log, states[-1])
    chosen: list[Formula] = []
    found = []
    for sensor in sensors:
        formula = formula_by_samples(log, sensor, states) or next(iter(chosen), usual_formula(log, states[0]))
        chosen.append(formula)
        found.append(_magnetometer(log, sensor, states, formula))
    return found


def _magnetometer(
    log: ULog, sensor: LoggedSensor, states: Sequence[ParameterState], formula: Formula
) -> Px4Magnetometer:
    """Return a magnetometer with its raw field: from sensor_mag where logged densely, else out of PX4's field."""
    history = CalibrationHistory(log, sensor, states, formula)
    samples = sensor.used
    raw_G = history.each(samples, history.raw_of_sensor if sensor.is_direct else history.raw)
    in_force = history.in_force(samples.times_s)
    main = in_force[0]
    undone = not (sensor.is_direct and formula is not Formula.DRIVER) and not all(
        history.spans[k].says_nothing for k in in_force
    )
    name = str(sensor.number) if history.slot is None else str(history.slot)
    read = f"magnetometer {name} (device {sensor.number}) from {sensor.topic}"
    return Px4Magnetometer(
        name,
        sensor.sensor,
        Stream(samples.times_s, vector_columns("mag", flu_from_frd(raw_G * NT_PER_GAUSS))),
        applied_in_body(history.spans[main], states[main], history.slot, sensor.number, undone),
        (
            f"{read}, turned from forward, right, down to forward, left, up of the body frame",
            _told(history, main) if undone else _nothing(history, sensor),
            *_remarks(history, sensor, states[main]),
        ),
    )


def _nothing(history: CalibrationHistory, sensor: LoggedSensor) -> str:
    """Return the note of a field that is raw in the log."""
    if history.slot is None:
        return "no CAL_MAGn_ID names this magnetometer, PX4 calibrates nothing: nothing to undo in the body frame"
    direct = sensor.is_direct and history.formula is not Formula.DRIVER
    return f"{'sensor_mag is raw' if direct else 'no calibration in force'}: nothing to undo in the body frame"


def _told(history: CalibrationHistory, main: int) -> str:
    """Return the note of what was undone, with the values in force most of the time."""
    correction, slot = history.spans[main], history.slot
    values = [f"CAL_MAG{slot}_{axis}OFF {value:.4g}" for axis, value in zip("XYZ", correction.offset_G, strict=True)]
    scale = ", ".join(f"{value:.4g}" for value in np.diag(correction.scale))
    more = f"{', '.join(values)} G, scale {scale}"
    if np.any(correction.scale != np.diag(np.diag(correction.scale))):
        more += ", off-diagonals"
    if correction.power_type and np.any(correction.power):
        more += f", power compensation of type {correction.power_type}"
    return f"PX4's calibration {slot} undone in the body frame ({more})"


def _remarks(history: CalibrationHistory, sensor: LoggedSensor, state: ParameterState) -> list[str]:
    """Return notes of changes within the log, and of what PX4 does beside the calibration."""
    times_s = sensor.used.times_s
    changes = len(history.in_force(times_s)) - 1
    compensated = (state.whole(f"TC_M{n}_ID") == sensor.number for n in range(4))
    remarks = {
        f"PX4's calibration changed {changes} times within the log: each part has its own undone": changes > 0
        and (not sensor.is_direct or history.formula is Formula.DRIVER),
        "the log lacks the signal of the power compensation (CAL_MAG_COMP_TYP): it is not undone": history.lacking,
        "magnetometer_bias_estimate undone": not sensor.is_direct and bool(np.any(history.bias_G(times_s))),
        "PX4's temperature compensation (TC_M*) of this magnetometer is not undone": bool(state.whole("TC_M_ENABLE"))
        and any(compensated),
    }
    return [text for text, holds in remarks.items() if holds]


def applied_in_body(
    correction: Correction, state: ParameterState, slot: int | None, device: int, undone: bool
) -> AppliedCalibration:
    """Return the calibration in force, body frame (FLU): offset D R o, matrix D R S R^T D, D = diag(1, -1, -1)."""
    turn = FLIP[:, None] * correction.rotation
    return AppliedCalibration(
        "px4",
        slot if slot is not None else 0,
        turn @ correction.offset_G * NT_PER_GAUSS,
        turn @ correction.scale @ turn.T,
        _parameters(state.values, slot, device),
        undone,
    )


def _parameters(values: Mapping[str, float], slot: int | None, device: int) -> dict[str, float]:
    """Return the parameters of one magnetometer, with those of the board and of its temperature compensation."""
    prefixes = ["SENS_BOARD", "CAL_MAG_COMP_TYP"] + ([f"CAL_MAG{slot}_"] if slot is not None else [])
    prefixes += [f"TC_M{n}_" for n in range(4) if values.get(f"TC_M{n}_ID") == device]
    return {name: value for name, value in values.items() if name.startswith(tuple(prefixes))}
