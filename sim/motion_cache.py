"""Motions that are used again: runs that differ in errors and noise alone share their physics."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, field, fields

import numpy as np

from recordings.files import canonical_json
from scenarios.toml import as_dict
from sim.motion import Motion
from sim.simulation import PreparedRun, true_motion
from sim.vehicles import vehicle_for

MOST_BYTES = 200_000_000
"""What one process keeps: some forty motions of 20 min at 10 Hz; a motion larger than that is flown each time."""


@dataclass
class MotionCache:
    """The motions that were asked for last, `most_bytes` of them in all.

    Runs share a motion where vehicle, phases and sampling are the same and the flow draws no random numbers.
    """

    most_bytes: int = MOST_BYTES
    _kept: OrderedDict[str, tuple[Motion, ...]] = field(default_factory=OrderedDict, repr=False)

    def motions(self, plan: PreparedRun) -> Iterator[Motion]:
        """The run's true motion, block by block, the same to the bit whether it is flown now or was before."""
        key = motion_key(plan)
        if key in self._kept:
            self._kept.move_to_end(key)
            yield from self._kept[key]
            return
        blocks: list[Motion] = []
        size = 0
        for motion in true_motion(plan):
            size += size_of(motion)
            if size <= self.most_bytes:
                blocks.append(_read_only(motion))
            yield motion
        if size <= self.most_bytes:
            self._keep(key, tuple(blocks))

    def _keep(self, key: str, blocks: tuple[Motion, ...]) -> None:
        self._kept[key] = blocks
        while sum(size_of(motion) for kept in self._kept.values() for motion in kept) > self.most_bytes:
            self._kept.popitem(last=False)


def run_key(plan: PreparedRun) -> str:
    """What decides a run but for the noise of its sensors, as text: motion, field and errors as they were drawn."""
    return canonical_json({"drawn": as_dict(plan.drawn), "motion": motion_key(plan)})


def motion_key(plan: PreparedRun) -> str:
    """What decides the motion, as text: equal for two runs exactly when their motions are."""
    said = as_dict(plan.drawn)
    key = {name: said[name] for name in ("vehicle", "phases", "sampling")} | {"finer": plan.finer}
    if vehicle_for(plan.drawn.vehicle).random_flow:
        key |= {"seed": plan.seed, "run": plan.run}
    return canonical_json(key)


def size_of(motion: Motion) -> int:
    """Bytes that a block of motion holds."""
    return sum(array.nbytes for array in _arrays(motion))


def _read_only(motion: Motion) -> Motion:
    """The same block, which nobody can write to."""
    for array in _arrays(motion):
        array.flags.writeable = False
    return motion


def _arrays(motion: Motion) -> list[np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    values = [getattr(part, item.name) for part in (motion, motion.kinematics) for item in fields(part)]
    finer = [] if motion.finer is None else _arrays(motion.finer)
    return [value for value in (*values, *motion.channels.values()) if isinstance(value, np.ndarray)] + finer
