"""The axes of a bag's sensors turned to the vehicle's body, FLU, and attitudes to east, north, up."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from recordings.readers.quaternions import inverse, product, rotated
from recordings.readers.ros.mounts import IDENTITY, Mounts, plain, says_down
from scenarios.arrays import Array

ROLLED = np.array([0.0, 1.0, 0.0, 0.0])
"""Half a turn about x: forward, right, down to forward, left, up."""
NORTH_EAST = np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])
"""North, east, down to east, north, up."""
LEAST_UP = 0.9
"""Median cosine between up and the specific force in the world, beyond which an attitude and a force agree."""


@dataclass(eq=False)
class BodyAxes:
    """The turns of sensors' frames to a body.

    Parameters
    ----------
    mounts : the transforms of the bag. body : the frame that the recording is in.
    down : frames whose axes are forward, right, down. notes : a line for each turn that was made.
    """

    mounts: Mounts
    body: str
    down: set[str] = field(default_factory=set)
    notes: list[str] = field(default_factory=list)

    def told(self, frame: str) -> bool:
        """Return whether the bag tells how a frame lies in the body."""
        return plain(frame) == plain(self.body) or self.mounts.turn(frame, self.body) is not None

    def turn(self, frame: str) -> Array:
        """Return the rotation (4,) from a frame to the body; a mount that turns z over has turned FRD already."""
        mount = self.mounts.turn(frame, self.body)
        q = np.array(IDENTITY) if mount is None else mount
        upright = rotated(q, np.array([[0.0, 0.0, 1.0]]))[0, 2] > 0
        return product(q, ROLLED) if upright and self.is_down(frame) else q

    def is_down(self, frame: str) -> bool:
        """Return whether a frame's axes are forward, right, down, by its name or by gravity.

        In a bag without transforms all frames share their axes.
        """
        return plain(frame) in self.down or says_down(frame) or bool(self.down and not self.mounts.of)

    def vectors(self, frame: str, values: Array) -> Array:
        """Return vectors (n, 3) of a frame in the body."""
        q = self.turn(frame)
        if abs(q[0]) > 1 - 1e-9:
            return values
        self._note(frame)
        return rotated(q, values)

    def attitude(self, frame: str, q: Array, north_east_down: bool) -> Array:
        """Return attitudes (n, 4) of a frame in the world as those of the body in east, north, up: w q t^-1."""
        turned = product(q, inverse(self.turn(frame)))
        return product(NORTH_EAST, turned) if north_east_down else turned

    def _note(self, frame: str) -> None:
        told = self.mounts.turn(frame, self.body) is not None and plain(frame) != plain(self.body)
        down = "axes forward, right, down turned to forward, left, up"
        line = f"{frame or 'no frame'}: " + (f"turned to {self.body} as the bag's transforms say" if told else down)
        if line not in self.notes:
            self.notes.append(line)


def cosine_up(q: Array, force: Array) -> float:
    """Return the median cosine between up and forces (n, 3) turned by attitudes (n, 4); 0 where none is known."""
    up = rotated(q, force)[:, 2] / np.maximum(np.linalg.norm(force, axis=1), 1e-9)
    known = up[np.isfinite(up)]
    return float(np.median(known)) if len(known) else 0.0
