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
from recordings.readers.ardupilot.messages import Dataflash, Messages
from recordings.readers.ardupilot.parameters import Parameters
from recordings.readers.vehicle_log import vector_columns
from recordings.streams import Stream
from scenarios.arrays import Array

FIELD, OFFSET = ("MagX", "MagY", "MagZ"), ("OfsX", "OfsY", "OfsZ")
MOTOR = (("MOX", "MOY", "MOZ"), ("MOfsX", "MOfsY", "MOfsZ"))
"""The motors' term, by its newer and its older name."""
SAMPLE_TIME, TURN = "S", 2.0**32
"""The time of the sample in us, and where its 32 bits begin again."""
LATEST_WRITING_S = 1.0
"""A sample that seems to be written later than this after its time has a wrong time, and gets the time of writing."""
STEP_MG = 1.0
"""Steps of the logged field."""


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
    ordered = sorted(found, key=lambda place: (not parameters.get(_used(numbers[place]), 1.0), place))
    return {str(place + 1): _compass(log, found[place], parameters, numbers[place]) for place in ordered}


def _used(compass: int) -> str:
    return f"COMPASS_USE{suffix(compass)}"


def _measures(rows: Messages) -> bool:
    """Whether a compass gives any field at all."""
    return all(name in rows for name in FIELD) and bool(rows.vector(*FIELD).any())


def _compass(log: Dataflash, rows: Messages, parameters: Parameters, number: int) -> Compass:
    healthy = rows.numbers("Health") != 0 if "Health" in rows else np.ones(len(rows), np.bool_)
    lost = int(np.sum(~healthy))
    notes = [f"{lost} of {len(rows)} samples left out: the autopilot calls the compass unhealthy there"] if lost else []
    rows = rows.where(healthy)
    field_mG, motor_mG = whole_steps(rows, FIELD), _motor_term(rows)
    if number in COMPASSES and any(name in parameters for name in calibration_names(number)):
        raw_mG, told = _undone(log, rows, parameters, number, field_mG, motor_mG)
        applied = compass_calibration(parameters, number).applied(own_parameters(parameters, number))
    else:
        raw_mG, told, applied = field_mG, [_nothing(rows, number)], None
    columns = vector_columns("mag", flu_from_frd(raw_mG) * MILLIGAUSS_NT)
    return Compass(Stream(sample_times_s(log, rows), columns), applied, (*notes, *told))


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


def _motor_term(rows: Messages) -> Array:
    """Return the motors' term k p that the autopilot added, mG (n, 3)."""
    names = next((names for names in MOTOR if all(name in rows for name in names)), None)
    return np.zeros((len(rows), 3)) if names is None else whole_steps(rows, names)


def _undone(
    log: Dataflash, rows: Messages, parameters: Parameters, number: int, field_mG: Array, motor_mG: Array
) -> tuple[Array, list[str]]:
    """Return the field before calibration, mG (n, 3), undone with the parameters in force at each time; and notes."""
    names, times_s = calibration_names(number), log.times_s(rows)
    changes_s = parameters.changes_s(names)
    piece = np.searchsorted(changes_s, times_s, "right")
    raw_mG, learned = np.empty_like(field_mG), np.zeros(len(rows), np.bool_)
    for k in np.unique(piece):
        here = piece == k
        calibration = compass_calibration(parameters.at([-np.inf, *changes_s][k], names), number)
        offset_mG, learned[here] = _offsets(rows.where(here), calibration.offset_mG)
        raw_mG[here] = calibration.raw_mG(field_mG[here], motor_mG[here], offset_mG)
    notes = [told_undone(parameters.last, number, bool(motor_mG.any()))]
    if len(np.unique(piece)) > 1:
        notes.append(
            f"compass {number}: its calibration changed in the log ({len(changes_s)} times): undone piece by piece"
        )
    if learned.any():
        share = f"{np.count_nonzero(learned)} of {len(rows)} samples"
        notes.append(f"compass {number}: {share} have other offsets than the parameters; those logged are undone")
    return raw_mG, notes


def _offsets(rows: Messages, stated_mG: Array) -> tuple[Array, Array]:
    """Return the offsets of each sample (n, 3), and where (n,) they differ from the stated offsets.

    Logged offsets are cut to whole mG; where they fit the parameter, the parameter is the finer value.
    """
    stated = np.tile(stated_mG, (len(rows), 1))
    if not all(name in rows for name in OFFSET):
        return stated, np.zeros(len(rows), np.bool_)
    logged = rows.vector(*OFFSET)
    other = np.any(np.abs(logged - stated) >= STEP_MG, axis=1)
    return np.where(other[:, None], whole_steps(rows, OFFSET), stated), other


def told_undone(last: Mapping[str, float], number: int, motors: bool) -> str:
    """Return the line that says what was undone, with the parameters that differ from a compass without calibration."""
    neutral = {name: 1.0 if "_DIA" in name else 0.0 for name in calibration_names(number)}
    values = [f"{name} {last[name]:.4g}" for name, value in neutral.items() if last.get(name, value) != value]
    values += ["the motors' term MOX, MOY, MOZ"] if motors else []
    if not values:
        return f"ArduPilot's calibration of compass {number}: nothing to undo"
    return f"ArduPilot's calibration of compass {number} undone ({', '.join(values)})"


def _nothing(rows: Messages, number: int) -> str:
    """Return the line about a log without parameters."""
    moved = all(name in rows for name in OFFSET) and np.ptp(rows.vector(*OFFSET), axis=0).any()
    changed = "; the offsets in it changed on the way" if moved else ""
    return f"no parameters of compass {number}: the field is as the autopilot used it, nothing can be undone{changed}"
