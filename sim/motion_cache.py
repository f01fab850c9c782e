"""Cache of motions: runs that differ in errors and noise alone share one motion."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from threading import Lock

import numpy as np

from recordings.files import canonical_json
from scenarios.toml import as_dict
from sim.motion import Motion
from sim.simulation import PreparedRun, true_motion
from sim.vehicles import vehicle_for

MOST_BYTES = 200_000_000
"""Memory of the cache of a process: some forty motions of 20 min at 10 Hz; larger motions are not kept."""


@dataclass
class MotionCache:
    """The most recently used motions, up to `most_bytes` in total.

    Threads of a process may share a cache.
    Runs share a motion if vehicle, phases and sampling are equal and the flow draws no random numbers.
    """

    most_bytes: int = MOST_BYTES
    _kept: OrderedDict[str, tuple[Motion, ...]] = field(default_factory=OrderedDict, repr=False)
    _lock: Lock = field(default_factory=Lock, repr=False)

    def motions(self, plan: PreparedRun) -> Iterator[Motion]:
        """The run's true motion, block by block; equal to the bit whether computed or cached."""
        key = motion_key(plan)
        kept = self._found(key)
        if kept is not None:
            yield from kept
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

    def _found(self, key: str) -> tuple[Motion, ...] | None:
        """Return a kept motion, now the most recently used."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
            return self._kept.get(key)

    def _keep(self, key: str, blocks: tuple[Motion, ...]) -> None:
        with self._lock:
            self._kept[key] = blocks
            while sum(size_of(motion) for kept in self._kept.values() for motion in kept) > self.most_bytes:
                self._kept.popitem(last=False)


def run_key(plan: PreparedRun) -> str:
    """Key of a run but for the noise of the sensors: motion, field and errors as drawn."""
    return canonical_json({"drawn": as_dict(plan.drawn), "motion": motion_key(plan)})


def motion_key(plan: PreparedRun) -> str:
    """Key of a motion: equal for two runs exactly when the motions are equal."""
    said = as_dict(plan.drawn)
    key = {name: said[name] for name in ("vehicle", "phases", "sampling")} | {"finer": plan.finer}
    if vehicle_for(plan.drawn.vehicle).random_flow:
        key |= {"seed": plan.seed, "run": plan.run}
    return canonical_json(key)


def size_of(motion: Motion) -> int:
    """Memory of a block of motion, bytes."""
    return sum(array.nbytes for array in _arrays(motion))


def _read_only(motion: Motion) -> Motion:
    """The block with all arrays write-protected."""
    for array in _arrays(motion):
        array.flags.writeable = False
    return motion


def _arrays(motion: Motion) -> list[np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    values = [getattr(part, item.name) for part in (motion, motion.kinematics) for item in fields(part)]
    finer = [] if motion.finer is None else _arrays(motion.finer)
    return [value for value in (*values, *motion.channels.values()) if isinstance(value, np.ndarray)] + finer
