"""AUV: statics and terminal velocities, tracking with and without current, the whole dive."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from pydantic import TypeAdapter
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from scenarios.paths import Phase, PhaseBase
from scenarios.spec import FieldSpec, SamplingSpec
from sim.engine import ReferenceTrack, advance, log_of
from sim.motion import drive
from sim.plant import plant_of
from sim.rotation import matrix_from_q
from sim.scenario import Scenario
from sim.vehicles.auv import Auv, AuvSpec
from sim.vehicles.free_body_control import ACTUATORS, ALLOCATION, LIMIT, MATRIX, NU, RATE, ROW, WRENCH, follow
from tests.sim.fossen import DENSITY, GRAVITY, UP, Fossen

SPIRAL = {"kind": "spiral", "radius_m": 20, "turn_rate_deg_s": 1, "vertical_speed_m_s": -0.05, "turns": 1}
COMB = {"kind": "comb", "line_length_m": 100, "line_spacing_m": 20, "lines": 4, "speed_m_s": 1}
TILT = {"roll_amplitude_deg": 30, "pitch_amplitude_deg": 30}
DIVE = (
    {"kind": "descent", "to_depth_m": 50},
    {"kind": "spiral", "radius_m": 20, "turn_rate_deg_s": 2, "duration_s": 120},
    {"kind": "comb", "line_length_m": 40, "line_spacing_m": 20, "lines": 2, "speed_m_s": 1},
    {"kind": "ascent", "to_depth_m": 5},
)


def phase(table: dict[str, Any]) -> PhaseBase:
    return TypeAdapter(Phase).validate_python(table)


def auv(**table: Any) -> tuple[Auv, mujoco.MjModel, mujoco.MjData]:
    vehicle = Auv(AuvSpec(kind="auv", **table))
    model = vehicle.model()
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    return vehicle, model, data


def dive(*phases: dict[str, Any], rate_hz: float = 10, **table: Any) -> SimpleNamespace:
    """The motion of the phases, all blocks joined; apart_m and apart_deg are the tracking errors."""
    scenario = Scenario(
        **{"name": "dive", "summary": "test", "phases": phases, "vehicle": {"kind": "auv", **table}},
        field=FieldSpec(enu_nT=(0.0, 20_000.0, -40_000.0)),
        sampling=SamplingSpec(rate_hz=rate_hz),
    )
    blocks = list(drive(scenario, np.random.default_rng(0)))
    parts: dict[str, Any] = {k: [getattr(b, k) for b in blocks] for k in ("time_s", "R_wb", "current_A", "reference")}
    parts |= {k: [getattr(b.kinematics, k) for b in blocks] for k in ("pos_enu_m", "q", "velocity_m_s", "rate_rad_s")}
    parts["phase"] = [np.full(len(b.time_s), b.phase) for b in blocks]
    parts["phase_time_s"] = [b.phase_time_s for b in blocks]
    parts["settled"] = [b.phase_time_s > scenario.phases[b.phase].settle_s for b in blocks]
    run = SimpleNamespace(**{k: np.concatenate(v) for k, v in parts.items()})
    run.apart_m = np.linalg.norm(run.reference[:, :3] - run.pos_enu_m, axis=1)
    wanted = Rotation.from_euler("ZYX", run.reference[:, 9:12])
    run.apart_deg = np.degrees((wanted.inv() * Rotation.from_matrix(run.R_wb)).magnitude())
    return run


def follow_from_rest(reference: Array, attitude: Rotation | None = None) -> mujoco.MjData:
    """The state after a reference that no scenario offers, from rest at the origin."""
    vehicle, model, data = auv()
    data.qpos[3:7] = (attitude or Rotation.identity()).as_quat(scalar_first=True)
    n, gains = len(reference), vehicle.gains(model, phase(SPIRAL))
    plant = plant_of(model, data, vehicle.body, vehicle.added_mass(model))
    course = ReferenceTrack(reference, np.zeros((n, 3)), gains, np.zeros(vehicle.memory_size))
    advance(follow, plant, course, log_of(model, n))
    return data


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))


class TestStatics:
    def test_neutral_by_the_water_that_hull_and_planes_displace(self) -> None:
        _, model, data = auv(depth_m=10)
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.qfrc_passive - data.qfrc_bias, 0.0, atol=1e-8)
        wet = model.geom_fluid[:, 0] > 0
        displaced = DENSITY * 4 / 3 * np.pi * np.prod(model.geom_size[wet], axis=1).sum()
        assert model.body_mass.sum() == pytest.approx(displaced, rel=1e-3)

    @pytest.mark.parametrize("axis", [0, 1])
    @pytest.mark.parametrize("angle_deg", [-60, 5, 30, 90])
    def test_righting_moment(self, axis: int, angle_deg: float) -> None:
        """-B z_b sin(angle), B the buoyancy and z_b = 20 mm the height of its centre above the mass."""
        _, model, data = auv()
        data.qpos[3:7] = Rotation.from_rotvec(np.radians(angle_deg) * np.eye(3)[axis]).as_quat(scalar_first=True)
        mujoco.mj_forward(model, data)
        moment = (data.qfrc_passive - data.qfrc_bias)[3:]
        expected = -83.05 * GRAVITY * 0.02 * np.sin(np.radians(angle_deg))
        assert moment[axis] == pytest.approx(expected, rel=0.01)
        assert abs(moment[1 - axis]) < 1e-9

    def test_starts_where_the_scenario_says(self) -> None:
        run = dive({"kind": "hover", "duration_s": 5, "run_in_s": 2}, depth_m=12, heading_deg=60)
        np.testing.assert_allclose(run.pos_enu_m[0], [0, 0, -12])
        np.testing.assert_allclose(run.R_wb[0, :, 0], [0.5, np.sqrt(0.75), 0], atol=1e-12)
        assert run.apart_m.max() < 1e-9
        assert run.current_A.max() < 1e-6

    def test_eight_thrusters_reach_every_degree_of_freedom(self) -> None:
        vehicle, model, data = auv()
        gains = vehicle.gains(model, phase(SPIRAL))
        allocation = gains[ACTUATORS:].reshape(-1, ROW)[:8, ALLOCATION:LIMIT]
        for wrench in np.eye(6):
            data.ctrl[:8] = allocation @ wrench
            mujoco.mj_forward(model, data)
            np.testing.assert_allclose(data.qfrc_actuator, wrench, atol=1e-9)

    def test_thruster_current_follows_thrust(self) -> None:
        vehicle, _, _ = auv()
        ctrl = np.zeros((3, 10))
        ctrl[:, 2], ctrl[:, 9] = [10.0, -40.0, 0.0], 100.0
        currents = vehicle.currents_A(ctrl)
        assert currents.shape == (3, 8)
        assert currents[1, 2] == pytest.approx(8 * currents[0, 2])
        assert currents[0, 2] == pytest.approx(2.15, rel=0.01)
        assert np.count_nonzero(currents) == 2


class TestUnpowered:
    @pytest.mark.parametrize("kind", ["descent", "ascent"])
    def test_steady_glide_is_the_balance_of_forces(self, kind: str) -> None:
        """Ballast, drag, lift, Munk moment and righting moment in balance, solved for (u, w, pitch) on their own."""
        down = 1.0 if kind == "descent" else -1.0
        table = {"kind": kind, "to_depth_m": 60 if down > 0 else 5}
        run = dive(table, depth_m=0 if down > 0 else 60)
        _, model, _ = auv()
        fossen = Fossen(model, ballast_N=40.0 * down, trim_m=0.1)

        def balance(x: Array) -> Array:
            R = Rotation.from_euler("y", x[2]).as_matrix()
            return fossen.acceleration(np.array([x[0], 0, x[1], 0, 0, 0]), R)[[0, 2, 4]]

        u, w, pitch = fsolve(balance, [0.5, -0.4 * down, 0.1 * down], xtol=1e-12)
        steady = Rotation.from_euler("y", pitch).apply([u, 0, w])
        np.testing.assert_allclose(run.velocity_m_s[-1], steady, atol=0.005 * np.linalg.norm(steady))
        assert np.arcsin(-run.R_wb[-1, 2, 0]) == pytest.approx(pitch, rel=0.01)
        assert pitch * down > 0
        assert np.linalg.norm(run.current_A) == 0

    def test_current_carries_the_vehicle_along(self) -> None:
        """Once steady, the motion through the water is that of still water, whatever the heading it came to."""
        table, current = {"kind": "descent", "to_depth_m": 60}, np.array([0.05, 0.2, 0.0])
        still, carried = dive(table), dive(table, current_enu_m_s=tuple(current))
        through = carried.R_wb[-1].T @ (carried.velocity_m_s[-1] - current)
        np.testing.assert_allclose(through, still.R_wb[-1].T @ still.velocity_m_s[-1], atol=0.005)


class TestControl:
    def test_wrench_gives_the_wanted_acceleration(self) -> None:
        """Inverse dynamics against the independent equations, without drag: exact at any attitude and rate."""
        vehicle, model, _ = auv()
        model.geom_fluid[:, 1:6] = 0.0
        model.opt.viscosity = 0.0
        model.actuator_ctrlrange[:8] = [-1e6, 1e6]
        gains, fossen, rng = vehicle.gains(model, phase(SPIRAL)), Fossen(model), np.random.default_rng(3)
        for _ in range(20):
            turn = Rotation.random(random_state=rng)
            qpos = np.concatenate([rng.normal(size=3), turn.as_quat(scalar_first=True)])
            qvel, row, memory, ctrl = rng.normal(size=6), rng.normal(size=18), np.zeros(43), np.zeros(10)
            follow(qpos, qvel, row, gains, memory, ctrl)
            np.testing.assert_allclose(memory[MATRIX:NU].reshape(3, 3), turn.as_matrix(), atol=1e-12)
            fossen.tau = memory[WRENCH:]
            reached = fossen.acceleration(memory[NU:RATE], turn.as_matrix())
            np.testing.assert_allclose(reached, memory[RATE:WRENCH], atol=1e-6)

    def test_attitude_target_is_the_reference_and_its_derivatives(self) -> None:
        """Body rate and its derivative of a moving reference, against finite differences of the attitude."""
        vehicle, model, _ = auv()
        gains, rng, h = vehicle.gains(model, phase(SPIRAL)), np.random.default_rng(5), 1e-4
        angles, rates, bends = rng.normal(size=(3, 3))

        def attitude(t: float) -> Rotation:
            return Rotation.from_euler("ZYX", angles + rates * t + bends * t * t / 2)

        def rate(t: float) -> Array:
            return (attitude(t - h).inv() * attitude(t + h)).as_rotvec() / (2 * h)

        row, memory = np.concatenate([np.zeros(9), angles, rates, bends]), np.zeros(43)
        follow(np.array([0.0, 0, 0, 1, 0, 0, 0]), np.zeros(6), row, gains, memory, np.zeros(10))
        wanted = Rotation.from_quat(memory[6:10], scalar_first=True)
        assert (wanted.inv() * attitude(0)).magnitude() < 1e-12
        np.testing.assert_allclose(memory[10:13], rate(0), atol=1e-6)
        np.testing.assert_allclose(memory[13:16], (rate(h) - rate(-h)) / (2 * h), atol=1e-5)

    def test_thrust_stays_within_its_limits_and_keeps_its_direction(self) -> None:
        vehicle, model, _ = auv()
        gains, ctrl = vehicle.gains(model, phase(SPIRAL)), np.zeros(10)
        wide = gains.copy()
        wide[ACTUATORS:].reshape(-1, ROW)[:, LIMIT] = 1e9
        free = np.zeros(10)
        row = np.zeros(18)
        row[:3], row[9:12] = [50, -80, 30], [2.0, 0.5, -0.5]
        follow(np.array([0.0, 0, 0, 1, 0, 0, 0]), np.zeros(6), row, gains, np.zeros(43), ctrl)
        follow(np.array([0.0, 0, 0, 1, 0, 0, 0]), np.zeros(6), row, wide, np.zeros(43), free)
        assert np.abs(ctrl).max() == pytest.approx(50)
        np.testing.assert_allclose(ctrl / np.linalg.norm(ctrl), free / np.linalg.norm(free), atol=1e-12)

    def test_a_quaternion_and_its_negative_are_one_attitude(self) -> None:
        vehicle, model, _ = auv()
        gains, rng, thrusts = vehicle.gains(model, phase(SPIRAL)), np.random.default_rng(4), np.zeros((2, 10))
        qpos, qvel, row = rng.normal(size=7), rng.normal(size=6), 0.3 * rng.normal(size=18)
        qpos[3:] /= np.linalg.norm(qpos[3:])
        for ctrl in thrusts:
            follow(qpos, qvel, row, gains, np.zeros(43), ctrl)
            qpos[3:] *= -1
        np.testing.assert_allclose(thrusts[0], thrusts[1], atol=1e-9)

    def test_comes_back_from_upside_down_and_backwards(self) -> None:
        data = follow_from_rest(np.zeros((1500, 18)), Rotation.from_euler("ZYX", [3.0, 0.5, 3.0]))
        assert Rotation.from_quat(data.qpos[3:7], scalar_first=True).magnitude() < 0.01
        assert np.linalg.norm(data.qpos[:3]) < 0.01


class TestTracking:
    @pytest.mark.parametrize("tilt", [{}, TILT], ids=["level", "tilting"])
    @pytest.mark.parametrize("current", [0.0, 0.1])
    def test_spiral(self, tilt: dict[str, float], current: float) -> None:
        run = dive(SPIRAL | tilt, current_enu_m_s=(current, 0, 0), depth_m=20)
        assert rms(run.apart_m[run.settled]) < 0.05
        assert rms(run.apart_deg[run.settled]) < (1.5 if tilt else 0.1)
        assert np.ptp(run.pos_enu_m[:, 0]) == pytest.approx(40, abs=0.1)
        if tilt:
            assert np.degrees(np.arcsin(-run.R_wb[:, 2, 0])).max() > 27

    @pytest.mark.parametrize("current", [0.0, 0.1])
    def test_comb(self, current: float) -> None:
        run = dive(COMB, current_enu_m_s=(current, 0, 0))
        assert rms(run.apart_m[run.settled]) < 0.05
        assert rms(run.apart_deg[run.settled]) < 0.5

    def test_comb_with_moderate_tilt(self) -> None:
        run = dive(COMB | {"roll_amplitude_deg": 15, "pitch_amplitude_deg": 15}, current_enu_m_s=(0.1, 0, 0))
        assert rms(run.apart_m[run.settled]) < 0.15
        assert rms(run.apart_deg[run.settled]) < 2

    def test_holds_an_attitude_near_the_singularity_of_euler_angles(self) -> None:
        reference = np.zeros((2500, 18))
        reference[:, 10] = np.radians(89.9)
        data = follow_from_rest(reference)
        nose = matrix_from_q(data.qpos[None, 3:7])[0, :, 0]
        assert np.degrees(np.arccos(-nose @ UP)) < 0.5


class TestWholeDive:
    @pytest.mark.parametrize("current", [(0.0, 0.0, 0.0), (0.1, 0.05, 0.0)])
    def test_descent_spiral_comb_ascent(self, current: tuple[float, float, float]) -> None:
        run = dive(*DIVE, current_enu_m_s=current)
        assert np.isfinite(np.column_stack([run.pos_enu_m, run.q, run.velocity_m_s, run.rate_rad_s])).all()
        np.testing.assert_allclose(np.diff(run.time_s), 0.1, atol=1e-9)
        assert list(np.unique(run.phase)) == [0, 1, 2, 3]
        assert run.pos_enu_m[run.phase == 0, 2].min() == pytest.approx(-50, abs=0.2)
        assert run.pos_enu_m[-1, 2] == pytest.approx(-5, abs=0.2)
        assert np.abs(np.diff(run.pos_enu_m, axis=0)).max() < 0.15
        idle = np.isin(run.phase, [0, 3])
        assert run.current_A[idle].max() == 0
        assert run.current_A[~idle].max() < 25
        powered = run.settled & ~idle
        assert rms(run.apart_m[powered]) < 0.05

    def test_settles_calmly_after_the_descent(self) -> None:
        """The vehicle still sinks and is pitched when the spiral begins: no overshoot to speak of, no tumbling."""
        run = dive(*DIVE[:2])
        late = run.phase == 1
        assert run.apart_m[late].max() < 0.5
        assert run.apart_m[late & (run.phase_time_s > 10)].max() < 0.02
        assert run.apart_deg[late].max() < 10
        assert np.degrees(np.abs(run.rate_rad_s[late])).max() < 10

    def test_magnetometer_sensor_agrees_with_our_rotation(self) -> None:
        run = dive(*DIVE[1:2], heading_deg=70)
        _, model, data = auv()
        field = np.array([-1940.0, 31916.0, -41285.0])
        model.opt.magnetic[:] = field
        for q, R in zip(run.q[::50], run.R_wb[::50], strict=True):
            data.qpos[3:7] = q
            mujoco.mj_forward(model, data)
            assert np.abs(data.sensor("magnetometer").data - R.T @ field).max() < 1e-9 * np.linalg.norm(field)
