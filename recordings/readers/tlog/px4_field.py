"""The magnetometers of PX4's telemetry: HIGHRES_IMU is the field as PX4 uses it, SCALED_IMU that of the sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from recordings.applied import AppliedCalibration
from recordings.body_frame import flu_from_frd
from recordings.readers.ardupilot.magnetometers import Compass
from recordings.readers.px4.calibration import Correction, Formula, corrections, formula_by_parameters
from recordings.readers.px4.magnetometers import applied_in_body
from recordings.readers.px4.parameters import ParameterState
from recordings.readers.px4.power import BATTERY_COMPENSATION, KILO_PER_UNIT, THROTTLE_COMPENSATION
from recordings.readers.px4.sampling import held
from recordings.readers.tlog.frames import Frames
from recordings.readers.tlog.quantities import battery_current, throttle_stream
from recordings.readers.tlog.telemetry import Telemetry
from recordings.readers.vehicle_log import vector_columns
from recordings.streams import Stream
from scenarios.arrays import Array

CALIBRATED = "HIGHRES_IMU"
PREFIXES = ("CAL_MAG", "SENS_BOARD")
MOST_STATES = 200
"""Changes of parameters beyond which further ones are damage."""
ARMED_FLAG = 128
GAUSS_MG = 1000.0
NT_PER_MG = 100.0


def px4_compass(log: Telemetry, rows: Frames, field_mG: Array) -> Compass:
    """Return a magnetometer of PX4's telemetry: the raw field along the body's axes, FLU.

    The messages do not name the sensor: of several with CAL_MAGn_ID, the one of the highest CAL_MAGn_PRIO is assumed.
    """
    states, at_s, field_G = _states(log), log.times_s(rows), field_mG / GAUSS_MG
    slot, assumed = _slot(states[-1])
    if slot is None:
        note = f"{rows.name}: the log has no parameters of the compass, nothing can be undone"
        return _turned(at_s, field_G, None, (note,))
    formula, device = formula_by_parameters(states[-1]), states[-1].whole(f"CAL_MAG{slot}_ID")
    spans, undone = corrections(states, [slot] * len(states), device, formula), rows.name == CALIBRATED
    place = np.clip(np.searchsorted([state.from_s for state in states], at_s, "right") - 1, 0, None)
    raw_G = np.empty_like(field_G)
    for k in np.unique(place).tolist():
        here = place == k
        raw_G[here] = _raw(log, spans[k], formula, at_s[here], field_G[here], undone=undone)
    applied = applied_in_body(spans[-1], states[-1], slot, device, undone)
    told = f"PX4's calibration {slot} undone in the body frame" if undone else f"raw, turned by CAL_MAG{slot}_ROT"
    return _turned(
        at_s, raw_G, applied, (f"{rows.name}: {told}{assumed}", *(_lacking(log, spans[-1]) if undone else ()))
    )


def _lacking(log: Telemetry, span: Correction) -> list[str]:
    """Return a line where the log lacks what the power compensation follows."""
    if span.power_type and span.power.any() and _signal(log, span) is None:
        return ["the log lacks the signal of the power compensation: the term is not undone"]
    return []


def _raw(log: Telemetry, span: Correction, formula: Formula, at_s: Array, field_G: Array, *, undone: bool) -> Array:
    if undone:
        return span.raw(field_G, _power(log, span, at_s), np.zeros_like(field_G), formula)
    return span.raw_of_driver(field_G) if formula is Formula.DRIVER else np.asarray(field_G @ span.rotation.T)


def _turned(at_s: Array, field_G: Array, applied: AppliedCalibration | None, notes: tuple[str, ...]) -> Compass:
    columns = vector_columns("mag", flu_from_frd(field_G) * GAUSS_MG * NT_PER_MG)
    return Compass(Stream(at_s, columns), applied, notes)


def _states(log: Telemetry) -> Sequence[ParameterState]:
    """Return the parameters at first, and after each change within the log."""
    names = sorted({name for name in log.parameters.names if name.startswith(PREFIXES)})
    times = [-np.inf, *log.parameters.changes_s(names)[:MOST_STATES].tolist()]
    return [ParameterState(time_s, log.parameters.at(time_s, names).last) for time_s in times]


def _slot(state: ParameterState) -> tuple[int | None, str]:
    """Return n of the calibration in use, None without, and words where another might be."""
    slots = [n for n in range(4) if state.whole(f"CAL_MAG{n}_ID") and state.number(f"CAL_MAG{n}_PRIO", 50)]
    if not slots:
        return None, ""
    best = max(slots, key=lambda n: (state.number(f"CAL_MAG{n}_PRIO", 50), -n))
    return best, "" if len(slots) == 1 else f", assumed of {len(slots)}: the message does not name its sensor"


def _signal(log: Telemetry, span: Correction) -> Stream | None:
    """Return the throttle, or the current of the first battery, which SYS_STATUS gives; None without."""
    if span.power_type == THROTTLE_COMPENSATION:
        return throttle_stream(log)
    return battery_current(log) if span.power_type == BATTERY_COMPENSATION[0] else None


def _power(log: Telemetry, span: Correction, at_s: Array) -> Array:
    """Return the power signal (n,): the throttle while armed, or the battery's current in kA; zero without."""
    stream, beats = _signal(log, span), log.get("HEARTBEAT")
    if stream is None:
        return np.zeros(len(at_s))
    (values,) = stream.columns.values()
    c = held(at_s, stream.times_s, values)
    if span.power_type != THROTTLE_COMPENSATION:
        return c * KILO_PER_UNIT
    armed = (beats.rows["base_mode"] & ARMED_FLAG > 0).astype(np.float64) if beats is not None else np.ones(0)
    return c * held(at_s, log.times_s(beats), armed, 1.0) if beats is not None else c
