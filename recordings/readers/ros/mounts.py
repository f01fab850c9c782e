"""How the frames of a bag's sensors are mounted: constant transforms of /tf_static and /tf, and the vehicle's body."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from recordings.readers.quaternions import product
from scenarios.arrays import Array

TRANSFORMS = frozenset(("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"))
"""Types of messages with transforms."""
BODIES = ("base_link", "base_footprint", "base", "body", "fcu")
"""Last parts of the names of a vehicle's own frame, forward, left, up [REP 103, REP 105]."""
MOST_FRAMES, MOST_LETTERS, DEEPEST = 1000, 80, 32
SAME = 1e-6
"""Half the squared distance of two quaternions below which a transform has not changed: 0.1 degree."""
IDENTITY = (1.0, 0.0, 0.0, 0.0)
_DOWN = re.compile(r"(^|[_/])(frd|ned)($|[_/\d])")


@dataclass(frozen=True)
class FrameMount:
    """A transform: the parent of a frame, and the rotation from the frame to the parent, w x y z."""

    parent: str
    q: tuple[float, ...]


@dataclass(eq=False)
class Mounts:
    """The mounts of frames that never change in a bag, by frame; a frame that moves is none.

    kind : the type of the messages that `add` takes.
    """

    of: dict[str, FrameMount] = field(default_factory=dict)
    moving: set[str] = field(default_factory=set)

    def add(self, received_ns: int, message: Any) -> None:
        """Take the transforms of a message; ValueError for a rotation without length."""
        for one in message.transforms[:MOST_FRAMES]:
            turn = one.transform.rotation
            child, parent = (plain(name)[:MOST_LETTERS] for name in (one.child_frame_id, one.header.frame_id))
            self._take(child, parent, np.array([turn.w, turn.x, turn.y, turn.z], np.float64))

    def _take(self, child: str, parent: str, q: Array) -> None:
        length = float(np.linalg.norm(q))
        if not (length > 0 and np.isfinite(length)):
            raise ValueError("a rotation without length")
        known, q = self.of.get(child), q / length
        if known is not None and (known.parent != parent or 1 - abs(float(np.dot(known.q, q))) > SAME):
            self.moving.add(child)
        elif len(self.of) < MOST_FRAMES:
            self.of.setdefault(child, FrameMount(parent, tuple(q.tolist())))

    def join(self, others: Mounts) -> None:
        """Take the mounts of another part of the recording."""
        self.moving |= others.moving
        for child, mount in others.of.items():
            self._take(child, mount.parent, np.array(mount.q))

    def path(self, frame: str) -> Iterator[tuple[str, Array]]:
        """Yield a frame and all frames that carry it, with the rotation (4,) to each."""
        frame, q = plain(frame), np.array(IDENTITY)
        yield frame, q
        for _ in range(DEEPEST):
            mount = None if frame in self.moving else self.of.get(frame)
            if mount is None:
                return
            frame, q = mount.parent, product(np.array(mount.q), q)
            yield frame, q

    def body_of(self, frame: str, others: Sequence[str] = ()) -> str:
        """Return the vehicle's body that carries a sensor's frame, else the first frame that carries others too."""
        carriers = [name for name, _ in self.path(frame)]
        body = next((name for name in carriers if name.rsplit("/", 1)[-1] in BODIES), "")
        shared = [{name for name, _ in self.path(one)} for one in others]
        return body or next((name for name in carriers if all(name in one for one in shared)), carriers[0])

    def turn(self, frame: str, body: str) -> Array | None:
        """Return the rotation (4,) from a frame to the body; None where nothing tells."""
        return next((q for name, q in self.path(frame) if name == body), None)


def plain(frame: str) -> str:
    """Return a frame's name without the slash that ROS 1 may put first."""
    return frame.lstrip("/")


def says_down(frame: str) -> bool:
    """Return whether a frame's name says that its axes are forward, right, down, as `base_link_frd`."""
    return bool(_DOWN.search(frame.lower()))
