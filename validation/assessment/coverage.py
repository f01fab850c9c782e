"""Coverage of the sphere by the directions of the corrected field, and the faces that are missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array
from validation.assessment.policy import ASSESSMENT
from validation.signals.sphere import cells, directions

FACES = ("front", "back", "left", "right", "top", "bottom")
"""Sides of the body that the field enters by: along +x, -x, +y, -y, +z, -z."""

BLOCK = 8192
"""Directions in memory at a time; they fit the processor's cache."""


@dataclass(frozen=True)
class Coverage:
    """Share of the sphere's cells that the field's direction in the body has met, and faces that it has hardly met."""

    share: float
    missing: tuple[str, ...]

    @classmethod
    def of(cls, field_nT: Array) -> Coverage:
        """Return the coverage by a field (n, 3) in the body frame."""
        grid = cells()
        seen = np.zeros(grid.total, np.bool_)
        for first in range(0, len(field_nT), BLOCK):
            seen[grid.index(directions(field_nT[first : first + BLOCK]))] = True
        middles = grid.centres()
        axis = np.argmax(np.abs(middles), axis=1)
        face = 2 * axis + (middles[np.arange(len(middles)), axis] < 0)
        shares = [float(seen[face == one].mean()) for one in range(len(FACES))]
        missing = [name for name, share in zip(FACES, shares, strict=True) if share < ASSESSMENT.least_face]
        return cls(float(seen.mean()), tuple(missing))
