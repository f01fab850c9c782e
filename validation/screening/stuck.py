"""Stuck values: the whole sensor frozen, held at a slower rate, or an axis that stays while the others move."""

from __future__ import annotations

import numpy as np

from recordings import Recording
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.screening.fault import AXES, Fault, Mask
from validation.signals.faults import repeats, runs
from validation.signals.held import stale
from validation.text import counted, figure, frequency


def frozen(recording: Recording) -> list[Fault]:
    """Return the rows that repeat all three axes for longer than noise and rate allow."""
    found = repeats(recording.mag_nT).frozen
    if not found:
        return []
    rows = _after_first(len(recording), found)
    return [Fault("frozen", f"the sensor is frozen {counted(len(found), 'time')}, all axes keep their values", rows)]


def held(recording: Recording) -> list[Fault]:
    """Return the rows between the samples of a sensor that is slower than the log."""
    mag_nT = recording.mag_nT
    if not stale(mag_nT):
        return []
    first, _ = runs(mag_nT)
    rows = np.ones(len(recording), np.bool_)
    rows[first] = False
    rate = frequency((len(first) - 1) / float(np.ptp(recording.time_s[first])))
    return [Fault("held", f"each value is held over several rows, the sensor samples at {rate}", rows)]


def stuck(recording: Recording) -> list[Fault]:
    """Return the rows in which an axis keeps its value while the others move on."""
    found = []
    for axis, column in enumerate(recording.mag_nT.T):
        values = column[:, None]
        stays = [one for one in repeats(values).frozen if not _cut_off(column, *one)]
        if stays:
            level = figure(float(column[max(stays, key=lambda one: one[1])[0]]), 5)
            times = "" if len(stays) == 1 else f" and {counted(len(stays) - 1, 'more time')}"
            text = f"axis {AXES[axis]} is stuck at {level} nT{times}"
            found.append(Fault("stuck", text, _after_first(len(recording), stays)))
    return found


def _after_first(total: int, found: list[tuple[int, int]] | tuple[tuple[int, int], ...]) -> Mask:
    """Return the rows (n,) of runs (first row, rows) that repeat the first."""
    rows = np.zeros(total, np.bool_)
    for first, length in found:
        rows[first + 1 : first + length] = True
    return rows


def _cut_off(column: Array, first: int, length: int) -> bool:
    """Return whether a run of equal values of an axis (n,) lies at the end of the range and is left without a jump.

    A run at the end of the recording is left by nothing: cut off if the level is met in other runs too.
    """
    level = column[first]
    if column.min() < level < column.max():
        return False
    after = first + length
    others = np.count_nonzero(column == level) > length
    if after >= len(column) or first == 0:
        return bool(others)
    step = np.abs(np.diff(column))
    usual = float(np.quantile(step[step > 0], POLICY.wrap_usual)) if step.any() else 0.0
    return bool(abs(column[after] - level) <= POLICY.cut_off_usual * usual)
