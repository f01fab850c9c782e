"""Currents, voltage, throttle and motor outputs of a DataFlash log."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from recordings.channels import BATTERY_VOLTAGE, THROTTLE, current_name, motor_output_name
from recordings.readers.ardupilot.messages import Dataflash, Messages
from recordings.readers.ardupilot.motor_term import MOTORS as QUAD_MOTORS
from recordings.readers.ardupilot.motor_term import Drive
from recordings.readers.ardupilot.parameters import Parameters
from recordings.readers.ardupilot.vehicle import COPTER, PLANE, SUB
from recordings.streams import Stream
from scenarios.arrays import Array

CONTROLLER = "controller of motor "
"""The beginning of the names of streams of motor controllers (ESC)."""
OUTPUTS = "output RCOU."
"""The beginning of the names of streams of motor outputs; the end is the field of RCOU."""
OLD_BATTERY_UNIT = 0.01
"""V and A of a count in CURR messages of old logs, whose values are whole numbers."""
MOTORS = {function: function - 32 for function in range(33, 41)} | {
    function: function - 73 for function in range(82, 86)
}
"""SERVOk_FUNCTION of an output that drives a motor -> the motor's number."""
PLANE_MOTORS = {70: 1, 73: 1, 74: 2}
"""On planes: throttle, left and right throttle."""
FIRST_OUTPUTS = 8
"""Outputs that may drive motors where no parameter tells."""
OUTPUT = re.compile(r"(?:C|Ch)(\d+)")
PULSES_US = (1000.0, 2000.0)
"""Pulse lengths of no and of full output where no parameter gives them."""


def current_streams(log: Dataflash) -> tuple[dict[str, Stream], list[str]]:
    """Return the current of each motor where its controller reports one, else the battery's as current 1."""
    motors = log.instances("ESC") or old_controllers(log)
    reported = {number: rows for number, rows in motors.items() if "Curr" in rows and rows.numbers("Curr").any()}
    if reported:
        names = {number: current_name(number + 1) for number in reported}
        streams = {
            f"{CONTROLLER}{n + 1}": _stream(log, rows, {names[n]: rows.numbers("Curr")}) for n, rows in reported.items()
        }
        return streams, []
    battery = _battery(log)
    if battery is None or "Curr" not in battery or not np.ptp(battery.numbers("Curr")):
        return {}, []
    current = {current_name(1): battery.numbers("Curr") * _unit(battery, "Curr")}
    note = f"current_1_A is the battery's current ({battery.layout.name}.Curr): no motor's own current is logged"
    return {"battery current": _stream(log, battery, current)}, [note]


def sources_of(stream: str) -> tuple[str, ...]:
    """Return the log's own names of what a stream of this file holds, for motors' currents and outputs."""
    number = stream.removeprefix(CONTROLLER)
    if number != stream:
        return f"ESC[{int(number) - 1}].Curr", f"ESC{number}.Curr", "ESC.Curr"
    return (stream.removeprefix("output "),) if stream.startswith(OUTPUTS) else ()


def old_controllers(log: Dataflash) -> dict[int, Messages]:
    """Return the messages ESC1 .. ESC12 of older logs, by the motor's number from 0."""
    return {k - 1: log.types[f"ESC{k}"] for k in range(1, 13) if f"ESC{k}" in log.types}


def command_streams(log: Dataflash, parameters: Parameters, vehicle: str) -> dict[str, Stream]:
    """Return the battery's voltage, the throttle and the motors' outputs, the latter two from 0 to 1."""
    found: dict[str, Stream] = {}
    battery, tuning = _battery(log), log.types.get("CTUN")
    if battery is not None and "Volt" in battery:
        voltage = {BATTERY_VOLTAGE: battery.numbers("Volt") * _unit(battery, "Volt")}
        found["battery voltage"] = _stream(log, battery, voltage)
    name = next((name for name in ("ThO", "ThrOut") if tuning is not None and name in tuning), None)
    if tuning is not None and name:
        throttle = tuning.numbers(name) * _throttle_unit(tuning, name, vehicle)
        found["throttle"] = _stream(log, tuning, {THROTTLE: throttle})
    return found | _output_streams(log, parameters, vehicle)


def drive_of(log: Dataflash, parameters: Parameters, vehicle: str) -> Drive:
    """Return what the motors' term of a compass may follow."""
    commands, battery = command_streams(log, parameters, vehicle), _battery(log)
    current = None
    if battery is not None and "Curr" in battery:
        current = _stream(log, battery, {current_name(1): battery.numbers("Curr") * _unit(battery, "Curr")})
    named = {name: one for one in commands.values() for name in one.columns}
    outputs = {k: named[name] for k in QUAD_MOTORS if (name := motor_output_name(k)) in named}
    return Drive(commands.get("throttle"), current, commands.get("battery voltage"), outputs)


def _output_streams(log: Dataflash, parameters: Parameters, vehicle: str) -> dict[str, Stream]:
    outputs = log.types.get("RCOU")
    if outputs is None:
        return {}
    fields = {int(match[1]): field for field in outputs.layout.kinds if (match := OUTPUT.fullmatch(field))}
    pulses_us = {k: outputs.numbers(field) for k, field in fields.items()}
    motors = motor_outputs(pulses_us, parameters, vehicle)
    names = {k: (f"{OUTPUTS}{fields[k]}", motor_output_name(motor)) for k, (motor, _) in motors.items()}
    return {stream: _stream(log, outputs, {name: motors[k][1]}) for k, (stream, name) in names.items()}


def motor_outputs(pulses_us: Mapping[int, Array], parameters: Parameters, vehicle: str) -> dict[int, tuple[int, Array]]:
    """Return, by the output's number, the motor that it drives and (pulse - least) / (most - least), cut to 0 .. 1.

    SERVOk_FUNCTION tells the motor. Logs without these parameters are of a copter or submarine whose first eight
    outputs are its motors, as far as they move.
    """
    functions = MOTORS | (PLANE_MOTORS if vehicle == PLANE else {})
    stated = {k: int(parameters.get(f"SERVO{k}_FUNCTION")) for k in pulses_us if f"SERVO{k}_FUNCTION" in parameters}
    motors = {k: functions[function] for k, function in stated.items() if function in functions}
    if not stated and vehicle in (COPTER, SUB):
        motors = {k: k for k, pulses in pulses_us.items() if k <= FIRST_OUTPUTS and np.ptp(pulses)}
    found = {}
    for k, motor in motors.items():
        least, most = _pulse_range(k, parameters, vehicle)
        found[k] = (motor, np.clip((pulses_us[k] - least) / (most - least), 0.0, 1.0))
    return found


def _pulse_range(output: int, parameters: Parameters, vehicle: str) -> tuple[float, float]:
    """Return the pulses of no and of full output, us."""
    own = f"SERVO{output}"
    names = ("MOT_PWM_MIN", "MOT_PWM_MAX") if vehicle in (COPTER, SUB) else (f"{own}_MIN", f"{own}_MAX")
    least, most = (parameters.get(name) or usual for name, usual in zip(names, PULSES_US, strict=True))
    return (least, most) if most > least else PULSES_US


def _throttle_unit(tuning: Messages, name: str, vehicle: str) -> float:
    """Return the throttle of one count: planes log per cent, old copters per mille, copters the fraction."""
    if vehicle == PLANE:
        return 0.01
    return 0.001 if tuning.whole(name) else 1.0


def _battery(log: Dataflash) -> Messages | None:
    """Return the messages of the first battery."""
    found: Mapping[int, Messages] = log.instances("BAT") or log.instances("CURR")
    return found[min(found)] if found else None


def _unit(battery: Messages, field: str) -> float:
    return OLD_BATTERY_UNIT if battery.layout.kinds[field] in "hH" else 1.0


def _stream(log: Dataflash, rows: Messages, columns: dict[str, Array]) -> Stream:
    return Stream(log.times_s(rows), columns)
