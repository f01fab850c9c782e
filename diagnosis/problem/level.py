"""Vertical direction from roll and pitch alone: makes the field's dip observable without a heading."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from diagnosis.problem.track import FieldTrack
from scenarios.arrays import Array

LEAST_LEVEL = 1e-6
"""Horizontal part of a unit direction below which the direction counts as vertical."""


class Dip(NamedTuple):
    """Unit vectors down (n, 3), and the given dip (n,) of the field in rad."""

    down: Array
    given_rad: Array


@dataclass(frozen=True, eq=False)
class Level:
    """Unit vectors down (n, 3) in the body frame, and the given field (3,) east, north, up in nT."""

    down: Array
    field_enu_nT: Array

    @classmethod
    def of(cls, R_wb: Array, field_enu_nT: Array, policy: Policy) -> Level | None:
        """Down vectors from attitudes (n, 3, 3), independent of the heading; None for a nearly vertical field."""
        level_nT, size_nT = np.hypot(*field_enu_nT[:2]), np.linalg.norm(field_enu_nT)
        return cls(-R_wb[:, 2], field_enu_nT) if level_nT > policy.trace * size_nT else None

    def dip(self, track: FieldTrack | None) -> Dip:
        """The dip of the given field, including its change along a track."""
        field = self.field_enu_nT + (np.zeros((len(self.down), 3)) if track is None else track.change_enu_nT)
        return Dip(self.down, np.arctan2(-field[:, 2], np.hypot(field[:, 0], field[:, 1])))

    def at(self, samples: NDArray[np.bool_]) -> Level:
        """The level at selected samples."""
        return replace(self, down=self.down[samples])


def dip_rad(field: Array, down: Array) -> Array:
    """Angle (n,) of fields (n, 3) below the horizontal, with unit vectors down (n, 3)."""
    along = np.einsum("ni,ni->n", field, down)
    return np.asarray(np.arctan2(along, np.linalg.norm(field - along[:, None] * down, axis=1)))


def upright(direction: Array, down: Array) -> Array:
    """Unit vectors (n, 3) of increasing dip: across directions (n, 3), in the vertical plane, towards down."""
    across = down - np.einsum("ni,ni->n", direction, down)[:, None] * direction
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), LEAST_LEVEL))
