"""Simple solid shapes of the vehicles, for drawing: metres, body frame (FLU)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from validation.scoring.outcome import Array

YELLOW, DARK, RED, GREY = (233, 180, 40), (98, 106, 114), (213, 94, 0), (150, 158, 166)


@dataclass(frozen=True)
class Solid:
    """A coloured triangle mesh: corners (3 m, 3), three a face, and their face normals (3 m, 3)."""

    name: str
    corners_m: Array
    normals: Array
    colour: tuple[int, int, int]
    carrier: str = "vehicle"


def solids(kind: str) -> tuple[Solid, ...]:
    """The parts of a vehicle of this kind; `carrier` names the moving frame a part is fixed to."""
    return {"auv": _auv, "quadrotor": _quadrotor, "turntable": _turntable}[kind]()


def reach_m(kind: str) -> float:
    """Half the size of the vehicle: the scale of arrows and of the eye's distance."""
    return {"auv": 1.0, "quadrotor": 0.35, "turntable": 0.6}[kind]


def gimbals(q: Array) -> dict[str, Array]:
    """Attitude (n, 4) of the turntable's outer (yaw) and middle (yaw, pitch) frame, from the table's own (n, 4)."""
    w, x, y, z = q.T
    yaw, pitch = (
        np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) / 2,
        np.arcsin(np.clip(2 * (w * y - z * x), -1, 1)) / 2,
    )
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    outer = np.stack([cy, 0 * cy, 0 * cy, sy], axis=1)
    return {"gimbal_yaw": outer, "gimbal_pitch": np.stack([cy * cp, -sy * sp, cy * sp, sy * cp], axis=1)}


def _auv() -> tuple[Solid, ...]:
    hull = ((-1.0, 0.0), (-0.98, 0.03), (-0.65, 0.15), (0.6, 0.16), (0.82, 0.14), (0.95, 0.08), (1.0, 0.0))
    fins = [_turned(_box((-0.78, 0.0, 0.22), (0.1, 0.012, 0.14)), 0, a) for a in np.arange(4) * np.pi / 2 + np.pi / 4]
    nose = ((0.8, 0.146), (0.95, 0.083), (1.003, 0.0))
    return (
        _solid("hull", _revolved(hull), YELLOW),
        _solid("nose", _revolved(nose), RED),
        _solid("fins", np.concatenate(fins), DARK),
    )


def _quadrotor() -> tuple[Solid, ...]:
    angles = np.pi / 4 + np.arange(4) * np.pi / 2
    arms = [_turned(_box((0.14, 0, 0), (0.14, 0.012, 0.01)), 2, a) for a in angles]
    disc = _turned(_revolved(((-0.004, 0.0), (-0.004, 0.11), (0.004, 0.11), (0.004, 0.0))), 1, np.pi / 2)
    rotors = [disc + 0.28 * np.array([np.cos(a), np.sin(a), 0]) + np.array([0, 0, 0.03]) for a in angles]
    return (
        _solid("body", _box((0, 0, 0), (0.08, 0.05, 0.03)), DARK),
        _solid("nose", _box((0.085, 0, 0), (0.012, 0.03, 0.02)), RED),
        _solid("arms", np.concatenate(arms), GREY),
        _solid("rotors_front", np.concatenate([rotors[0], rotors[3]]), RED),
        _solid("rotors_back", np.concatenate(rotors[1:3]), YELLOW),
    )


def _turntable() -> tuple[Solid, ...]:
    upright, level = _turned(_ring(0.48), 0, np.pi / 2), _turned(_ring(0.4), 0, 0.0)
    table = np.concatenate([_box((0, 0, -0.03), (0.3, 0.22, 0.015)), _turned(_rod(0.36), 2, 0.0)])
    return (
        _solid(
            "base",
            _turned(_revolved(((0.55, 0.0), (0.55, 0.3), (0.62, 0.34), (0.62, 0.0))), 1, np.pi / 2),
            DARK,
            "base",
        ),
        _solid("yaw_fork", upright, GREY, "gimbal_yaw"),
        _solid("pitch_frame", level, YELLOW, "gimbal_pitch"),
        _solid("table", table, RED),
    )


def _solid(name: str, triangles_m: Array, colour: tuple[int, int, int], carrier: str = "vehicle") -> Solid:
    faces = triangles_m.reshape(-1, 3, 3)
    normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    keep = np.linalg.norm(normal, axis=1) > 1e-12
    unit = normal[keep] / np.linalg.norm(normal[keep], axis=1, keepdims=True)
    return Solid(name, faces[keep].reshape(-1, 3), np.repeat(unit, 3, axis=0), colour, carrier)


def _quads(grid: Array) -> Array:
    """Triangles (m, 3, 3) of a grid of points (i, j, 3)."""
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.concatenate([np.stack([a, c, b], axis=2), np.stack([a, d, c], axis=2)]).reshape(-1, 3, 3)


def _revolved(profile: tuple[tuple[float, float], ...], sides: int = 36) -> Array:
    """A profile of (x, radius) turned about the x axis."""
    x, r = np.array(profile).T[:, :, None]
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    return _quads(np.stack([x + 0 * angle, r * np.cos(angle), r * np.sin(angle)], axis=2))


def _ring(radius_m: float, thickness_m: float = 0.022) -> Array:
    """A torus about the z axis."""
    around, across = np.linspace(0, 2 * np.pi, 61)[:, None], np.linspace(0, 2 * np.pi, 13)
    r = radius_m + thickness_m * np.cos(across)
    return _quads(np.stack([r * np.cos(around), r * np.sin(around), thickness_m * np.sin(across) + 0 * around], axis=2))


def _rod(half_length_m: float) -> Array:
    """A rod along the x axis."""
    return _box((0.0, 0.0, 0.0), (half_length_m, 0.015, 0.015))


def _box(centre_m: tuple[float, float, float], half_m: tuple[float, float, float]) -> Array:
    """Triangles (12, 3, 3) of a box."""
    corner = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half_m + np.array(centre_m)
    faces: NDArray[np.int64] = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    return np.concatenate([corner[faces[:, [0, 1, 2]]], corner[faces[:, [0, 2, 3]]]])


def _turned(triangles_m: Array, axis: int, angle_rad: float) -> Array:
    """Triangles turned about a coordinate axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = triangles_m.copy()
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    out[..., i] = c * triangles_m[..., i] - s * triangles_m[..., j]
    out[..., j] = s * triangles_m[..., i] + c * triangles_m[..., j]
    return out
