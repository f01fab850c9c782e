"""Body frame of a log, forward-left-up or forward-right-down, from gravity and the attitude's world frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from scenarios.arrays import Array
from validation.axes.estimate import Axes
from validation.axes.policy import AXES
from validation.policy import POLICY
from validation.signals.quaternion_conventions import mean_direction
from validation.text import sentence

Tilt = Literal["up", "down", ""]
"""Direction of an axis; empty where it is not clear."""


@dataclass(frozen=True)
class BodyFrame:
    """Body frame of a log as its values tell: "flu", "frd", or "" where nothing tells; `why` in words.

    contradicted : whether parts of the log contradict each other, so that no frame fits. stated : "flu", "frd" or "".
    """

    name: Literal["flu", "frd", ""]
    why: str
    contradicted: bool = False
    stated: str = ""

    @property
    def wrong(self) -> bool:
        """Whether the columns as read are not in FLU, or contradict themselves."""
        return self.contradicted or self.name == "frd"

    @property
    def taken(self) -> str:
        """Return the frame in which the log was read."""
        if self.stated == "frd":
            return "FRD (forward, right, down) as stated, turned to FLU"
        return "FLU (forward, left, up) as stated" if self.stated else "FLU (forward, left, up)"

    @property
    def clause(self) -> str:
        """Return what is wrong about the frame as taken, and what to do."""
        if self.contradicted:
            return f"the frame is taken as {self.taken}, but {self.why}"
        if self.stated == "frd":
            return f"the frame is taken as {self.taken}, but then {self.why}: --frame flu"
        return f"the frame is taken as {self.taken}, but the log is in FRD, since {self.why}: --frame frd"

    @property
    def text(self) -> str:
        """Return a sentence: the frame as taken, why, and what to do where the log is in another frame."""
        if self.wrong:
            return sentence(self.clause)
        if self.name == "flu":
            return f"Frame: {self.taken}: {self.why}."
        if self.stated:
            return f"Frame: {self.taken}."
        return "Frame: taken as FLU (nothing in the log tells; --frame frd otherwise)."


def frame_of(accel: Array | None, q: Array | None, axes: Axes) -> BodyFrame:
    """Return the body frame that specific force (n, 3), attitude (n, 4) and field tell.

    At rest the specific force points up: along +z in FLU and along -z in FRD of an upright vehicle; turned by the
    attitude, along +z in ENU and along -z in NED.
    """
    return replace(_told(accel, q, axes), stated=axes.stated)


def _told(accel: Array | None, q: Array | None, axes: Axes) -> BodyFrame:
    if accel is None:
        return BodyFrame("", "")
    body = _sign(_mean(accel))
    world = "" if q is None else _sign(mean_direction(q, _calm(accel)))
    if world:
        return _by_attitude(world, body)
    if body == "up":
        return BodyFrame("flu", "the accelerometer reads upward along z in the mean")
    return _downward(axes) if body == "down" else BodyFrame("", "")


def _by_attitude(world: Tilt, body: Tilt) -> BodyFrame:
    """Return the frame by the direction of the specific force in the world of the attitude, and in the body."""
    if body and world != body:
        words = "in the body frame" if body == "down" else "in the attitude's world frame"
        why = f"the specific force points down {words} alone: its axes or the quaternion's differ"
        return BodyFrame("", why, True)
    if world == "up":
        return BodyFrame("flu", "the attitude turns the specific force to plus z, as in east, north, up")
    why = "the attitude turns the specific force to minus z, as in north, east, down"
    return BodyFrame("frd", why if body else f"{why} (or the accelerometer has the opposite sign)")


def _downward(axes: Axes) -> BodyFrame:
    """Return the frame of a log whose mean specific force is along -z: FRD, or an accelerometer of opposite sign."""
    why = "the accelerometer reads -9.8 m/s^2 along z in the mean"
    up = axes.up(0) if axes.agree else 0.0
    if up > 0 and axes.down is not False:
        why += ", but the field is along its reading: FRD south of the magnetic equator, or the opposite sign"
        return BodyFrame("", f"{why} of the accelerometer", True)
    return BodyFrame("frd", why)


def _calm(accel: Array) -> Array:
    """Return the specific force with NaN in rows with acceleration."""
    size = np.linalg.norm(accel, axis=1)
    typical = np.nanmedian(size) if np.isfinite(size).any() else np.nan
    return np.where((np.abs(size - typical) < POLICY.calm_share * typical)[:, None], accel, np.nan)


def _mean(accel: Array) -> Array:
    """Return the mean (3,) of the directions of the calm specific force; zero without calm rows."""
    calm = _calm(accel)
    unit = calm / np.linalg.norm(calm, axis=1, keepdims=True)
    unit = unit[np.isfinite(unit).all(axis=1)]
    return np.asarray(unit.mean(axis=0)) if len(unit) >= POLICY.least_directions else np.zeros(3)


def _sign(mean: Array) -> Tilt:
    """Return where the z component of a mean direction (3,) points."""
    return "up" if mean[2] > AXES.upright else "down" if mean[2] < -AXES.upright else ""
