"""What every vehicle promises: one line in VEHICLES inherits these tests."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from scenarios.paths import PHASES, Ability, Phase
from sim.engine import CONTROL, StateLog
from sim.motion import drive
from sim.plant import mass_matrix
from sim.scenario import Scenario, json_schema
from sim.tracking import LIMIT_M, Tracker
from sim.vehicles import VEHICLES, VehicleSpec, vehicle_for, vehicles_for
from sim.vehicles.base import STEP_S, Vehicle

SHORT: dict[str, dict[str, Any]] = {
    "hover": {"duration_s": 30, "run_in_s": 5},
    "descent": {"to_depth_m": 5},
    "ascent": {"to_depth_m": 3},
    "spiral": {"radius_m": 20, "turn_rate_deg_s": 2, "duration_s": 60},
    "comb": {"line_length_m": 40, "line_spacing_m": 20, "lines": 2, "speed_m_s": 1},
    "rotate": {"duration_s": 40},
    "poses": {"poses": [{"yaw_deg": 20, "pitch_deg": 15, "roll_deg": -10}, {"yaw_deg": -40, "pitch_deg": -15}]},
    "pushes": {"pushes": [{"yaw_deg": 20, "pitch_deg": 15, "roll_deg": -10}, {"yaw_deg": -40, "pitch_deg": 20}]},
    "turntable_stops": {"dwell_s": 2, "stops": 3},
    "turntable_turns": {"rate_deg_s": 40},
    "tumble": {"duration_s": 40},
}
"""Every kind of phase, short."""


@pytest.fixture(params=VEHICLES)
def vehicle(request: pytest.FixtureRequest) -> Vehicle:
    return vehicle_for(TypeAdapter(VehicleSpec).validate_python({"kind": request.param}))


@pytest.fixture
def model(vehicle: Vehicle) -> mujoco.MjModel:
    return vehicle.model()


def test_every_phase_kind_is_tried() -> None:
    assert set(SHORT) == set(PHASES)


def scenario(vehicle: str, kind: str, **changes: Any) -> Scenario:
    """A short phase of this kind; something must sink before it can rise."""
    about = {"name": "trial", "summary": "trial", "field": {"enu_nT": [0.0, 2e4, -4e4]}}
    kinds = ("descent", kind) if kind == "ascent" else (kind,)
    phases = [{"kind": kind} | SHORT[kind] | changes for kind in kinds]
    return Scenario.model_validate({**about, "vehicle": {"kind": vehicle}, "phases": phases})


def test_names_itself(vehicle: Vehicle) -> None:
    assert VEHICLES[vehicle.name] is type(vehicle)
    assert len(vehicle.summary) > 20
    assert vehicle.noun.split()[0] in ("a", "an", "the")


def test_the_schema_shows_it(vehicle: Vehicle) -> None:
    shown = json_schema()["$defs"][vehicle.table.__name__]
    assert shown["properties"]["kind"]["const"] == vehicle.name
    assert shown["description"]


def test_a_vehicle_that_leaves_something_unsaid_is_refused_when_it_is_made() -> None:
    with pytest.raises(TypeError, match=r"vehicle Raft does not define its table, .*noun, abilities"):
        type("Raft", (Vehicle,), {"name": "raft", "summary": "drifts"})


@pytest.mark.parametrize("kind", SHORT)
def test_drives_what_it_is_able_to_and_refuses_the_rest(vehicle: Vehicle, kind: str) -> None:
    if vehicle.name not in vehicles_for(PHASES[kind]):
        with pytest.raises(ValidationError, match=f"the {vehicle.name} cannot do a"):
            scenario(vehicle.name, kind)
        return
    wanted = scenario(vehicle.name, kind)
    tracker = Tracker(wanted.phases)
    for motion in drive(wanted, np.random.default_rng(0)):
        tracker.see(motion)
        assert motion.current_A.shape == (len(motion.time_s), vehicle.motors)
        assert np.isfinite(motion.current_A).all()
        np.testing.assert_allclose(np.linalg.norm(motion.kinematics.q, axis=1), 1.0)
    assert tracker.tracking is None or tracker.tracking.max_m < LIMIT_M
    assert (tracker.tracking is None) != wanted.phases[0].tracked


def test_commanded_tilt_is_refused_where_it_cannot_be_done(vehicle: Vehicle) -> None:
    if Ability.TRAVEL in vehicle.abilities and Ability.TILT not in vehicle.abilities:
        with pytest.raises(ValidationError, match="cannot roll or pitch without moving away"):
            scenario(vehicle.name, "spiral", roll_amplitude_deg=10)


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
    for kind, table in SHORT.items():
        phase = TypeAdapter(Phase).validate_python({"kind": kind} | table)
        if vehicle.can(phase):
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
    motion = vehicle.kinematics(model, StateLog(*(np.tile(part, (n, 1)) for part in state)))
    assert motion.q.shape == (n, 4)
    np.testing.assert_allclose(np.linalg.norm(motion.q, axis=1), 1.0)
    for part in (motion.pos_enu_m, motion.velocity_m_s, motion.rate_rad_s, motion.accel_m_s2):
        assert part.shape == (n, 3)
