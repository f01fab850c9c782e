"""Which way is down, by roll and pitch alone: the field's dip is then known, whatever the heading."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from diagnosis.problem.track import FieldTrack
from scenarios.arrays import Array

LEAST_LEVEL = 1e-6
"""Level part of a measured direction below which it counts as vertical, and has no side to dip to."""


@dataclass(frozen=True, eq=False)
class Level:
    """Unit vectors down in the body frame (n, 3), and the given field (3,) east, north, up in nT."""

    down: Array
    field_enu_nT: Array

    @classmethod
    def of(cls, R_wb: Array, field_enu_nT: Array, policy: Policy) -> Level | None:
        """Down by attitudes (n, 3, 3), of which the heading does not matter; None where the field is too steep."""
        level_nT, size_nT = np.hypot(*field_enu_nT[:2]), np.linalg.norm(field_enu_nT)
        return cls(-R_wb[:, 2], field_enu_nT) if level_nT > policy.least_level * size_nT else None

    def given_rad(self, track: FieldTrack | None) -> Array:
        """The given field's dip (n,), along a track as it changes there."""
        field = self.field_enu_nT + (np.zeros((len(self.down), 3)) if track is None else track.change_enu_nT)
        return np.asarray(np.arctan2(-field[:, 2], np.hypot(field[:, 0], field[:, 1])))

    def at(self, samples: NDArray[np.bool_]) -> Level:
        """The same at some of the samples."""
        return replace(self, down=self.down[samples])


def dip_rad(field: Array, down: Array) -> Array:
    """Angle (n,) of fields (n, 3) below the level, down (n, 3) being a unit vector."""
    along = np.einsum("ni,ni->n", field, down)
    return np.asarray(np.arctan2(along, np.linalg.norm(field - along[:, None] * down, axis=1)))


def upright(direction: Array, down: Array) -> Array:
    """Unit vectors (n, 3) across unit directions (n, 3) in the upright plane, towards down: where the dip grows."""
    across = down - np.einsum("ni,ni->n", direction, down)[:, None] * direction
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), LEAST_LEVEL))
