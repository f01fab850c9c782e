"""The quadrotor under control: hover, margins of the loop, tracking of paths in still air and in wind."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from pydantic import TypeAdapter

from scenarios.paths import Phase, Start
from scenarios.spec import FieldSpec, SamplingSpec
from sim.motion import Motion, drive
from sim.scenario import Scenario
from sim.vehicles.quadrotor import AMPERE_PER_N32, Quadrotor, QuadrotorSpec
from sim.vehicles.quadrotor_control import SIZE, attitude_for, control

WEIGHT_N = 1.5 * 9.81
DRAG_N_S2_M2 = 1.2 * 0.55 * np.pi * 0.12**2
SPIRAL = {"kind": "spiral", "radius_m": 20, "turn_rate_deg_s": 10, "vertical_speed_m_s": 0.5, "turns": 2, "run_in_s": 8}
COMB = {"kind": "comb", "line_length_m": 100, "line_spacing_m": 40, "lines": 3, "speed_m_s": 7, "run_in_s": 8}
ROTATE = {"kind": "rotate", "duration_s": 64, "tilt_amplitude_deg": 15, "turn_rate_deg_s": 20}
HOVER = {"kind": "hover", "duration_s": 30}


def plant() -> tuple[Quadrotor, mujoco.MjModel, mujoco.MjData]:
    vehicle = Quadrotor(QuadrotorSpec(kind="quadrotor"))
    model = vehicle.model()
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    return vehicle, model, data


def fly(*phases: dict[str, Any], seed: int = 0, **table: Any) -> SimpleNamespace:
    """The motion of the phases at 50 Hz, all blocks joined: fields of Motion and of Kinematics."""
    scenario = Scenario(
        **{"name": "flight", "summary": "test", "phases": phases, "vehicle": {"kind": "quadrotor", **table}},
        field=FieldSpec(enu_nT=(0.0, 20_000.0, -40_000.0)),
        sampling=SamplingSpec(rate_hz=50),
    )
    blocks: list[Motion] = list(drive(scenario, np.random.default_rng(seed)))
    parts: dict[str, Any] = {k: [getattr(b, k) for b in blocks] for k in ("time_s", "R_wb", "current_A", "reference")}
    parts |= {k: [getattr(b.kinematics, k) for b in blocks] for k in ("pos_enu_m", "q", "velocity_m_s", "rate_rad_s")}
    parts["settled"] = [b.phase_time_s > scenario.phases[b.phase].settle_s for b in blocks]
    return SimpleNamespace(**{k: np.concatenate(v) for k, v in parts.items()})


def error_m(flight: SimpleNamespace) -> np.ndarray:
    return np.linalg.norm(flight.reference[:, :3] - flight.pos_enu_m, axis=1)


def thrust_N(current_A: np.ndarray) -> np.ndarray:
    return (current_A / AMPERE_PER_N32) ** (2 / 3)


class TestHover:
    def test_thrust_is_the_weight_shared_equally(self) -> None:
        flight = fly(HOVER, heading_deg=30, height_m=12)
        rotors = thrust_N(flight.current_A)
        assert rotors.shape == (1500, 4)
        np.testing.assert_allclose(rotors.sum(axis=1), WEIGHT_N, rtol=1e-3)
        np.testing.assert_allclose(rotors, WEIGHT_N / 4, rtol=1e-6)
        assert error_m(flight).max() < 1e-6
        np.testing.assert_allclose(flight.pos_enu_m[0], [0, 0, 12])
        np.testing.assert_allclose(flight.R_wb[0, :, 0], [np.cos(np.radians(30)), 0.5, 0], atol=1e-12)

    def test_motors_draw_what_momentum_theory_says(self) -> None:
        """P = T^1.5 / sqrt(2 rho A) over an efficiency of a half at 14.8 V; rotor radius 0.12 m."""
        ideal_W = (WEIGHT_N / 4) ** 1.5 / np.sqrt(2 * 1.2 * np.pi * 0.12**2)
        assert fly(HOVER).current_A[-1] == pytest.approx(ideal_W / 0.5 / 14.8, rel=0.03)

    def test_it_leans_into_the_wind_as_the_drag_demands(self) -> None:
        flight = fly(HOVER, wind_enu_m_s=(6, 0, 0))
        drag = DRAG_N_S2_M2 * 36
        assert error_m(flight)[-1] < 1e-3
        assert thrust_N(flight.current_A[-1]).sum() == pytest.approx(np.hypot(WEIGHT_N, drag), rel=1e-4)
        assert -flight.R_wb[-1, 0, 2] / flight.R_wb[-1, 2, 2] == pytest.approx(drag / WEIGHT_N, rel=1e-2)


class TestControl:
    def test_commanded_attitude_has_the_thrust_axis_and_exactly_the_heading(self) -> None:
        R = np.column_stack(attitude_for((3.0, -2.0, 12.0), 0.7))
        np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
        np.testing.assert_allclose(R[:, 2], np.array([3.0, -2.0, 12.0]) / np.sqrt(157.0))
        assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(0.7)
        assert np.linalg.det(R) > 0

    def test_commanded_pitch_and_roll_are_not_used(self) -> None:
        vehicle, model, data = plant()
        phase = TypeAdapter(Phase).validate_python(SPIRAL)
        row = phase.reference(Start((0.0, 0.0, 30.0), 0.0), np.array([7.0]))[0]
        tilted = row.copy()
        tilted[[10, 11, 13, 14, 16, 17]] = 0.3
        commands = np.zeros((2, 4))
        for reference, ctrl in zip((row, tilted), commands, strict=True):
            control(data.qpos, data.qvel, reference, vehicle.gains(model, phase), np.zeros(SIZE), ctrl)
        np.testing.assert_array_equal(commands[0], commands[1])

    @pytest.mark.parametrize(("factor", "late"), [(1, 0), (0.35, 0), (2.5, 0), (1, 1), (1.4, 1)])
    def test_loop_is_stable_with_margins(self, factor: float, late: int) -> None:
        """Eigenvalues of one closed-loop step about hover, with the loop gain changed or the command a step late."""
        poles = np.linalg.eigvals(closed_loop_step(factor, late))
        assert np.abs(poles).max() < 1

    def test_loop_would_not_be_stable_with_any_gain(self) -> None:
        assert np.abs(np.linalg.eigvals(closed_loop_step(4.0, 0))).max() > 1


def closed_loop_step(factor: float, late: int) -> np.ndarray:
    """Jacobian of a step of 50 Hz in [position, rotation, velocity, rate, integral, delayed commands] about hover."""
    vehicle, model, data = plant()
    gains = vehicle.gains(model, TypeAdapter(Phase).validate_python(HOVER))
    rest, hover, reference = data.qpos.copy(), data.ctrl.copy(), np.zeros(18)
    reference[2] = rest[2]

    def step(x: np.ndarray) -> np.ndarray:
        memory, ctrl, moved = np.zeros(SIZE), np.zeros(4), np.zeros(6)
        memory[:3] = x[12:15]
        data.qpos[:], data.qvel[:] = rest, x[6:12]
        mujoco.mj_integratePos(model, data.qpos, x[:6].copy(), 1.0)
        control(data.qpos, data.qvel, reference, gains, memory, ctrl)
        commands = np.concatenate([x[15:], factor * (ctrl - hover)])
        data.ctrl[:] = hover + commands[:4]
        mujoco.mj_step(model, data)
        mujoco.mj_differentiatePos(model, moved, 1.0, rest, data.qpos)
        return np.concatenate([moved, data.qvel, memory[:3], commands[4:]])

    nudges = 1e-5 * np.eye(15 + 4 * late)
    return np.column_stack([(step(e) - step(-e)) / 2e-5 for e in nudges])


class TestTracking:
    @pytest.mark.parametrize("wind", [(0, 0, 0), (3, 0, 0)])
    @pytest.mark.parametrize(("phase", "limit_m"), [(SPIRAL, 0.05), (COMB, 0.3)])
    def test_follows_spiral_and_comb(self, phase: dict[str, Any], limit_m: float, wind: tuple[float, ...]) -> None:
        flight = fly(phase, wind_enu_m_s=wind)
        error = error_m(flight)[flight.settled]
        assert np.sqrt(np.mean(error**2)) < limit_m * (0.05 if wind == (0, 0, 0) else 0.5)
        yaw = np.arctan2(flight.R_wb[:, 1, 0], flight.R_wb[:, 0, 0])
        assert np.degrees(np.abs(np.sin(yaw - flight.reference[:, 9]))).max() < 0.1

    def test_rotate_reaches_its_tilt_about_both_axes(self) -> None:
        """Pitch, then roll: what gravity, the commanded acceleration and drag demand, and at least the amplitude."""
        flight = fly(ROTATE)
        pitch = np.degrees(np.arcsin(-flight.R_wb[:, 2, 0]))
        roll = np.degrees(np.arctan2(flight.R_wb[:, 2, 1], flight.R_wb[:, 2, 2]))
        for angle in (pitch, roll):
            assert 15 < angle.max() < 18
            assert -18 < angle.min() < -15
        force = flight.reference[:, 6:9] + [0, 0, 9.81]
        speed = np.linalg.norm(flight.reference[:, 3:6], axis=1, keepdims=True)
        force = force + DRAG_N_S2_M2 / 1.5 * speed * flight.reference[:, 3:6]
        axis = force / np.linalg.norm(force, axis=1, keepdims=True)
        lean = np.degrees(np.linalg.norm(np.cross(axis, flight.R_wb[:, :, 2]), axis=1))
        assert lean[flight.settled].max() < 0.5

    def test_phases_join_at_speed_without_upset(self) -> None:
        flight = fly(COMB | {"lines": 1, "line_length_m": 200}, SPIRAL, HOVER, wind_enu_m_s=(2, -2, 0), gust_std_m_s=1)
        assert error_m(flight).max() < 0.5
        assert flight.R_wb[:, 2, 2].min() > np.cos(np.radians(25))

    def test_a_path_beyond_its_means_does_not_upset_it(self) -> None:
        flight = fly(
            COMB | {"speed_m_s": 30, "run_in_s": 4, "line_length_m": 300}, wind_enu_m_s=(8, 0, 0), gust_std_m_s=3
        )
        assert np.degrees(np.arccos(flight.R_wb[:, 2, 2].min())) < 75
        assert np.isfinite(flight.pos_enu_m).all()
