"""The quadrotor's plant: flight mechanics against analytic solutions, wind and gusts, error of the integration."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from pydantic import TypeAdapter
from scipy.integrate import solve_ivp

from scenarios.paths import Phase, Start
from sim.engine import ReferenceTrack, advance, log_of
from sim.plant import plant_of
from sim.rotation import matrix_from_q
from sim.vehicles.base import STEP_S
from sim.vehicles.quadrotor import GUST_CORRELATION_S, Quadrotor, QuadrotorSpec
from sim.vehicles.quadrotor_control import SIZE, control, mix

WEIGHT_N = 1.5 * 9.81
DRAG_N_S2_M2 = 1.2 * 0.55 * np.pi * 0.12**2
ROTORS = np.array([[0.17, 0.17, 0.016], [-0.17, 0.17, -0.016], [-0.17, -0.17, 0.016], [0.17, -0.17, -0.016]])
SPIRAL = {"kind": "spiral", "radius_m": 20, "turn_rate_deg_s": 10, "vertical_speed_m_s": 0.5, "turns": 2, "run_in_s": 8}
COMB = {"kind": "comb", "line_length_m": 100, "line_spacing_m": 40, "lines": 3, "speed_m_s": 7, "run_in_s": 8}
HOVER = {"kind": "hover", "duration_s": 30}
GUSTY: dict[str, Any] = {"wind_enu_m_s": (3.0, -1.0, 0.5), "gust_std_m_s": 1.5}


def quadrotor(**table: Any) -> Quadrotor:
    return Quadrotor(QuadrotorSpec(kind="quadrotor", **table))


def plant(**options: Any) -> tuple[Quadrotor, mujoco.MjModel, mujoco.MjData]:
    vehicle = quadrotor(**options)
    model = vehicle.model()
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    return vehicle, model, data


def along(vehicle: Quadrotor, model: mujoco.MjModel, data: mujoco.MjData, phase: dict[str, Any]) -> tuple[Any, ...]:
    """Sixteen seconds of a phase through the engine: reference (800, 18), constants of the controller, log."""
    path = TypeAdapter(Phase).validate_python(phase)
    start = Start((0.0, 0.0, 30.0), np.radians(vehicle.spec.heading_deg))
    reference = np.ascontiguousarray(path.reference(start, STEP_S * np.arange(800)))
    gains, log = vehicle.gains(model, path), log_of(model, 800)
    flow = vehicle.flow(800, np.random.default_rng(0), {})
    plant = plant_of(model, data, vehicle.body, vehicle.added_mass(model))
    advance(control, plant, ReferenceTrack(reference, flow, gains, np.zeros(SIZE)), log)
    return reference, gains, log


class TestPlant:
    def test_free_fall_approaches_the_terminal_velocity_in_any_attitude(self) -> None:
        """v = v_t tanh(g t / v_t), v_t^2 = m g / D: the step response of a falling body with quadratic drag."""
        _, model, data = plant(height_m=1000)
        data.ctrl[:] = 0
        data.qpos[3:7] = (0.8, 0.36, 0.48, 0.0)
        terminal = np.sqrt(WEIGHT_N / DRAG_N_S2_M2)
        for steps in (50, 100, 850):
            mujoco.mj_step(model, data, nstep=steps)
            expected = terminal * np.tanh(9.81 * data.time / terminal)
            np.testing.assert_allclose(data.qvel[:3], [0, 0, -expected], rtol=1e-7, atol=1e-9)
        assert 0.999 < -data.qvel[2] / terminal < 1

    def test_drag_is_towards_the_wind_with_its_square(self) -> None:
        _, model, data = plant()
        for wind in ([6.0, 0, 0], [0, -3.0, 0], [2.0, 2.0, 1.0]):
            model.opt.wind[:] = wind
            mujoco.mj_forward(model, data)
            np.testing.assert_allclose(
                data.qfrc_passive[:3], DRAG_N_S2_M2 * np.linalg.norm(wind) * np.array(wind), rtol=1e-9, atol=1e-12
            )

    def test_a_plan_counts_on_this_drag(self) -> None:
        assert Quadrotor.drag_1_m == pytest.approx(DRAG_N_S2_M2 / 1.5, rel=0.01)

    @pytest.mark.parametrize(("axis", "inertia"), [(0, 0.014), (1, 0.017), (2, 0.027)])
    def test_step_of_torque_gives_torque_over_inertia(self, axis: int, inertia: float) -> None:
        _, model, data = plant()
        lever = np.stack([ROTORS[:, 1], -ROTORS[:, 0], ROTORS[:, 2]])[axis]
        data.ctrl += 0.1 * np.sign(lever)
        mujoco.mj_step(model, data, nstep=20)
        rate = 0.1 * np.abs(lever).sum() / inertia * data.time
        np.testing.assert_allclose(data.qvel[3 + axis], rate, rtol=1e-3)
        angle = 2 * np.arctan2(data.qpos[4 + axis], data.qpos[3])
        assert angle == pytest.approx(0.5 * rate * data.time, rel=1e-3)
        assert np.abs(np.delete(data.qvel[3:], axis)).max() < 1e-9

    def test_tumbling_obeys_eulers_equations(self) -> None:
        """J w' = M - w x J w and q' = q w / 2, integrated by another solver; the gyroscopic terms are large here."""
        _, model, data = plant()
        model.opt.density = 0
        inertia, rate = np.diag([0.014, 0.017, 0.027]), np.array([4.0, 0.3, -3.0])
        data.qvel[3:], data.ctrl[:] = rate, [3.0, 2.9, 3.1, 3.02]
        torque = np.array([data.ctrl @ ROTORS[:, 1], -data.ctrl @ ROTORS[:, 0], data.ctrl @ ROTORS[:, 2]])

        def slope(_: float, state: np.ndarray) -> np.ndarray:
            w, (a, *v) = state[:3], state[3:]
            turn = np.linalg.solve(inertia, torque - np.cross(w, inertia @ w))
            return np.concatenate([turn, [-np.dot(v, w) / 2], (a * w + np.cross(v, w)) / 2])

        expected = solve_ivp(slope, (0, 1), [*rate, 1, 0, 0, 0], rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
        mujoco.mj_step(model, data, nstep=50)
        np.testing.assert_allclose(data.qvel[3:], expected[:3], atol=2e-6)
        np.testing.assert_allclose(data.qpos[3:7], expected[3:], atol=2e-6)
        assert abs(expected[1] - rate[1] - torque[1] / 0.017) > 1  # what a model without coupling would miss

    def test_mixer_and_rotors_give_the_wanted_force_and_torque(self) -> None:
        vehicle, model, data = plant()
        gains = vehicle.gains(model, TypeAdapter(Phase).validate_python(HOVER))
        mix(15.0, 0.3, -0.2, 0.02, gains, data.ctrl)
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.qfrc_actuator, [0, 0, 15.0, 0.3, -0.2, 0.02], atol=1e-12)

    def test_mixer_keeps_within_the_rotors_and_prefers_roll_and_pitch(self) -> None:
        vehicle, model, data = plant()
        gains = vehicle.gains(model, TypeAdapter(Phase).validate_python(HOVER))
        rng = np.random.default_rng(1)
        for demand in rng.normal(size=(500, 4)) * [40.0, 3.0, 3.0, 0.5] + [15.0, 0, 0, 0]:
            mix(*demand, gains, data.ctrl)
            assert data.ctrl.min() > -1e-12
            assert data.ctrl.max() < 9 + 1e-12
            if np.abs(demand[1:3]).sum() < 2 * 0.17 * 9:
                assert data.ctrl @ ROTORS[:, 1] == pytest.approx(demand[1])
                assert -data.ctrl @ ROTORS[:, 0] == pytest.approx(demand[2])

    def test_the_controller_knows_the_plant(self) -> None:
        vehicle, model, _ = plant()
        gains = vehicle.gains(model, TypeAdapter(Phase).validate_python(HOVER))
        np.testing.assert_allclose(gains, [1.5, 9.81, 0.014, 0.017, 0.027, 0.17, 0.016, 9.0, DRAG_N_S2_M2], rtol=1e-12)

    def test_magnetometer_sensor_agrees_with_our_rotation(self) -> None:
        """Over attitudes logged by the loop."""
        vehicle, model, data = plant(heading_deg=70)
        log = along(vehicle, model, data, SPIRAL)[2]
        field = np.array([-1940.0, 31916.0, -41285.0])
        R_wb, probe = matrix_from_q(vehicle.kinematics(model, log).q), mujoco.MjData(model)
        model.opt.magnetic[:] = field
        for qpos, R in zip(log.qpos[::40], R_wb[::40], strict=True):
            probe.qpos[:] = qpos
            mujoco.mj_forward(model, probe)
            assert np.abs(probe.sensor("magnetometer").data - R.T @ field).max() < 1e-9 * np.linalg.norm(field)


class TestGusts:
    def test_mean_std_and_correlation_time(self) -> None:
        """20,000 s are 4000 correlation times: one sigma of the std is 1.1 %, of the mean 1.6 % of it."""
        steps = 1_000_000
        gust = quadrotor(**GUSTY).flow(steps, np.random.default_rng(5), {}) - GUSTY["wind_enu_m_s"]
        np.testing.assert_allclose(
            gust.mean(axis=0), 0, atol=4.5 * 1.5 * np.sqrt(2 * GUST_CORRELATION_S / (steps * STEP_S))
        )
        np.testing.assert_allclose(gust.std(axis=0), 1.5, rtol=0.05)
        for lag_s in (1.0, 5.0):
            lag = round(lag_s / STEP_S)
            correlation = np.mean(gust[lag:] * gust[:-lag], axis=0) / gust.var(axis=0)
            np.testing.assert_allclose(correlation, np.exp(-lag_s / GUST_CORRELATION_S), atol=0.06)
        assert np.abs(np.corrcoef(gust.T) - np.eye(3)).max() < 0.1

    def test_first_gust_is_already_stationary(self) -> None:
        vehicle = quadrotor(**GUSTY)
        first = np.concatenate([vehicle.flow(1, np.random.default_rng(i), {}) for i in range(1000)])
        np.testing.assert_allclose(first.std(axis=0), 1.5, rtol=0.1)

    def test_blocks_of_any_length_give_the_same_bytes(self) -> None:
        vehicle, rng, memory = quadrotor(**GUSTY), np.random.default_rng(8), {}
        whole = vehicle.flow(1000, np.random.default_rng(8), {})
        parts = [vehicle.flow(n, rng, memory) for n in (1, 7, 492, 500)]
        assert np.concatenate(parts).tobytes() == whole.tobytes()

    def test_calm_is_calm(self) -> None:
        np.testing.assert_array_equal(quadrotor().flow(10, np.random.default_rng(0), {}), np.zeros((10, 3)))


@pytest.mark.parametrize("phase", [SPIRAL, COMB])
def test_step_of_20_ms_agrees_with_a_hundredth_of_it(phase: dict[str, Any]) -> None:
    """The control stays at 50 Hz; only the integration becomes finer. 16 s in wind."""
    vehicle, model, data = plant(wind_enu_m_s=(3, 0, 0))
    reference, gains, log = along(vehicle, model, data, phase)
    _, fine_model, fine = plant()
    fine_model.opt.timestep, fine_model.opt.wind[:], memory = STEP_S / 100, (3, 0, 0), np.zeros(SIZE)
    worst_m = worst_rad = 0.0
    for row, ours in zip(reference, log.qpos, strict=True):
        worst_m = max(worst_m, np.abs(ours[:3] - fine.qpos[:3]).max())
        worst_rad = max(worst_rad, 2 * np.abs(ours[3:7] - fine.qpos[3:7]).max())
        control(fine.qpos, fine.qvel, row, gains, memory, fine.ctrl)
        mujoco.mj_step(fine_model, fine, nstep=100)
    assert worst_m < 1e-6
    assert np.degrees(worst_rad) < 1e-5
