"""The compasses of a DataFlash log, with ArduPilot's calibration undone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from recordings.applied import AppliedCalibration
from recordings.body_frame import flu_from_frd
from recordings.readers.ardupilot.compass import (
    COMPASSES,
    MILLIGAUSS_NT,
    calibration_names,
    compass_calibration,
    compass_of,
    own_parameters,
    suffix,
)
from recordings.readers.ardupilot.in_force import STEP_MG, AppliedInLog
from recordings.readers.ardupilot.messages import Dataflash, Messages
from recordings.readers.ardupilot.motor_term import motors_come_first
from recordings.readers.ardupilot.parameters import Parameters
from recordings.readers.ardupilot.power import drive_of
from recordings.readers.ardupilot.vehicle import firmware_of
from recordings.readers.vehicle_log import vector_columns
from recordings.streams import Stream
from scenarios.arrays import Array
from scenarios.text import figure

FIELD, OFFSET = ("MagX", "MagY", "MagZ"), ("OfsX", "OfsY", "OfsZ")
MOTOR = (("MOX", "MOY", "MOZ"), ("MOfsX", "MOfsY", "MOfsZ"))
"""The motors' term, by its newer and its older name."""
SAMPLE_TIME, TURN = "S", 2.0**32
"""The time of the sample in us, and where its 32 bits begin again."""
LATEST_WRITING_S = 1.0
"""A sample that seems to be written later than this after its time has a wrong time, and gets the time of writing."""


@dataclass(frozen=True, eq=False)
class Compass:
    """A compass of a log: its field before calibration (FLU), what was undone, and a line for each thing to know."""

    stream: Stream
    applied: AppliedCalibration | None
    notes: tuple[str, ...]


def compasses_of(log: Dataflash, parameters: Parameters) -> dict[str, Compass]:
    """Return the compasses by their number, as the autopilot orders them; a compass in use comes first."""
    logged = {place: rows for place, rows in log.instances("MAG").items() if place + 1 in COMPASSES}
    found = {place: rows for place, rows in logged.items() if _measures(rows)}
    numbers = {place: compass_of(parameters, place) for place in found}
    ordered = sorted(found, key=lambda place: (not is_used(parameters, place), place))
    return {str(place + 1): _compass(log, found[place], parameters, numbers[place]) for place in ordered}


def is_used(parameters: Parameters, place: int) -> bool:
    """Whether the autopilot navigates by the compass at a place in its order of priority, which COMPASS_USE counts."""
    return bool(parameters.get(f"COMPASS_USE{suffix(place + 1)}", 1.0))


def _measures(rows: Messages) -> bool:
    """Whether a compass gives any field at all."""
    return all(name in rows for name in FIELD) and bool(rows.vector(*FIELD).any())


def _compass(log: Dataflash, rows: Messages, parameters: Parameters, number: int) -> Compass:
    rows, notes = _sound(rows)
    field_mG = whole_steps(rows, FIELD)
    if number in COMPASSES and any(name in parameters for name in calibration_names(number)):
        raw_mG, told = _undone(log, rows, parameters, number, field_mG)
        applied = compass_calibration(parameters, number).applied(own_parameters(parameters, number))
    else:
        raw_mG, told, applied = field_mG, [_nothing(rows, number)], None
    columns = vector_columns("mag", flu_from_frd(raw_mG) * MILLIGAUSS_NT)
    return Compass(Stream(sample_times_s(log, rows), columns), applied, (*notes, *told))


def _sound(rows: Messages) -> tuple[Messages, list[str]]:
    """Return the messages of a healthy compass with a field, and a line for each kind that is left out."""
    healthy = rows.numbers("Health") != 0 if "Health" in rows else np.ones(len(rows), np.bool_)
    finite = np.isfinite(rows.vector(*FIELD)).all(axis=1)
    lost, empty = int(np.sum(~healthy)), int(np.sum(healthy & ~finite))
    notes = [f"{lost} of {len(rows)} samples left out: the autopilot calls the compass unhealthy there"] if lost else []
    notes += [f"{empty} of {len(rows)} samples left out: they hold no number"] if empty else []
    return rows.where(healthy & finite), notes


def whole_steps(rows: Messages, fields: Sequence[str]) -> Array:
    """Return a vector (n, 3) that was cut to whole steps toward zero: in the middle of the values that were cut."""
    values = rows.vector(*fields)
    return values + np.array([rows.whole(field) for field in fields]) * np.sign(values) * STEP_MG / 2


def sample_times_s(log: Dataflash, rows: Messages) -> Array:
    """Return the times of the samples, s: the sample's own where logged, else the time of writing.

    t = t_w - ((t_w - S) mod 2^32 us), t_w the time of writing.
    """
    written_s = log.times_s(rows)
    if SAMPLE_TIME not in rows:
        return written_s
    age_s = np.mod(written_s * 1e6 - rows.numbers(SAMPLE_TIME), TURN) * 1e-6
    return np.where(age_s <= LATEST_WRITING_S, written_s - age_s, written_s)


def _motor_term(log: Dataflash, rows: Messages, parameters: Parameters, number: int) -> tuple[Array, str, str]:
    """Return the motors' term k p that the autopilot added, mG (n, 3), its name, and a line where it is not known."""
    names = next((names for names in MOTOR if all(name in rows for name in names)), None)
    if names:
        return whole_steps(rows, names), f"the motors' term {', '.join(names)}", ""
    drive = drive_of(log, parameters, firmware_of(log)[0])
    term_mG, lacking = AppliedInLog(parameters, number, log.times_s(rows)).motor_term(drive)
    return term_mG, "the motors' term by its parameters", lacking


def _undone(
    log: Dataflash, rows: Messages, parameters: Parameters, number: int, field_mG: Array
) -> tuple[Array, list[str]]:
    """Return the field before calibration, mG (n, 3), and notes."""
    motor_mG, of_motors, lacking = _motor_term(log, rows, parameters, number)
    first = motors_come_first(parameters, *firmware_of(log), old_names=MOTOR[1][0] in rows)
    applied = AppliedInLog(parameters, number, log.times_s(rows), motors_first=first)
    raw_mG, learned = applied.undone(field_mG, motor_mG, _logged_offsets(rows))
    notes = [told_undone(parameters.last, number, of_motors if motor_mG.any() else "")]
    notes += [lacking] if lacking else []
    notes += applied.notes
    if learned.any():
        share = f"{np.count_nonzero(learned)} of {len(rows)} samples"
        notes.append(f"compass {number}: {share} have other offsets than the parameters; those logged are undone")
    return raw_mG, notes


def _logged_offsets(rows: Messages) -> Array | None:
    """Return the offsets that each message gives, mG (n, 3); None without, or where they are zero throughout."""
    logged = rows.vector(*OFFSET) if all(name in rows for name in OFFSET) else np.zeros((0, 3))
    return whole_steps(rows, OFFSET) if logged.any() else None


def told_undone(last: Mapping[str, float], number: int, motors: str = "") -> str:
    """Return the line that says what was undone, with the parameters that differ from a compass without calibration.

    motors : what the motors' term was taken from, "" without such a term.
    """
    neutral = {name: 1.0 if "_DIA" in name else 0.0 for name in calibration_names(number)}
    values = [f"{name} {figure(last[name], 4)}" for name, value in neutral.items() if last.get(name, value) != value]
    values += [motors] if motors else []
    if not values:
        return f"ArduPilot's calibration of compass {number}: nothing to undo"
    return f"ArduPilot's calibration of compass {number} undone ({', '.join(values)})"


def _nothing(rows: Messages, number: int) -> str:
    """Return the line about a log without parameters."""
    moved = all(name in rows for name in OFFSET) and np.ptp(rows.vector(*OFFSET), axis=0).any()
    changed = "; the offsets in it changed on the way" if moved else ""
    return f"no parameters of compass {number}: the field is as the autopilot used it, nothing can be undone{changed}"
