"""Full scale: samples cut off at the end of the converter's range."""

from __future__ import annotations

import numpy as np

from recordings import Recording
from validation.policy import POLICY
from validation.screening.fault import AXES, Fault, Mask
from validation.signals.faults import PileUp, pile_up
from validation.signals.lattice import find_lattice
from validation.text import counted, figure, listed


def full_scale(recording: Recording) -> list[Fault]:
    """Return the rows in which an axis is at a full scale; the level of an axis counts at both ends of every axis."""
    mag_nT = recording.mag_nT
    ends = np.r_[mag_nT == mag_nT.min(axis=0), mag_nT == mag_nT.max(axis=0)]
    if ends.sum(axis=0).max() < POLICY.least_at_level:
        return []
    found = pile_up(mag_nT, tuple(find_lattice(axis) for axis in mag_nT.T))
    if not found:
        return []
    rows = at_full_scale(recording, found)
    ends = [f"{AXES[one.axis]} at {figure(one.level, 6)} nT ({counted(one.count, 'sample')})" for one in found]
    detail = tuple({"axis": AXES[p.axis], "side": p.side, "level_nT": p.level, "samples": p.count} for p in found)
    return [Fault("full_scale", f"saturated, cut off at full scale: {listed(ends)}", rows, detail=detail)]


def at_full_scale(recording: Recording, found: list[PileUp]) -> Mask:
    """Return the rows (n,) with a value at one of the levels or beyond."""
    rows = np.zeros(len(recording), np.bool_)
    for one in found:
        column = recording.mag_nT[:, one.axis]
        rows |= column >= one.level if one.side == "high" else column <= one.level
    return rows
