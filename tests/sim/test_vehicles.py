"""What every vehicle promises: one entry in VEHICLES inherits these tests."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from pydantic import TypeAdapter

from scenarios.paths import PHASES, Phase
from sim.engine import CONTROL, Log, mass_matrix
from sim.vehicles import VEHICLES, VehicleSpec, vehicle_for
from sim.vehicles.base import STEP_S, Vehicle

TABLES = {
    "hover": {"kind": "hover"},
    "descent": {"kind": "descent", "to_depth_m": 10},
    "ascent": {"kind": "ascent"},
    "spiral": {"kind": "spiral", "radius_m": 20, "turn_rate_deg_s": 5, "turns": 1},
    "comb": {"kind": "comb", "line_length_m": 100, "line_spacing_m": 20, "lines": 2, "speed_m_s": 1},
    "rotate": {"kind": "rotate"},
    "turntable_stops": {"kind": "turntable_stops"},
    "turntable_turns": {"kind": "turntable_turns"},
    "tumble": {"kind": "tumble"},
}


@pytest.fixture(params=VEHICLES)
def vehicle(request: pytest.FixtureRequest) -> Vehicle:
    return vehicle_for(TypeAdapter(VehicleSpec).validate_python({"kind": request.param}))


@pytest.fixture
def model(vehicle: Vehicle) -> mujoco.MjModel:
    return vehicle.model()


def test_every_phase_kind_is_tried() -> None:
    assert set(TABLES) == set(PHASES)


def test_names_itself(vehicle: Vehicle) -> None:
    assert VEHICLES[vehicle.name] is type(vehicle)
    assert len(vehicle.summary) > 20


def test_model_steps_by_runge_kutta_and_names_the_body(vehicle: Vehicle, model: mujoco.MjModel) -> None:
    assert model.opt.timestep == STEP_S
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    assert model.body(vehicle.body).id > 0
    assert model.narena <= 2**20
    assert vehicle.motors <= model.nu


def test_starts_from_a_finite_state(vehicle: Vehicle, model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    mujoco.mj_forward(model, data)
    assert np.isfinite(np.concatenate([data.qpos, data.qvel, data.qacc])).all()


def test_controller_accepts_the_gains_of_every_phase_it_flies(vehicle: Vehicle, model: mujoco.MjModel) -> None:
    data, tried = mujoco.MjData(model), 0
    vehicle.place(model, data)
    for table in TABLES.values():
        phase = TypeAdapter(Phase).validate_python(table)
        if vehicle.name in phase.vehicles:
            gains, ctrl, tried = vehicle.gains(model, phase), np.full(model.nu, np.nan), tried + 1
            assert (gains.ndim, gains.dtype) == (1, np.float64)
            vehicle.control(data.qpos, data.qvel, np.zeros(18), gains, np.zeros(vehicle.memory_size), ctrl)
            assert np.isfinite(ctrl).all()
    assert tried
    assert CONTROL.signature.args == vehicle.control.nopython_signatures[0].args  # type: ignore[attr-defined]


def test_added_mass_is_symmetric_and_positive_or_absent(vehicle: Vehicle, model: mujoco.MjModel) -> None:
    added = vehicle.added_mass(model)
    if added.size:
        assert added.shape == (6, 6)
        np.testing.assert_allclose(added, added.T, atol=1e-12)
        assert np.linalg.eigvalsh(mass_matrix(model) + added).min() > 0


def test_flow_currents_and_kinematics_have_a_row_a_sample(vehicle: Vehicle, model: mujoco.MjModel) -> None:
    n, rng = 7, np.random.default_rng(0)
    assert vehicle.flow(n, rng, {}).shape == (n, 3)
    currents = vehicle.currents_A(rng.normal(size=(n, model.nu)))
    assert currents.shape == (n, vehicle.motors)
    assert np.isfinite(currents).all()
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    state = (data.qpos, data.qvel, data.ctrl, np.zeros(model.nv))
    motion = vehicle.kinematics(model, Log(*(np.tile(part, (n, 1)) for part in state)))
    assert motion.q.shape == (n, 4)
    np.testing.assert_allclose(np.linalg.norm(motion.q, axis=1), 1.0)
    for part in (motion.pos_enu_m, motion.velocity_m_s, motion.rate_rad_s, motion.accel_m_s2):
        assert part.shape == (n, 3)
