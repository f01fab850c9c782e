"""Which directions of a sphere were seen: cells of equal area, and the largest hole between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array

BAND_DEG = 15.0
"""Height of a band of latitude, and about the width of a cell."""

THINNED = 5_000
"""Vectors by which most cells are known to be no hole."""
BLOCK = 65_536
"""Vectors at a time."""
ROUNDING = 1e-12
"""Of a cosine, summed in another order."""


@dataclass(frozen=True)
class Cells:
    """Cells of equal area on a sphere, in bands of latitude from pole to pole.

    counts : (bands,) cells in each band. edges_z : (bands + 1,) z of the bands' edges, from -1 to 1.
    """

    counts: NDArray[np.intp]
    edges_z: Array

    @property
    def total(self) -> int:
        """Return the number of cells."""
        return int(self.counts.sum())

    def index(self, direction: Array) -> NDArray[np.intp]:
        """Return the cell of each unit vector (n, 3)."""
        band = np.clip(np.searchsorted(self.edges_z, direction[:, 2], side="right") - 1, 0, len(self.counts) - 1)
        turn = np.arctan2(direction[:, 1], direction[:, 0]) / (2 * np.pi) % 1.0
        within = np.minimum((turn * self.counts[band]).astype(np.intp), self.counts[band] - 1)
        return np.asarray(np.cumsum(self.counts)[band] - self.counts[band] + within, np.intp)

    def edges(self) -> Array:
        """Return the edges (total, 4) of all cells: longitudes in rad, from and to, and z, from and to."""
        rows = []
        for band, count in enumerate(self.counts):
            longitude = 2 * np.pi * np.arange(count + 1) / count
            z = np.tile(self.edges_z[band : band + 2], (count, 1))
            rows.append(np.column_stack([longitude[:-1], longitude[1:], z]))
        return np.concatenate(rows)

    def centres(self) -> Array:
        """Return unit vectors (total, 3) to the middles of all cells."""
        low, high, bottom, top = self.edges().T
        z, longitude = (bottom + top) / 2, (low + high) / 2
        radius = np.sqrt(1 - z**2)
        return np.column_stack([radius * np.cos(longitude), radius * np.sin(longitude), z])


def cells() -> Cells:
    """Return the cells in which coverage is counted: about square and of equal area."""
    bands = round(180 / BAND_DEG)
    latitude = np.radians(-90 + BAND_DEG * (np.arange(bands) + 0.5))
    counts = np.maximum(1, np.rint(360 / BAND_DEG * np.cos(latitude))).astype(np.intp)
    return Cells(counts, np.r_[0.0, np.cumsum(counts)] / counts.sum() * 2 - 1)


def directions(vectors: Array) -> Array:
    """Return unit vectors (m, 3) of the vectors (n, 3) that are finite and not zero."""
    length = np.linalg.norm(vectors, axis=1)
    sound = np.isfinite(length) & (length > 0)
    return np.asarray(vectors[sound] / length[sound, None])


def largest_hole(direction: Array) -> tuple[float, Array]:
    """Return radius in degrees and centre (3,) of the largest hole between unit vectors (n, 3).

    Centres are middles of cells; the radius is the angle to the nearest unit vector.
    """
    middle = cells().centres()
    nearest = _nearest(middle, direction[:: max(1, len(direction) // THINNED)])
    known = _nearest(middle[[int(np.argmin(nearest))]], direction)[0]
    left = np.flatnonzero(nearest <= known + ROUNDING)  # more vectors only come nearer: the rest is no larger hole
    found = _nearest(middle[left], direction)
    emptiest = int(np.argmin(found))
    return float(np.degrees(np.arccos(np.clip(found[emptiest], -1, 1)))), middle[left[emptiest]]


def _nearest(middle: Array, direction: Array) -> Array:
    """Return the cosine (c,) of the angle from each centre (c, 3) to the nearest of the unit vectors (n, 3)."""
    nearest = np.full(len(middle), -1.0)
    for start in range(0, len(direction), BLOCK):
        nearest = np.maximum(nearest, (middle @ direction[start : start + BLOCK].T).max(axis=1))
    return nearest
