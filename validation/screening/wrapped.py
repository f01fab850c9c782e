"""Wrapped counts: an axis that overflows its integer and goes on at the other end of the range."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calib.numerics.noise import white_noise_std
from calib.numerics.scans import extremes, largest_steps
from recordings import Recording
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.screening.fault import AXES, Fault
from validation.screening.full_scale import near_end
from validation.signals.intervals import gaps_after
from validation.signals.lattice import find_lattice
from validation.text import counted, figure

BITS = range(8, 33)
"""Widths of the integers of converters."""


def wrapped(recording: Recording) -> list[Fault]:
    """Return the rows in which an axis has wrapped: unwrapped where the period is known, else left out."""
    found, mag_nT = [], recording.mag_nT
    suspects = np.flatnonzero(_may_wrap(mag_nT))
    gaps = gaps_after(recording.time_s) if len(suspects) else np.zeros(0, np.intp)
    for axis in suspects.tolist():
        jumps = _jumps(mag_nT[:, axis], gaps)
        if len(jumps):
            found.append(_fault(mag_nT, axis, jumps))
            mag_nT = mag_nT if found[-1].mended_nT is None else found[-1].mended_nT
    return found


def _fault(mag_nT: Array, axis: int, jumps: NDArray[np.intp]) -> Fault:
    column = mag_nT[:, axis]
    seen = _heights(column, jumps)
    period, bits = _period(mag_nT, float(np.median(np.abs(seen))), _usual(np.abs(np.diff(column))))
    turn = np.zeros(len(column), np.intp)
    turn[jumps + 1] = np.where(seen < 0, 1, -1)
    turn = np.cumsum(turn)
    values, often = np.unique(turn, return_counts=True)
    turn -= values[np.argmax(often)]
    text = (
        f"axis {AXES[axis]} wraps {counted(len(jumps), 'time')}, by {figure(period or np.median(np.abs(seen)), 6)} nT"
    )
    if period is None:
        noise = float(np.nan_to_num(white_noise_std(column[:, None]))[0])
        near = near_end(column, float(column.max()), noise) | near_end(-column, -float(column.min()), noise)
        return Fault("wrapped", f"{text}: integers that overflow", (turn != 0) | near)
    mended = mag_nT.copy()
    mended[:, axis] += turn * period
    return Fault("wrapped", f"{text}: integers of {bits} bits that overflow", turn != 0, "unwrapped", False, mended)


def _may_wrap(mag_nT: Array) -> NDArray[np.bool_]:
    """Return the axes (3,) with a step as large as a wrap: nearly the whole range, where usual steps are small."""
    ends = extremes(mag_nT)
    return np.asarray(largest_steps(mag_nT) > (1 - POLICY.wrap_ends * POLICY.wrap_smooth) * (ends.high - ends.low))


def _usual(step: Array) -> float:
    return float(np.quantile(step, POLICY.wrap_usual)) if len(step) else 0.0


def _jumps(column: Array, gaps: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the samples of an axis (n,) before a wrap; none where the motion between samples is not small.

    A wrap goes from one end of the range to the other, the course before and after heading on; values lie between.
    """
    step, none = np.diff(column), np.zeros(0, np.intp)
    if len(column) < POLICY.least_rows:
        return none
    usual, width = _usual(np.abs(step)), float(np.ptp(column))
    middle = np.abs(column - (column.max() + column.min()) / 2) < POLICY.wrap_quarter * width
    if not 0 < usual < POLICY.wrap_smooth * width or middle.mean() < POLICY.wrap_middle:
        return none
    far = np.flatnonzero(np.abs(step) > width - POLICY.wrap_ends * usual)
    far = far[~np.isin(far, gaps) & (far > 0) & (far < len(step) - 1)]
    if not len(far):
        return none
    heading = -np.sign(step[far])
    on = (heading * step[far - 1] > 0) & (heading * step[far + 1] > 0)
    return far if on.mean() >= POLICY.wrap_heading else none


def _heights(column: Array, jumps: NDArray[np.intp]) -> Array:
    """Return the jumps (m,) of an axis less the motion, the mean of the steps before and after."""
    step = np.diff(column)
    usual = _usual(np.abs(step))
    motion = np.clip(step, -usual, usual)  # the step beside may be a wrap too
    return np.asarray(step[jumps] - (motion[jumps - 1] + motion[jumps + 1]) / 2)


def _period(mag_nT: Array, height: float, usual: float) -> tuple[float | None, int]:
    """Return the power of two of a converter's step that a jump is, and its bits; None where no power is near.

    The axes (n, 3) share a converter, whose step may be visible on one alone.
    """
    for column in mag_nT.T:
        lattice = find_lattice(column)
        if lattice is not None and not lattice.floating:
            bits = int(np.rint(np.log2(height / lattice.step)))
            if bits in BITS and abs(lattice.step * 2.0**bits - height) < usual:
                return lattice.step * 2.0**bits, bits
    return None, 0
