"""Empty cells between the values of a column that was logged at a lower rate than the field."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recordings.streams import MAX_GAP_INTERVALS, Interpolation, interpolated, own_interval_s
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.text import figure

_NORM_TOLERANCE = 0.02
_UNIT_TO_ROUNDING = 1e-9


def filled(time_s: Array, known: NDArray[np.bool_], values: Array, how: Interpolation = Interpolation.LINEAR) -> Array:
    """Return values (n, k) with the unknown rows interpolated between the known rows, and constant beyond these."""
    if known.all():
        return values
    return np.where(known[:, None], values, interpolated(time_s, time_s[known], values[known], how))


def unit_quaternions(path: Path, names: Sequence[str], q: Array, known: NDArray[np.bool_]) -> Array:
    """Return unit quaternions (n, 4); a norm that is off by more than rounding is normalised, by over 2 % refused."""
    norm = np.where(known, np.linalg.norm(q, axis=1), 1.0)
    wrong = np.abs(norm - 1) > _NORM_TOLERANCE
    if wrong.any():
        row = int(np.argmax(wrong)) + 1
        what = f"row {row} has norm {figure(norm[row - 1], 4)}, a unit quaternion w x y z is expected"
        do = "check the order and scale of the columns, or remove them"
        raise InputError(what, where=f"{path}: {names[0]} … {names[-1]}", do=do)
    return np.where((np.abs(norm - 1) > _UNIT_TO_ROUNDING)[:, None], q / norm[:, None], q)


def check_outage(path: Path, name: str, time_s: Array, known: NDArray[np.bool_]) -> None:
    """Raise InputError for a stretch of unknown rows longer than MAX_GAP_INTERVALS of the column's own intervals."""
    if known.all():
        return
    edges_s = np.r_[time_s[0], time_s[known], time_s[-1]]
    lengths_s = np.diff(edges_s)
    longest = int(np.argmax(lengths_s))
    if lengths_s[longest] > MAX_GAP_INTERVALS * own_interval_s(time_s[known]):
        row = int(np.argmax(~known & (time_s >= edges_s[longest]))) + 1
        empty = np.count_nonzero(~known)
        what = f"no value for {figure(lengths_s[longest], 4)} s from row {row} on, {empty} rows are empty"
        raise InputError(what, where=f"{path}: {name}", do="fill it, cut the recording there, or remove the column")
