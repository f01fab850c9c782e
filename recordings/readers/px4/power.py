"""What drives the vehicle, of a PX4 log: armed state, throttle, motors' commands and currents, the battery."""

from __future__ import annotations

import numpy as np

from recordings.channels import ARMED, BATTERY_VOLTAGE, THROTTLE, current_name, motor_output_name
from recordings.readers.px4.contents import ULog, UlogTopic
from recordings.readers.px4.sampling import held, sample_times_s
from recordings.streams import Interpolation, Stream
from scenarios.arrays import Array

ARMED_STATE = 2
"""vehicle_status.arming_state of an armed vehicle, in every release."""
ROTARY_WING = 1
"""vehicle_status.vehicle_type of vehicles whose actuator outputs are motors."""
THROTTLE_COMPENSATION, BATTERY_COMPENSATION = 1, (2, 3)
"""CAL_MAG_COMP_TYP: by throttle; by the current of battery 0, 1."""
PULSE_US = (800.0, 2200.0)
"""Actuator outputs within these limits are pulses, of PWM_MIN .. PWM_MAX for 0 .. 1."""
KILO_PER_UNIT = 1e-3
UNMEASURED = -1.0
"""Voltage or current of a battery or motor without such a sensor."""
Streams = dict[str, Stream]


def armed_state(log: ULog) -> tuple[Array, Array] | None:
    """Return times (n,) and whether the vehicle is armed (n,), None where not logged."""
    for topic, name in (("actuator_armed", "armed"), ("vehicle_control_mode", "flag_armed")):
        found = log.first(topic)
        if found and name in found:
            return found.times_s(), found.column(name).astype(np.float64)
    status = log.first("vehicle_status")
    if status is None or "arming_state" not in status:
        return None
    return status.times_s(), (status.column("arming_state") == ARMED_STATE).astype(np.float64)


def throttle(log: ULog) -> tuple[Array, Array] | None:
    """Return times (n,) and the collective thrust (n,) by which PX4 compensates, None where not logged.

    The throttle of actuator_controls_0 until v1.13, |vehicle_thrust_setpoint.xyz| in releases without this topic.
    """
    setpoint, controls = log.first("vehicle_thrust_setpoint"), log.first("actuator_controls_0")
    if controls and "control[3]" in controls:
        return sample_times_s(controls), controls.column("control[3]").astype(np.float64)
    if setpoint and "xyz[2]" in setpoint:
        vector = setpoint.vectors("xyz[0]", "xyz[1]", "xyz[2]")
        return sample_times_s(setpoint), np.linalg.norm(np.nan_to_num(vector), axis=1)
    return None


def power_signal(log: ULog, kind: int, at_s: Array, *, armed_alone: bool) -> Array | None:
    """Return the power signal c (n,) of the magnetometers' compensation, None where the log lacks what makes it up.

    kind : CAL_MAG_COMP_TYP; c is the throttle while armed, or the battery's current in kA.
    armed_alone : whether the battery's current, too, counts while armed only, as before v1.13.
    """
    if kind != THROTTLE_COMPENSATION and kind not in BATTERY_COMPENSATION:
        return np.zeros(len(at_s))
    signal = throttle(log) if kind == THROTTLE_COMPENSATION else _battery_kA(log, BATTERY_COMPENSATION.index(kind))
    if signal is None:
        return None
    c = held(at_s, *signal)
    state = armed_state(log) if armed_alone or kind == THROTTLE_COMPENSATION else None
    return np.nan_to_num(c * held(at_s, *state) if state else c)


def power_streams(log: ULog) -> tuple[Streams, dict[str, str], set[str]]:
    """Return the streams of power under a recording's names, notes by column, and the names of the used fields."""
    streams: Streams = {}
    state, signal = armed_state(log), throttle(log)
    if state:
        streams[ARMED] = Stream(state[0], {ARMED: state[1]}, {ARMED: Interpolation.HELD}, np.inf)
    if signal:
        streams[THROTTLE] = Stream(signal[0], {THROTTLE: np.clip(signal[1], 0.0, 1.0)})
    streams |= _motor_outputs(log)
    currents, note, used = _currents(log)
    used.add("actuator_controls_0.control[3]")
    battery = _battery(log)
    if battery:
        streams[BATTERY_VOLTAGE] = Stream(battery.times_s(), {BATTERY_VOLTAGE: _measured(battery, "voltage_v")})
        used.add(f"{battery.label}.voltage_v")
    return streams | currents, {current_name(1): note}, used


def _currents(log: ULog) -> tuple[Streams, str, set[str]]:
    """Return the currents of the motors, else of the battery, a note whose they are, and the fields."""
    escs, battery = log.first("esc_status"), _battery(log)
    by_motor = _esc_currents(escs) if escs else {}
    if escs and by_motor:
        columns = {current_name(motor): values for motor, (_, values) in by_motor.items()}
        used = {f"{escs.label}.{name}" for name, _ in by_motor.values()}
        return {"esc": Stream(escs.times_s(), columns)}, "the motors' currents are from esc_status", used
    current_A = _measured(battery, "current_a") if battery else np.empty(0)
    if battery is None or not _varies(current_A):
        return {}, "", set()
    name = f"{battery.label}.current_a"
    note = f"{current_name(1)} is the battery's current ({name}): the log holds no current by motor"
    return {"battery": Stream(battery.times_s(), {current_name(1): current_A})}, note, {name}


def _battery(log: ULog) -> UlogTopic | None:
    """Return the first battery's topic; a second instance where the first is not logged."""
    found = log.first("battery_status")
    return found if found and {"current_a", "voltage_v"} <= set(found.names) else None


def _battery_kA(log: ULog, instance: int) -> tuple[Array, Array] | None:
    battery = log.topics.get(("battery_status", instance))
    if battery is None or "current_a" not in battery:
        return None
    return battery.times_s(), battery.column("current_a").astype(np.float64) * KILO_PER_UNIT


def _measured(topic: UlogTopic, name: str) -> Array:
    """Return a field (n,), NaN where it is not measured."""
    values = topic.column(name).astype(np.float64)
    return np.where(values == UNMEASURED, np.nan, values)


def _esc_currents(topic: UlogTopic) -> dict[int, tuple[str, Array]]:
    """Return field and current of the speed controllers that measure one, whose current changes, by motor from 1."""
    names = [name for name in topic.names if name.startswith("esc[") and name.endswith("].esc_current")]
    count = int(np.max(topic.column("esc_count"))) if "esc_count" in topic else len(names)
    found = {motor: (name, _measured(topic, name)) for motor, name in enumerate(names[:count], start=1)}
    return {motor: (name, values) for motor, (name, values) in found.items() if _varies(values)}


def _varies(values: Array) -> bool:
    """Return whether there are different finite values."""
    finite = values[np.isfinite(values)]
    return bool(len(finite) and np.ptp(finite) > 0)


def _motor_outputs(log: ULog) -> Streams:
    """Return the motors' commands 0 .. 1: actuator_motors, or the pulses of a rotary-wing vehicle's outputs."""
    motors, outputs = log.first("actuator_motors"), log.first("actuator_outputs")
    if motors:
        columns = {name: values for name, values in _numbered(motors, "control[").items() if np.isfinite(values).any()}
    elif outputs and _has_rotors(log):
        columns = _of_pulses(log, _numbered(outputs, "output["))
    else:
        columns = {}
    topic = motors or outputs
    return {"motors": Stream(sample_times_s(topic), columns)} if topic and columns else {}


def _numbered(topic: UlogTopic, prefix: str) -> dict[str, Array]:
    """Return the fields that begin so, by the channel of motor 1, 2, ..."""
    names = (name for name in topic.names if name.startswith(prefix))
    return {motor_output_name(k): topic.column(name) for k, name in enumerate(names, start=1)}


def _of_pulses(log: ULog, outputs: dict[str, Array]) -> dict[str, Array]:
    """Return those outputs that are pulses, as 0 at PWM_MIN to 1 at PWM_MAX."""
    low, high = log.parameters.get("PWM_MIN", 1000.0), log.parameters.get("PWM_MAX", 2000.0)
    if not PULSE_US[0] <= low < high <= PULSE_US[1]:
        low, high = 1000.0, 2000.0
    pulses = {name: us for name, us in outputs.items() if np.all((us >= PULSE_US[0]) & (us <= PULSE_US[1]))}
    return {name: np.clip((us - low) / (high - low), 0.0, 1.0) for name, us in pulses.items()}


def _has_rotors(log: ULog) -> bool:
    status = log.first("vehicle_status")
    for name in ("vehicle_type", "is_rotary_wing"):
        if status and name in status:
            return bool(np.any(status.column(name) == ROTARY_WING))
    return False
