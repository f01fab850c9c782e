"""Turntable: hinges against analytic dynamics, inverse dynamics and rates against MuJoCo's, tracking, coverage."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from scenarios.spec import FieldSpec, SamplingSpec
from sim.engine import StateLog
from sim.motion import drive
from sim.rotation import matrix_from_q
from sim.scenario import Scenario
from sim.vehicles.base import STEP_S
from sim.vehicles.turntable import Turntable, TurntableSpec, control, inverse_dynamics

STOPS = {"kind": "turntable_stops", "dwell_s": 5}
TURNS = {"kind": "turntable_turns", "rate_deg_s": 30}
TUMBLE = {"kind": "tumble"}
FAST_TUMBLE = {"kind": "tumble", "duration_s": 80, "roll_period_s": 10, "pitch_period_s": 13, "yaw_rate_deg_s": 60}


def table() -> tuple[Turntable, mujoco.MjModel, mujoco.MjData]:
    vehicle = Turntable(TurntableSpec(kind="turntable"))
    model = vehicle.model()
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    return vehicle, model, data


def turn(*phases: dict[str, Any], rate_hz: float = 50.0) -> SimpleNamespace:
    """The motion of the phases, all blocks joined: fields of Motion and of Kinematics."""
    scenario = Scenario(
        **{"name": "turn", "summary": "test", "phases": phases, "vehicle": {"kind": "turntable"}},
        field=FieldSpec(enu_nT=(0.0, 20_000.0, -40_000.0)),
        sampling=SamplingSpec(rate_hz=rate_hz),
    )
    blocks = list(drive(scenario, np.random.default_rng(0)))
    parts: dict[str, Any] = {k: [getattr(b, k) for b in blocks] for k in ("time_s", "R_wb", "reference", "current_A")}
    kinematics = ("pos_enu_m", "q", "velocity_m_s", "rate_rad_s", "accel_m_s2")
    parts |= {k: [getattr(b.kinematics, k) for b in blocks] for k in kinematics}
    return SimpleNamespace(**{k: np.concatenate(v) for k, v in parts.items()})


def error_deg(motion: SimpleNamespace) -> np.ndarray:
    """Angle between the reference's attitude and the true one."""
    wanted = Rotation.from_euler("ZYX", motion.reference[:, 9:12])
    return np.degrees((wanted.inv() * Rotation.from_matrix(motion.R_wb)).magnitude())


class TestPlant:
    @pytest.mark.parametrize(
        ("hinge", "inertia", "damping"), [(0, 3.0 + 0.9 + 0.12, 0.5), (1, 0.5 + 0.1, 0.3), (2, 0.15, 0.1)]
    )
    def test_step_of_torque_gives_torque_over_inertia(self, hinge: int, inertia: float, damping: float) -> None:
        """J w' = M - b w: w = M / b (1 - exp(-b t / J)), which begins as M t / J."""
        _, model, data = table()
        data.ctrl[hinge] = 2.0
        for steps in (1, 49):
            mujoco.mj_step(model, data, nstep=steps)
            expected = 2.0 / damping * -np.expm1(-damping * data.time / inertia)
            assert data.qvel[hinge] == pytest.approx(expected, rel=1e-6)
            if steps == 1:
                assert data.qvel[hinge] == pytest.approx(2.0 * STEP_S / inertia, rel=0.01)
        assert np.abs(np.delete(data.qvel, hinge)).max() < 1e-12

    def test_gravity_does_not_move_the_balanced_frames(self) -> None:
        _, model, data = table()
        data.qpos[:] = (0.3, 1.1, -2.0)
        mujoco.mj_step(model, data, nstep=500)
        np.testing.assert_allclose(data.qvel, 0, atol=1e-12)

    def test_inverse_dynamics_are_the_engines(self) -> None:
        """Centrifugal and gyroscopic coupling of the three frames, at arbitrary angles, rates and accelerations."""
        vehicle, model, data = table()
        inertia, rng, torque = vehicle.gains(model, None)[4:], np.random.default_rng(2), np.zeros(3)
        for _ in range(50):
            data.qpos[:], data.qvel[:], data.qacc[:] = rng.normal(size=(3, 3)) * 2
            mujoco.mj_inverse(model, data)
            inverse_dynamics(data.qpos, data.qvel, data.qacc.copy(), inertia, torque)
            np.testing.assert_allclose(torque + model.dof_damping * data.qvel, data.qfrc_inverse, rtol=1e-9, atol=1e-10)

    def test_attitude_and_rate_are_the_engines(self) -> None:
        vehicle, model, data = table()
        rng, rate = np.random.default_rng(3), np.zeros(6)
        angles, rates, none = *rng.normal(size=(2, 50, 3)) * 3, np.zeros((50, 3))
        ours = vehicle.kinematics(model, StateLog(angles, rates, none, none))
        platform = model.body("platform").id
        for angle, turning, q, rate_rad_s in zip(angles, rates, ours.q, ours.rate_rad_s, strict=True):
            data.qpos[:], data.qvel[:] = angle, turning
            mujoco.mj_forward(model, data)
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, platform, rate, 1)
            np.testing.assert_allclose(rate_rad_s, rate[:3], atol=1e-12)
            np.testing.assert_allclose(matrix_from_q(q[None])[0].ravel(), data.xmat[platform], atol=1e-12)
            expected = Rotation.from_euler("ZYX", angle).as_matrix()
            np.testing.assert_allclose(matrix_from_q(q[None])[0], expected, atol=1e-12)

    def test_magnetometer_sensor_agrees_with_our_rotation(self) -> None:
        """The hinges' angles go into the engine, the motion's R_wb is ours."""
        vehicle, model, data = table()
        field = np.array([-1940.0, 31916.0, -41285.0])
        model.opt.magnetic[:] = field
        angles = turn(TUMBLE, rate_hz=0.2).reference[:, 9:12]
        none = np.zeros_like(angles)
        motion = vehicle.kinematics(model, StateLog(angles, none, none, none))
        for angle, R in zip(angles, matrix_from_q(motion.q), strict=True):
            data.qpos[:] = angle
            mujoco.mj_forward(model, data)
            assert np.abs(data.sensor("magnetometer").data - R.T @ field).max() < 1e-9 * np.linalg.norm(field)


class TestTracking:
    @pytest.mark.parametrize("phase", [STOPS, TURNS, TUMBLE, FAST_TUMBLE])
    def test_follows_within_a_hundredth_of_a_degree(self, phase: dict[str, Any]) -> None:
        assert np.sqrt(np.mean(error_deg(turn(phase)) ** 2)) < 0.01

    @pytest.mark.parametrize("axis", ["yaw", "pitch", "roll"])
    def test_twelve_stops_are_at_rest_30_degrees_apart(self, axis: str) -> None:
        motion = turn(STOPS | {"axis": axis})
        middle = np.searchsorted(motion.time_s, 10.0 * np.arange(12) + 4.0)
        along = np.eye(3)[("roll", "pitch", "yaw").index(axis)]
        for k, R in enumerate(motion.R_wb[middle]):
            away = Rotation.from_rotvec(np.radians(-30.0 * k) * along).inv() * Rotation.from_matrix(R)
            assert np.degrees(away.magnitude()) < 1e-3
        still = (motion.time_s % 10.0 > 1.0) & (motion.time_s % 10.0 < 4.9) & (motion.time_s < 115)
        assert np.degrees(np.abs(motion.rate_rad_s[still]).max()) < 1e-3

    def test_integrated_body_rate_is_the_attitude(self) -> None:
        """Over 5000 degrees of turning; between samples the held torque bends the rate a little: no spline knows."""
        motion = turn(TUMBLE)
        rate = CubicSpline(motion.time_s, motion.rate_rad_s)

        def slope(t: float, q: np.ndarray) -> np.ndarray:
            w = rate(t)
            return np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)]) / 2

        span, times = (0.0, motion.time_s[-1]), motion.time_s[::500]
        q = solve_ivp(slope, span, motion.q[0], rtol=1e-8, atol=1e-9, t_eval=times, method="DOP853").y.T
        angle = (Rotation.from_quat(q, scalar_first=True).inv() * Rotation.from_matrix(motion.R_wb[::500])).magnitude()
        assert np.degrees(angle.max()) < 0.005

    def test_body_rate_is_what_the_coupled_hinges_give(self) -> None:
        """Near pitch 88 degrees the yaw turns the body about its x axis: rates add up and stay bounded."""
        motion = turn(TUMBLE)
        norm = np.degrees(np.linalg.norm(motion.rate_rad_s, axis=1))
        hinges = np.degrees(np.abs(motion.reference[:, 12:15]))
        assert norm.max() <= hinges.sum(axis=1).max() + 0.01
        assert norm.max() > 20

    def test_tumble_covers_the_whole_sphere(self) -> None:
        """For fields of middle latitudes: no gap of the size of an octant, all eight visited, no axis weak."""
        R_wb = turn(TUMBLE, rate_hz=10).R_wb
        k = np.arange(400) + 0.5
        z, angle = 1 - 2 * k / 400, np.pi * (1 + 5**0.5) * k
        grid = np.column_stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z])
        for field in ([0.0, 0.47, -0.88], [-0.04, 0.61, -0.79], [0.0, 0.90, 0.44]):
            seen = np.einsum("nij,i->nj", R_wb, np.array(field) / np.linalg.norm(field))
            nearest = np.max(seen @ grid.T, axis=0)
            assert np.degrees(np.arccos(np.clip(nearest, -1, 1))).max() < 35
            assert np.bincount((seen > 0) @ [1, 2, 4], minlength=8).min() > 0.04 * len(seen)
            assert np.linalg.eigvalsh(seen.T @ seen / len(seen))[0] > 0.15
        pitch, roll = np.arcsin(-R_wb[:, 2, 0]), np.arctan2(R_wb[:, 2, 1], R_wb[:, 2, 2])
        assert np.degrees([pitch.min(), pitch.max()]) == pytest.approx([-88, 88], abs=0.5)
        assert np.degrees([roll.min(), roll.max()]) == pytest.approx([-180, 180], abs=1)

    def test_whole_turns_between_phases_do_not_count(self) -> None:
        motion = turn(TURNS, STOPS | {"axis": "pitch"}, TURNS)
        assert error_deg(motion).max() < 0.01
        assert np.degrees(np.linalg.norm(motion.rate_rad_s, axis=1).max()) < 105


def test_the_table_stays_in_place_and_draws_no_current() -> None:
    motion = turn(TURNS, rate_hz=1)
    assert motion.current_A.shape == (len(motion.time_s), 0)
    for still in (motion.pos_enu_m, motion.velocity_m_s, motion.accel_m_s2):
        np.testing.assert_array_equal(still, np.zeros((len(motion.time_s), 3)))


def test_loop_is_stable_with_margins() -> None:
    """Eigenvalues of one closed-loop step at an arbitrary attitude, with the loop gain changed or a step late."""
    for factor, late in ((1.0, 0), (0.3, 0), (2.5, 0), (1.0, 1)):
        assert np.abs(np.linalg.eigvals(closed_loop_step(factor, late))).max() < 1
    assert np.abs(np.linalg.eigvals(closed_loop_step(5.0, 0))).max() > 1


def closed_loop_step(factor: float, late: int) -> np.ndarray:
    """Jacobian of a step of 50 Hz in [angles, rates, delayed commands]."""
    vehicle, model, data = table()
    gains, reference, rest = vehicle.gains(model, None), np.zeros(18), np.array([0.4, 1.2, -2.0])
    reference[9:12] = rest

    def step(x: np.ndarray) -> np.ndarray:
        ctrl = np.zeros(3)
        data.qpos[:], data.qvel[:] = rest + x[:3], x[3:6]
        control(data.qpos, data.qvel, reference, gains, np.zeros(6), ctrl)
        commands = np.concatenate([x[6:], factor * ctrl])
        data.ctrl[:] = commands[:3]
        mujoco.mj_step(model, data)
        return np.concatenate([data.qpos - rest, data.qvel, commands[3:]])

    nudges = 1e-5 * np.eye(6 + 3 * late)
    return np.column_stack([(step(e) - step(-e)) / 2e-5 for e in nudges])
