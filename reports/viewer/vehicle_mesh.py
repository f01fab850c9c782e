"""Triangle meshes of a vehicle from the geoms of its MJCF model: metres, body frame (FLU)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from sim.vehicles.geoms import Geom

SIDES = 36
"""Of what is round."""


@dataclass(frozen=True)
class Solid:
    """Coloured triangle mesh fixed to a body: corners (3 m, 3), three per face, and face normals (3 m, 3)."""

    name: str
    body: str
    corners_m: Array
    normals: Array
    colour: tuple[int, int, int]


class Pictured(Protocol):
    """Object with visible geoms: a vehicle."""

    def geoms(self) -> tuple[Geom, ...]:
        """Return the visible geoms."""


def solids(vehicle: Pictured) -> tuple[Solid, ...]:
    """Return the meshes of a vehicle's parts."""
    return tuple(_solid(geom) for geom in vehicle.geoms())


def radius_m(parts: tuple[Solid, ...]) -> float:
    """Return the largest distance of a corner from the vehicle's origin, the scale of arrows and camera distance."""
    return max(float(np.linalg.norm(part.corners_m, axis=1).max()) for part in parts)


def _solid(geom: Geom) -> Solid:
    faces = _triangles_m(geom) @ geom.turn.T + geom.place_m
    normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    size = np.linalg.norm(normal, axis=1)
    real = size > 1e-12
    unit = normal[real] / size[real, None]
    return Solid(geom.name, geom.body, faces[real].reshape(-1, 3), np.repeat(unit, 3, axis=0), geom.colour)


def _triangles_m(geom: Geom) -> Array:
    """Return triangles (m, 3, 3) in the geom's own frame; MuJoCo's sizes: radii, half sides, (radius, half length)."""
    size_m = geom.size_m
    if geom.triangles_m is not None:
        return geom.triangles_m
    if geom.shape == "box":
        return _box(size_m)
    if geom.shape == "cylinder":
        return _revolved([(-size_m[1], 0.0), (-size_m[1], size_m[0]), (size_m[1], size_m[0]), (size_m[1], 0.0)])
    if geom.shape == "capsule":
        return _revolved(_round_ends(size_m[0], size_m[1]))
    radii = size_m if geom.shape == "ellipsoid" else np.repeat(size_m[0], 3)
    return _revolved(_round_ends(1.0, 0.0)) * radii


def _round_ends(radius_m: float, half_length_m: float) -> list[tuple[float, float]]:
    """Return the profile (z, radius) of a capsule, or of a sphere for zero length."""
    quarter = np.linspace(0.0, np.pi / 2, SIDES // 4 + 1)
    angles = np.concatenate([-quarter[::-1], quarter])
    ends = np.repeat([-half_length_m, half_length_m], quarter.size)
    return list(zip(ends + radius_m * np.sin(angles), radius_m * np.cos(angles), strict=True))


def _revolved(profile: list[tuple[float, float]]) -> Array:
    """Return triangles of a profile of (z, radius), z rising, revolved about the z axis."""
    z, r = np.array(profile).T[:, :, None]
    angle = np.linspace(0, 2 * np.pi, SIDES + 1)
    grid = np.stack([r * np.cos(angle), r * np.sin(angle), z + 0 * angle], axis=2)
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.concatenate([np.stack([a, c, b], axis=2), np.stack([a, d, c], axis=2)]).reshape(-1, 3, 3)


def _box(half_m: Array) -> Array:
    """Return the triangles (12, 3, 3) of a box."""
    corner = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half_m
    faces: NDArray[np.int64] = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    return np.concatenate([corner[faces[:, [0, 1, 2]]], corner[faces[:, [0, 2, 3]]]])
