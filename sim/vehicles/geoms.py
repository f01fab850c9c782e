"""Picture of a vehicle: the visible geoms of the MJCF, plain, for drawing elsewhere."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from scenarios.arrays import Array

PLAIN = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom without a colour; the material's colour is used instead."""
DRAWN = ("SPHERE", "CAPSULE", "ELLIPSOID", "CYLINDER", "BOX", "MESH")


@dataclass(frozen=True)
class Geom:
    """A solid, fixed to a body of the model.

    shape: MuJoCo's word, lower case, with sizes size_m (3,); place_m (3,) and turn (3, 3) in the body's frame;
    colour: red, green, blue, each to 255; triangles_m (n, 3, 3) of a mesh, in the geom's own frame.
    """

    name: str
    body: str
    shape: str
    size_m: Array
    place_m: Array
    turn: Array
    colour: tuple[int, int, int]
    triangles_m: Array | None = None


def visible_geoms(model: mujoco.MjModel, bodies: Collection[str]) -> tuple[Geom, ...]:
    """The geoms that are not transparent, each in the frame of the innermost carrying body in `bodies`."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    kinds = {int(getattr(mujoco.mjtGeom, f"mjGEOM_{word}")): word.lower() for word in DRAWN}
    return tuple(
        _geom(model, data, index, kinds[model.geom_type[index]], bodies)
        for index in range(model.ngeom)
        if model.geom_type[index] in kinds and _rgba(model, index)[3] > 0
    )


def _geom(model: Any, data: Any, index: int, shape: str, bodies: Collection[str]) -> Geom:
    body = _carrier(model, model.geom_bodyid[index], bodies)
    turn = data.xmat[body].reshape(3, 3)
    red, green, blue = (round(255 * float(part)) for part in _rgba(model, index)[:3])
    return Geom(
        name=model.geom(index).name or f"{shape}_{index}",
        body=model.body(body).name,
        shape=shape,
        size_m=model.geom_size[index].copy(),
        place_m=turn.T @ (data.geom_xpos[index] - data.xpos[body]),
        turn=turn.T @ data.geom_xmat[index].reshape(3, 3),
        colour=(red, green, blue),
        triangles_m=_triangles_m(model, model.geom_dataid[index]) if shape == "mesh" else None,
    )


def _carrier(model: Any, body: int, bodies: Collection[str]) -> int:
    while body and model.body(body).name not in bodies:
        body = model.body_parentid[body]
    return body


def _rgba(model: Any, index: int) -> tuple[float, ...]:
    own, material = tuple(map(float, model.geom_rgba[index])), model.geom_matid[index]
    return own if material < 0 or own != PLAIN else tuple(map(float, model.mat_rgba[material]))


def _triangles_m(model: Any, mesh: int) -> Array:
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    corners = model.mesh_vert[first : first + count].astype(np.float64)
    return np.asarray(corners[model.mesh_face[face : face + faces]])
