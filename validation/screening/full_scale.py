"""Full scale: samples cut off at the end of the converter's range."""

from __future__ import annotations

import numpy as np

from calib.numerics.noise import white_noise_std
from calib.numerics.scans import extremes
from recordings import Recording
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.screening.fault import AXES, Fault, Mask
from validation.signals.faults import STENCIL, PileUp, pile_up
from validation.signals.lattice import find_lattice
from validation.text import counted, figure, listed


def full_scale(recording: Recording) -> list[Fault]:
    """Return the rows in which an axis is at a full scale; the level of an axis counts at both ends of every axis."""
    mag_nT = recording.mag_nT
    found = extremes(mag_nT)
    if (found.low_count + found.high_count).max() < POLICY.least_at_level:
        return []
    piles = pile_up(mag_nT, tuple(find_lattice(axis) for axis in mag_nT.T))
    if not piles:
        return []
    rows = at_full_scale(recording, piles)
    ends = [f"{AXES[one.axis]} at {figure(one.level, 6)} nT ({counted(one.count, 'sample')})" for one in piles]
    detail = tuple({"axis": AXES[p.axis], "side": p.side, "level_nT": p.level, "samples": p.count} for p in piles)
    return [Fault("full_scale", f"saturated, cut off at full scale: {listed(ends)}", rows, detail=detail)]


def at_full_scale(recording: Recording, found: list[PileUp]) -> Mask:
    """Return the rows (n,) with a value at one of the levels, or that the neighbours show to be near."""
    rows = np.zeros(len(recording), np.bool_)
    noise = np.nan_to_num(white_noise_std(recording.mag_nT))
    for one in found:
        sign = 1.0 if one.side == "high" else -1.0
        rows |= near_end(sign * recording.mag_nT[:, one.axis], sign * one.level, float(noise[one.axis]))
    return rows


def near_end(column: Array, level: float, noise: float) -> Mask:
    """Return the rows of an axis (n,) at a level, or within four standard deviations of the level by their neighbours.

    e_i = (4 (v_{i-1} + v_{i+1}) - v_{i-2} - v_{i+2}) / 6

    A row's own noise must not decide whether the row stays: rows kept below a level have noise that points away from
    the level, which moves an offset by more than its claim.
    """
    rows: Mask = np.asarray(column >= level)
    if len(column) > STENCIL:
        expected = (4 * (column[1:-3] + column[3:-1]) - column[:-4] - column[4:]) / 6
        rows[2:-2] |= expected > level - POLICY.near_end_sigma * noise
    return rows
