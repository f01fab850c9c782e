"""Axes of a magnetometer: the signed axis maps that agree with gyro, accelerometer and attitude."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calib import Reference
from scenarios.arrays import Array
from validation.axes.directions import DirectionEvidence, accel_evidence, attitude_evidence
from validation.axes.evidence import MapEvidence
from validation.axes.gyro import GyroEvidence, gyro_evidence
from validation.axes.maps import TURNS, is_turn, map_text
from validation.axes.policy import AXES

DOWNWARD = np.diag([1.0, -1.0, -1.0])
"""From forward, right, down to forward, left, up."""


@dataclass(frozen=True)
class Axes:
    """What gyro, accelerometer and attitude say of the magnetometer's axes; None for an instrument not recorded.

    down : whether the field is known to point down (True) or up (False); None where unknown. stated : body frame of the
    log as stated, "flu", "frd" or "".

    Every instrument allows a turn P and its reflection -P alike: the sign needs the vertical or north component.
    """

    gyro: GyroEvidence | None
    accel: DirectionEvidence | None
    attitude: DirectionEvidence | None
    down: bool | None = None
    stated: str = ""

    @cached_property
    def speaking(self) -> dict[str, MapEvidence]:
        """The evidence that counts, by instrument: of those that exclude maps.

        An accelerometer must leave a single turn. An attitude that contradicts gyro and accelerometer is in
        another body frame, and left out.
        """
        found: dict[str, MapEvidence] = {}
        if self.gyro is not None and not self.gyro.reversed:
            found["gyro"] = self.gyro.evidence
        if self.accel is not None and self.accel.evidence.possible.sum() == 1:
            found["accelerometer"] = self.accel.evidence
        found = {name: one for name, one in found.items() if not one.silent}
        if self.attitude is None or self.attitude.evidence.silent:
            return found
        attitude = self.attitude.evidence
        return found if found and not (_common(found) & attitude.possible).any() else found | {"attitude": attitude}

    @cached_property
    def turns(self) -> list[int]:
        """Indices of the turns that every instrument allows; empty where instruments contradict each other."""
        return [int(turn) for turn in np.flatnonzero(_common(self.speaking))]

    @property
    def agree(self) -> bool:
        """Whether the axes as logged are among those that every instrument allows, but for the sign of the field."""
        return 0 in self.turns

    @property
    def decided(self) -> bool:
        """Whether a single turn is left, with its reflection."""
        return len(self.turns) == 1

    @cached_property
    def maps(self) -> list[Array]:
        """The signed maps (3, 3) that are left: one for each turn where the sign is known, else turn and reflection."""
        found = []
        for turn in self.turns:
            sign = self.sign(turn)
            found += [TURNS[turn], -TURNS[turn]] if sign == 0 else [sign * TURNS[turn]]
        return found

    def option(self, axes: Array) -> str:
        """Return a map (3, 3) as the value of --axes, which acts before a stated frame is turned to FLU."""
        return map_text(DOWNWARD @ axes @ DOWNWARD if self.stated == "frd" else axes)

    @property
    def left_handed(self) -> bool:
        """Whether every map that is left is a reflection."""
        return bool(self.speaking) and bool(self.maps) and not any(is_turn(one) for one in self.maps)

    def sign(self, turn: int) -> int:
        """Return whether the map is the turn (1) or its reflection (-1); 0 where nothing tells.

        With a heading from north the field points north; otherwise down, as north of the magnetic equator, unless
        known better. Axes that agree as logged are taken as they are.
        """
        if turn == 0 and self.down is None:
            return 1
        if self.down is None and (north := self._along_north(turn)):
            return north
        up = self.up(turn)
        return int(np.sign(up)) if self.down is False else -int(np.sign(up))

    @property
    def assumed(self) -> bool:
        """Whether the sign rests on the assumption that the field points down."""
        return self.down is None and not any(self._along_north(turn) for turn in self.turns)

    @property
    def handedness_known(self) -> bool:
        """Whether more than the sign convention of a specific force tells the handedness."""
        return "gyro" in self.speaking or not self.assumed

    def up(self, turn: int) -> float:
        """Return the upward component of the field for a turn, by the accelerometer; 0 where the sign is not clear.

        Over the rms deviation of a component of the field from the mean.
        """
        if self.accel is None or not self.accel.evidence.possible[turn]:
            return 0.0
        up, std = float(self.accel.along[turn, 0]), float(self.accel.evidence.std[turn, -1])
        return up if abs(up) > max(AXES.clear_sign, AXES.clear_sign_sigma * std) else 0.0

    def _along_north(self, turn: int) -> int:
        """Return the sign of the north component for a turn; 0 unless the field is near the world's meridian."""
        if self.attitude is None or "attitude" not in self.speaking:
            return 0
        east, north, _ = self.attitude.along[turn] / np.linalg.norm(self.attitude.along[turn])
        clear = abs(north) > AXES.clear_sign and abs(north) > AXES.meridian * abs(east)
        return int(np.sign(north)) if clear else 0


def _common(found: dict[str, MapEvidence]) -> NDArray[np.bool_]:
    """Return which turns (24,) all instruments allow."""
    every = [np.ones(len(TURNS), np.bool_), *(one.possible for one in found.values())]
    return np.asarray(np.logical_and.reduce(every), np.bool_)


def axes_of(
    time_s: Array,
    mag_nT: Array,
    *,
    gyro: Array | None = None,
    accel: Array | None = None,
    q: Array | None = None,
    down: bool | None = None,
    stated: str = "",
) -> Axes:
    """Compare the axes of a magnetometer (n, 3) with gyro (n, 3), specific force (n, 3) and attitude (n, 4).

    Vectors may have NaN, and any unit. down, stated : see `Axes`.
    """
    return Axes(
        None if gyro is None else gyro_evidence(time_s, mag_nT, gyro),
        None if accel is None else accel_evidence(time_s, mag_nT, accel),
        None if q is None else attitude_evidence(time_s, mag_nT, q),
        down,
        stated,
    )


def field_down(reference: Reference | None) -> bool | None:
    """Return whether a reference's field points down; None for a strength alone, and near the magnetic equator."""
    if reference is None or reference.field_enu_nT is None:
        return None
    up = reference.field_enu_nT[2] / reference.strength_nT
    return up < 0 if abs(up) > AXES.equator else None
