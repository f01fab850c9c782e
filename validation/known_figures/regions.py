"""A hundred equal regions of the sphere, and the middle of each, as MotionCal divides it [MotionCal: quality.c]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array

REGIONS = 100
CAP_RAD, TEMPERATE_RAD = 1.37046, 0.74776
"""Latitudes of the polar regions' edge, and of the edge between 15 and 34 regions a zone."""
FEW, MANY = 15, 34
MIDDLE_TEMPERATE_RAD, MIDDLE_TROPIC_RAD = 1.05911, 0.37388


def region_of(points: Array) -> NDArray[np.intp]:
    """Return the region of each direction (n, 3): 0 the north cap, 1 .. 15, 16 .. 49, 50 .. 83, 84 .. 98, 99."""
    longitude = np.arctan2(points[:, 1], points[:, 0]) + np.pi
    latitude = np.pi / 2 - np.arctan2(np.hypot(points[:, 0], points[:, 1]), points[:, 2])
    few = np.minimum(np.floor(longitude * FEW / (2 * np.pi)), FEW - 1)
    many = np.minimum(np.floor(longitude * MANY / (2 * np.pi)), MANY - 1)
    caps = [latitude > CAP_RAD, latitude < -CAP_RAD]
    zones = [*caps, latitude > TEMPERATE_RAD, latitude < -TEMPERATE_RAD, latitude >= 0]
    return np.asarray(np.select(zones, [0, 99, few + 1, few + 84, many + 16], many + 50), dtype=np.intp)


def region_counts(points: Array) -> NDArray[np.intp]:
    """Return the number of points in each region (100,)."""
    return np.bincount(region_of(points), minlength=REGIONS)


def middles() -> Array:
    """Return the points (100, 3) that MotionCal holds for the middles of its regions.

    Its southern temperate zone counts the longitude from region 1 in place of 84: the middles there are eight regions
    off, kept here since its figure has them so.
    """
    number = np.arange(REGIONS)
    count = np.where((number >= 16) & (number <= 83), MANY, FEW)
    first = np.select([number >= 84, number >= 50, number >= 16], [1, 50, 16], 1)
    longitude = (number - first + 0.5) * 2 * np.pi / count
    size_rad = np.where(count == MANY, MIDDLE_TROPIC_RAD, MIDDLE_TEMPERATE_RAD)
    found = np.column_stack([-np.cos(longitude) * np.cos(size_rad), -np.sin(longitude) * np.cos(size_rad)])
    height = np.where(number >= 50, -1.0, 1.0) * np.sin(size_rad)
    points = np.column_stack([found, height])
    points[0], points[-1] = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
    return points
