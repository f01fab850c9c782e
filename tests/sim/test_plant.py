"""Free models: which ones are, and that the reduced step of a free model is the step of the whole engine."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from sim.engine import ReferenceTrack, StateLog, advance, log_of
from sim.plant import is_free, plant_of
from sim.scenario import load
from sim.vehicles import VEHICLES, vehicle_for
from sim.vehicles.fluid import added_mass
from tests.sim.test_engine import hold

SCENARIOS = {"auv": "auv-spiral", "quadrotor": "quad-spiral", "turntable": "turntable-three-turns"}
RUNGE_KUTTA = '<option timestep="0.02" integrator="RK4" density="1000"/>'
HULL = """<freejoint/><inertial pos="0 0 0" mass="20" diaginertia="0.4 0.7 0.8"/>
  <geom type="ellipsoid" size="0.25 0.2 0.1" mass="0" fluidshape="ellipsoid" fluidcoef="0.5 0.1 0.5 0.5 0" {bits}/>"""
NO_TOUCH = 'contype="0" conaffinity="0"'
SLIDER = '<body><joint name="a" type="slide" {} /><geom size="0.1" {}/></body>'


def model_of(world: str, more: str = "", option: str = RUNGE_KUTTA) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(f"<mujoco>{option}<worldbody>{world}</worldbody>{more}</mujoco>")


def slider(joint: str = "", bits: str = NO_TOUCH) -> str:
    return SLIDER.format(joint, bits)


class TestIsFree:
    def test_every_vehicle_is(self) -> None:
        assert SCENARIOS.keys() == VEHICLES.keys()
        for name in SCENARIOS.values():
            assert is_free(vehicle_for(load(name, ()).vehicle).model())

    def test_bodies_without_constraints_are(self) -> None:
        assert is_free(model_of(slider()))
        assert is_free(model_of(f"<body>{HULL.format(bits=NO_TOUCH)}</body>"))

    @pytest.mark.parametrize(
        ("world", "more", "option"),
        [
            (slider(bits="") + '<geom type="plane" size="1 1 1"/>', "", RUNGE_KUTTA),
            (slider('range="-1 1" limited="true"'), "", RUNGE_KUTTA),
            (slider('frictionloss="0.1"'), "", RUNGE_KUTTA),
            ('<body><joint type="ball"/><geom size="0.1" ' + NO_TOUCH + "/></body>", "", RUNGE_KUTTA),
            (slider(), '<equality><joint joint1="a"/></equality>', RUNGE_KUTTA),
            (slider(), '<tendon><fixed><joint joint="a" coef="1"/></fixed></tendon>', RUNGE_KUTTA),
            (slider(), '<actuator><general joint="a" dyntype="filter" dynprm="1"/></actuator>', RUNGE_KUTTA),
            (slider(), "", ""),
        ],
        ids=["contact", "limit", "friction", "ball", "equality", "tendon", "activation", "Euler"],
    )
    def test_with_what_the_reduced_step_leaves_out(self, world: str, more: str, option: str) -> None:
        assert not is_free(model_of(world, more, option))


def run(name: str, free: bool) -> StateLog:
    """Four seconds of a vehicle from a start that turns, under its own control, in a flow."""
    scenario = load(SCENARIOS[name], ())
    vehicle = vehicle_for(scenario.vehicle)
    model = vehicle.model()
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    data.qvel[:] = np.linspace(0.3, -0.4, model.nv)
    reference, flow = np.zeros((200, 18)), np.tile([0.2, -0.1, 0.05], (200, 1))
    reference[:, 2] = data.qpos[2]
    log, memory = log_of(model, 200), np.zeros(vehicle.memory_size)
    plant = plant_of(model, data, vehicle.body, vehicle.added_mass(model))._replace(free=free)
    track = ReferenceTrack(reference, flow, vehicle.gains(model, scenario.phases[0]), memory)
    assert advance(vehicle.control, plant, track, log) == 200
    return log


@pytest.mark.parametrize(("name", "apart"), [("auv", 0.0), ("turntable", 1e-13), ("quadrotor", 3e-6)])
def test_reduced_step_is_that_of_the_whole_engine(name: str, apart: float) -> None:
    """In water to the bit; else beside mj_step, whose own terms of the fourth order differ for a free joint."""
    for reduced, whole in zip(run(name, True), run(name, False), strict=True):
        np.testing.assert_allclose(reduced, whole, rtol=apart, atol=apart)


@pytest.mark.parametrize("floor", [True, False])
def test_a_body_in_water_rests_on_a_floor(floor: bool) -> None:
    """A hull of 20 kg sinks; a plane 0.5 m below holds its lower edge of 0.1 m, to a depth of contact of 10 mm."""
    plane = '<geom type="plane" size="5 5 1" pos="0 0 -0.5"/>' if floor else ""
    model: Any = model_of(f'{plane}<body name="hull">{HULL.format(bits="")}</body>')
    data = mujoco.MjData(model)
    log = log_of(model, 500)
    track = ReferenceTrack(np.zeros((500, 18)), np.zeros((500, 3)), np.zeros(1), np.zeros(1))
    advance(hold, plant_of(model, data, "hull", added_mass(model)), track, log)
    z_m = float(log.qpos[-1, 2])
    assert abs(z_m + 0.4) < 0.01 if floor else z_m < -5.0
