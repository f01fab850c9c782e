"""Triangles of a model's geoms against the volumes and places of the geoms themselves."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import pytest

from reports.viewer.vehicle_mesh import Solid, radius_m, solids
from sim.vehicles import VEHICLES
from sim.vehicles.geoms import Geom, visible_geoms

MODEL = """
<mujoco>
  <asset>
    <material name="red" rgba="1 0 0 1"/>
    <mesh name="tetrahedron" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
  </asset>
  <worldbody>
    <geom name="ground" type="plane" size="1 1 1"/>
    <body name="main">
      <freejoint/>
      <geom name="box" type="box" size="1 2 3" pos="10 20 30" euler="0 0 90" material="red"/>
      <geom name="ball" type="sphere" size="2" pos="0 0 5"/>
      <geom name="egg" type="ellipsoid" size="1 2 3" rgba="0 0 1 0.5"/>
      <geom name="can" type="cylinder" size="0.5 2"/>
      <geom name="pill" type="capsule" size="0.5 2"/>
      <geom name="tetrahedron" type="mesh" mesh="tetrahedron"/>
      <geom name="glass" type="sphere" size="1" rgba="0 0 0 0"/>
      <body name="arm" pos="0 0 7">
        <geom name="hand" type="box" size="1 1 1" pos="1 0 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
VOLUMES_M3 = {
    "box": 48.0,
    "ball": 4 / 3 * np.pi * 8,
    "egg": 4 / 3 * np.pi * 6,
    "can": np.pi * 0.25 * 4,
    "pill": np.pi * 0.25 * 4 + 4 / 3 * np.pi * 0.125,
    "tetrahedron": 1 / 6,
    "hand": 8.0,
}
CENTRES_M = {"box": (10, 20, 30), "ball": (0, 0, 5), "tetrahedron": (0.25, 0.25, 0.25), "hand": (1, 0, 7)}


@dataclass(frozen=True)
class Drawn:
    """All that the drawing asks of a vehicle."""

    parts: tuple[Geom, ...]

    def geoms(self) -> tuple[Geom, ...]:
        return self.parts


def drawn(*bodies: str) -> dict[str, Solid]:
    parts = visible_geoms(mujoco.MjModel.from_xml_string(MODEL), bodies)
    return {part.name: part for part in solids(Drawn(parts))}


def signed_volumes_m3(solid: Solid) -> np.ndarray:
    """Of the tetrahedra between the faces and the origin; positive where a face looks away from it."""
    a, b, c = (solid.corners_m[k::3] for k in range(3))
    return np.sum(a * np.cross(b, c), axis=1) / 6


def test_all_that_can_be_seen_is_drawn() -> None:
    assert set(drawn("main")) == set(VOLUMES_M3)


@pytest.mark.parametrize("name", VOLUMES_M3)
def test_volume_and_centre_are_the_geoms(name: str) -> None:
    """By the divergence theorem, so faces look outward; 36 sides make round things 1.5 % smaller."""
    solid = drawn("main")[name]
    volumes = signed_volumes_m3(solid)
    assert volumes.sum() == pytest.approx(VOLUMES_M3[name], rel=0.02)
    middles = (solid.corners_m[::3] + solid.corners_m[1::3] + solid.corners_m[2::3]) / 4
    np.testing.assert_allclose(volumes @ middles / volumes.sum(), CENTRES_M.get(name, (0, 0, 0)), atol=1e-6)


def test_a_turned_box_is_turned() -> None:
    corners = drawn("main")["box"].corners_m - CENTRES_M["box"]
    np.testing.assert_allclose(corners.max(axis=0), (2, 1, 3), atol=1e-9)


def test_colours_are_the_geoms_or_the_materials() -> None:
    parts = drawn("main")
    assert (parts["box"].colour, parts["egg"].colour, parts["ball"].colour) == (
        *((255, 0, 0), (0, 0, 255), (128, 128, 128)),
    )


def test_a_body_that_turns_on_its_own_carries_its_solids() -> None:
    hand = drawn("main", "arm")["hand"]
    assert hand.body == "arm"
    np.testing.assert_allclose(hand.corners_m.mean(axis=0), (1, 0, 0), atol=1e-9)


@pytest.mark.parametrize("name", VEHICLES)
def test_a_vehicle_has_a_picture_of_its_own_size(name: str) -> None:
    vehicle = VEHICLES[name]
    parts = solids(vehicle(vehicle.table(kind=name)))
    assert len({part.name for part in parts}) == len(parts) > 1
    assert 0.1 < radius_m(parts) < 50.0
    for part in parts:
        np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1, atol=1e-9)
