"""Empty cells between the values of a column that was logged at a lower rate than the field."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from scenarios.errors import InputError

MAX_GAP_INTERVALS = 5.0
"""A stretch without values that is longer than so many of the column's own intervals is an outage."""
_NORM_TOLERANCE = 0.02
_UNIT_TO_ROUNDING = 1e-9


def filled(time_s: Array, known: NDArray[np.bool_], values: Array, *, rotation: bool = False) -> Array:
    """Values (n, k) of which the known rows stay: linear in time between these, and constant beyond them.

    rotation : the rows are quaternions and take the shorter arc.
    """
    if known.all():
        return values
    nodes = _same_sign(values[known]) if rotation else values[known]
    between = np.column_stack([np.interp(time_s, time_s[known], node) for node in nodes.T])
    if rotation:
        between = between / np.linalg.norm(between, axis=1, keepdims=True)
    return np.where(known[:, None], values, between)


def unit_quaternions(path: Path, names: Sequence[str], q: Array, known: NDArray[np.bool_]) -> Array:
    """Unit quaternions; what is off by more than rounding is normalised, what is off by more than 2 % refused."""
    norm = np.where(known, np.linalg.norm(q, axis=1), 1.0)
    wrong = np.abs(norm - 1) > _NORM_TOLERANCE
    if wrong.any():
        row = int(np.argmax(wrong)) + 1
        what = f"row {row} has norm {norm[row - 1]:.4g}, a unit quaternion w x y z is expected"
        do = "check the order and scale of the columns, or remove them"
        raise InputError(what, where=f"{path}: {names[0]} … {names[-1]}", do=do)
    return np.where((np.abs(norm - 1) > _UNIT_TO_ROUNDING)[:, None], q / norm[:, None], q)


def check_outage(path: Path, name: str, time_s: Array, known: NDArray[np.bool_]) -> None:
    """Refuse a stretch without values much longer than the column's own interval."""
    if known.all():
        return
    at = time_s[known]
    interval = float(np.median(np.diff(at))) if len(at) > 1 else 0.0
    edges = np.r_[time_s[0], at, time_s[-1]]
    lengths = np.diff(edges)
    longest = int(np.argmax(lengths))
    if lengths[longest] > MAX_GAP_INTERVALS * interval:
        row = int(np.argmax(~known & (time_s >= edges[longest]))) + 1
        what = f"no value for {lengths[longest]:.4g} s from row {row} on, {np.count_nonzero(~known)} rows are empty"
        raise InputError(what, where=f"{path}: {name}", do="fill it, cut the recording there, or remove the column")


def _same_sign(q: Array) -> Array:
    """q and -q are the same attitude: choose signs so that neighbours lie on the shorter arc."""
    turns = np.sign(np.sum(q[1:] * q[:-1], axis=1))
    return q * np.cumprod(np.r_[1.0, np.where(turns == 0, 1.0, turns)])[:, None]
