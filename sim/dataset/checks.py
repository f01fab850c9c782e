"""What a measured log must satisfy before anything is computed from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.errors import InputError
from sim.dataset.columns import ACCEL, ATTITUDE, GYRO, POSITION, group_of, mag_names, numbers
from sim.dataset.recording import Array
from sim.dataset.units import likely_unit

MIN_SAMPLES = 10
MAX_GAP_INTERVALS = 5.0
FIELD_RANGE_NT = (1_000.0, 500_000.0)
_NORM_TOLERANCE = 0.02
_UNIT_TO_ROUNDING = 1e-9
Named = dict[str, NDArray[Any]]


def check_length(path: Path, samples: int) -> None:
    """Enough samples to calibrate anything."""
    if samples < MIN_SAMPLES:
        what = f"holds {samples} samples, at least {MIN_SAMPLES} are needed"
        raise InputError(what, where=str(path), do="give a longer recording")


def check_time(path: Path, time_s: Array) -> None:
    """Finite and increasing; InputError names the first row that is not."""
    _check_finite(path, "time_s", time_s)
    step = np.diff(time_s)
    if np.all(step > 0):
        return
    row = int(np.argmax(step <= 0)) + 2
    found = f"{float(time_s[row - 1])!r}"
    if step[row - 2] == 0:
        what, do = f"row {row} repeats the time {found}", "remove repeated rows, or give a time of higher resolution"
    else:
        what, do = f"row {row} goes back to {found}", "sort the rows by time, or give one recording a file"
    count = int(np.count_nonzero(step <= 0))
    raise InputError(what + (f", as do {count - 1} more" if count > 1 else ""), where=f"{path}: time_s", do=do)


def check_mag(path: Path, named: Mapping[str, NDArray[Any]]) -> None:
    """Every magnetometer: finite, no axis stuck, of a strength that can be nT."""
    sensors = numbers("mag", tuple(named))
    for names in [mag_names(k) for k in sensors] or [mag_names()]:
        for name in names:
            _check_finite(path, name, named[name])
        field_nT = np.column_stack([named[name] for name in names])
        _check_moving(path, names, field_nT)
        _check_strength(path, names, field_nT)


def check_complete(path: Path, named: Mapping[str, Any], names: Sequence[str], *, optional: bool) -> None:
    """A vector has all its components or none; an optional one may have some, which are then channels."""
    missing = [name for name in names if name not in named]
    if missing and len(missing) < len(names) and not optional:
        present = next(name for name in names if name in named)
        do = f"add it, name it with --map {missing[0]}=…, or rename {present} to keep it as a channel"
        raise InputError(f"there is no column {missing[0]} beside {present}", where=str(path), do=do)


def fill_gaps(path: Path, named: Named) -> Named:
    """Columns with every cell filled, see `read_measured`; InputError for an outage and for infinite values."""
    filled = dict(named)
    vectors = [names for names in (GYRO, ACCEL, ATTITUDE, POSITION) if all(name in named for name in names)]
    alone = [(name,) for name in named if name != "phase" and not any(name in names for names in vectors)]
    for names in (*vectors, *alone):
        values = np.column_stack([named[name] for name in names])
        if group_of(names[0]) == "channel":
            values = np.where(np.isinf(values), np.nan, values)
            if not np.isfinite(values).any():
                del filled[names[0]]
                continue
        filled |= dict(zip(names, _filled(path, names, named["time_s"], values).T, strict=True))
    return filled


def _filled(path: Path, names: Sequence[str], time_s: Array, values: Array) -> Array:
    for name, column in zip(names, values.T, strict=True):
        if np.isinf(column).any():
            _check_finite(path, name, column)
    group = group_of(names[0])
    known = np.asarray(np.isfinite(values).all(axis=1), np.bool_)
    if not known.any():
        where = f"{path}: {', '.join(names)}"
        raise InputError("no row has a value in every one of them", where=where, do="remove the columns")
    if group == "attitude":
        values = _unit(path, names, values, known)
    if known.all():
        return values
    if group != "channel":
        _check_gaps(path, names, time_s, known)
    return np.where(known[:, None], values, _between(time_s, known, values[known], group == "attitude"))


def _between(time_s: Array, known: NDArray[np.bool_], nodes: Array, rotation: bool) -> Array:
    """Linear in time between the known rows and constant beyond them; quaternions on the shorter arc."""
    nodes = _same_sign(nodes) if rotation else nodes
    between = np.column_stack([np.interp(time_s, time_s[known], node) for node in nodes.T])
    return between / np.linalg.norm(between, axis=1, keepdims=True) if rotation else between


def _unit(path: Path, names: Sequence[str], q: Array, known: NDArray[np.bool_]) -> Array:
    """Unit quaternions; what is off by more than rounding is normalised, what is off by more than 2 % refused."""
    norm = np.where(known, np.linalg.norm(q, axis=1), 1.0)
    wrong = np.abs(norm - 1) > _NORM_TOLERANCE
    if wrong.any():
        row = int(np.argmax(wrong)) + 1
        what = f"row {row} has norm {norm[row - 1]:.4g}, a unit quaternion w x y z is expected"
        do = "check the order and scale of the columns, or remove them"
        raise InputError(what, where=f"{path}: {names[0]} … {names[-1]}", do=do)
    return np.where((np.abs(norm - 1) > _UNIT_TO_ROUNDING)[:, None], q / norm[:, None], q)


def _same_sign(q: Array) -> Array:
    """q and -q are the same attitude: choose signs so that neighbours lie on the shorter arc."""
    turns = np.sign(np.sum(q[1:] * q[:-1], axis=1))
    return q * np.cumprod(np.r_[1.0, np.where(turns == 0, 1.0, turns)])[:, None]


def _check_gaps(path: Path, names: Sequence[str], time_s: Array, known: NDArray[np.bool_]) -> None:
    """Refuse an outage: a stretch without values much longer than the column's own interval."""
    at = time_s[known]
    interval = float(np.median(np.diff(at))) if len(at) > 1 else 0.0
    edges = np.r_[time_s[0], at, time_s[-1]]
    lengths = np.diff(edges)
    longest = int(np.argmax(lengths))
    if lengths[longest] > MAX_GAP_INTERVALS * interval:
        row = int(np.argmax(~known & (time_s >= edges[longest]))) + 1
        what = f"no value for {lengths[longest]:.4g} s from row {row} on, {np.count_nonzero(~known)} rows are empty"
        raise InputError(what, where=f"{path}: {names[0]}", do="fill it, cut the recording there, or remove the column")


def _check_finite(path: Path, name: str, values: Array) -> None:
    wrong = ~np.isfinite(values)
    if wrong.any():
        count, row = int(np.count_nonzero(wrong)), int(np.argmax(wrong)) + 1
        kind = "infinite" if np.isinf(values[row - 1]) else "missing"
        what = f"{count} of {len(values)} values are missing or infinite, the first in row {row} is {kind}"
        raise InputError(what, where=f"{path}: {name}", do="remove these rows")


def _check_moving(path: Path, names: Sequence[str], field_nT: Array) -> None:
    stuck = [name for name, width in zip(names, np.ptp(field_nT, axis=0), strict=True) if width == 0]
    if len(stuck) == len(names):
        what, do = "all three axes are constant: the sensor did not measure or did not move", "give another recording"
        raise InputError(what, where=f"{path}: {', '.join(stuck)}", do=do)
    if stuck:
        what = f"is {field_nT[0, names.index(stuck[0])]:g} in every row: the axis is stuck"
        do = "check the sensor's axis, or map another column with --map"
        raise InputError(what, where=f"{path}: {stuck[0]}", do=do)


def _check_strength(path: Path, names: Sequence[str], field_nT: Array) -> None:
    strength = float(np.median(np.linalg.norm(field_nT, axis=1)))
    low, high = FIELD_RANGE_NT
    if low <= strength <= high:
        return
    unit = likely_unit(strength)
    guess = f"it looks like {unit}" if unit else "it may be raw counts"
    option = f"unit={unit}" if unit else "scale=<nT a count>"
    what = f"median |m| is {strength:.4g}, not between {low:,.0f} and {high:,.0f} nT: {guess}"
    do = f"say so with --map {names[0]}=<column>,{option} and the like for the other axes"
    raise InputError(what, where=f"{path}: {', '.join(names)}", do=do)
