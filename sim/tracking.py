"""Tracking error: distance between vehicle and path; large where wind or current exceed the actuators."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from recordings.metadata import Tracking

if TYPE_CHECKING:  # readers of a dataset need no engine
    from scenarios.paths import Phase
    from sim.motion import Motion

LIMIT_M = 1.0
"""Largest distance that goes without a warning.

In sweeps of wind and current a vehicle that its actuators can hold stays within 0.8 m (the catalogue's within 0.08 m);
beyond what they can hold it is metres off at once, and the distance grows with the length of the run.
"""
REMEDY = "the data hold what it did instead; ask for less wind or current, or a gentler motion"


class Tracker:
    """Accumulates the tracking error of a run, block by block.

    Guided phases count from the end of the settling time; unpowered dives and the turntable do not count.
    """

    def __init__(self, phases: Sequence[Phase]) -> None:
        self._phases = phases
        self._count, self._sum_m2, self._max_m2 = 0, 0.0, 0.0

    def see(self, motion: Motion) -> None:
        """Take in the next block."""
        phase = self._phases[motion.phase]
        if not phase.tracked:
            return
        apart_m = (motion.reference[:, :3] - motion.kinematics.pos_enu_m)[motion.phase_time_s > phase.settle_s]
        apart_m2 = np.sum(apart_m**2, axis=1)
        self._count += len(apart_m2)
        self._sum_m2 += float(apart_m2.sum())
        self._max_m2 = max(self._max_m2, float(apart_m2.max(initial=0.0)))

    @property
    def tracking(self) -> Tracking | None:
        """The tracking so far; None where nothing counted."""
        if not self._count:
            return None
        return Tracking(math.sqrt(self._sum_m2 / self._count), math.sqrt(self._max_m2))


def together(runs: Iterable[Tracking | None]) -> Tracking | None:
    """The tracking error of several runs of equal length; None where no run has any."""
    known = [run for run in runs if run is not None]
    if not known:
        return None
    return Tracking(math.sqrt(sum(run.rms_m**2 for run in known) / len(known)), max(run.max_m for run in known))


def warning(runs: Sequence[Tracking | None]) -> str:
    """A line about vehicles farther from the path than LIMIT_M; empty where all follow."""
    lost = [run for run in runs if run is not None and run.max_m > LIMIT_M]
    if not lost:
        return ""
    worst = max(lost, key=lambda run: run.max_m)
    where = f" in {len(lost)} of {len(runs)} runs" if len(runs) > 1 else ""
    far = f"up to {worst.max_m:.1f} m off, {worst.rms_m:.1f} m rms"
    return f"the vehicle does not follow its path{where}: {far} ({REMEDY})"
