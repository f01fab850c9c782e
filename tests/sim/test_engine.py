"""The engine in water against an independent implementation of the 6-DOF equations, analytic solutions and energy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from sim.engine import (
    ReferenceTrack,
    StateLog,
    Stop,
    advance,
    control_signature,
    log_of,
)
from sim.plant import library_file, mass_matrix, plant_of
from sim.vehicles.auv import Auv, AuvSpec
from tests.nightly import first_daily
from tests.sim.fossen import DENSITY, GRAVITY, Fossen, tuckerman

AUV = Auv(AuvSpec(kind="auv"))


@njit(control_signature)
def hold(qpos, qvel, row, gains, memory, ctrl):
    """Leaves the commands as they are."""


def run(model: Any, data: Any, seconds: float, dt: float, current: Any = (0, 0, 0), every: int = 1) -> StateLog:
    """The log of the engine with constant commands, a row at each `every`-th step; the water from `Auv.added_mass`."""
    model.opt.timestep = dt
    steps = round(seconds / dt)
    log, flow = log_of(model, -(-steps // every)), np.tile(np.asarray(current, float), (steps, 1))
    course = ReferenceTrack(np.zeros((steps, 18)), flow, np.zeros(1), np.zeros(1), every)
    assert advance(hold, plant_of(model, data, AUV.body, AUV.added_mass(model)), course, log) == steps
    return log


def thrusts(model: mujoco.MjModel, wrench: Array) -> Array:
    """Commands of all actuators that give a wrench on the level vehicle."""
    data, columns = mujoco.MjData(model), []
    for unit in np.eye(model.nu)[:8]:
        data.ctrl[:] = unit
        mujoco.mj_forward(model, data)
        columns.append(data.qfrc_actuator.copy())
    return np.concatenate([np.linalg.pinv(np.array(columns).T) @ wrench, np.zeros(model.nu - 8)])


def nu_of(qvel: Array, R: Array) -> Array:
    return np.concatenate([R.T @ qvel[:3], qvel[3:]])


class TestAddedMass:
    def test_engine_values_are_those_of_tuckerman(self) -> None:
        """The engine's own quadrature against ours; it is coarser for the thin tail planes."""
        model = AUV.model()
        for name, tolerance in (("hull", 1e-6), ("rudder", 0.01), ("elevator", 0.01)):
            geom = model.geom(name).id
            mass, inertia = tuckerman(model.geom_size[geom])
            np.testing.assert_allclose(model.geom_fluid[geom, 6:9], mass, rtol=tolerance, atol=1e-5)
            np.testing.assert_allclose(model.geom_fluid[geom, 9:12], inertia, rtol=tolerance, atol=1e-6)

    def test_matrix_about_the_origin_couples_sway_with_yaw_and_heave_with_pitch(self) -> None:
        model = AUV.model()
        added = AUV.added_mass(model)
        np.testing.assert_allclose(added, Fossen(model).added, atol=1e-9)
        np.testing.assert_allclose(added, added.T, atol=1e-12)
        assert np.linalg.eigvalsh(added).min() > 0
        fin = DENSITY * model.geom_fluid[model.geom("rudder").id, 7]
        assert added[1, 5] == pytest.approx(-0.85 * fin, rel=1e-2)
        assert added[2, 4] == pytest.approx(0.85 * fin, rel=1e-2)

    def test_body_mass_matrix_is_the_rigid_bodys_own(self) -> None:
        model = AUV.model()
        np.testing.assert_allclose(mass_matrix(model), Fossen(model).rigid, atol=1e-6)


class TestStepResponse:
    """A hull without tail planes, centre of mass at its centre, no weight: each degree of freedom is solvable."""

    @staticmethod
    def hull() -> mujoco.MjModel:
        model = AUV.model()
        hull = model.geom("hull").id
        model.geom_fluid[[g for g in range(model.ngeom) if g != hull]] = 0.0
        model.body("auv").ipos[:] = 0.0
        model.opt.gravity[:] = 0.0
        model.opt.viscosity = 0.0
        return model

    @pytest.mark.parametrize("axis", range(6))
    def test_force_from_rest_approaches_terminal_velocity_as_tanh(self, axis: int) -> None:
        """M v' = F - k v^2 from rest: v = v_t tanh(F t / (M v_t)), v_t = sqrt(F / k), M with the added mass."""
        model = self.hull()
        size = model.geom("hull").size
        mass, inertia = tuckerman(size)
        blunt, slender, angular = model.geom_fluid[model.geom("hull").id, 1:4]
        whole = np.concatenate([np.full(3, model.body_mass.sum()), model.body("auv").inertia])
        inertial = (whole + DENSITY * np.concatenate([mass, inertia]))[axis]
        area = np.pi * np.array([size[1] * size[2], size[2] * size[0], size[0] * size[1]])
        swept = 8 * np.pi / 15 * np.array([size[i] * max(size[i - 1], size[i - 2]) ** 4 for i in range(3)])
        reach = np.concatenate([area, swept])
        largest = np.repeat([area.max(), swept.max()], 3)
        strength = np.where(np.arange(6) < 3, blunt, angular)
        k = DENSITY * (strength * reach + slender * (largest - reach))[axis]
        force = 30.0 if axis < 3 else 3.0
        data = mujoco.MjData(model)
        data.ctrl[:] = thrusts(model, np.eye(6)[axis] * force)
        log = run(model, data, 12.0, 0.02)
        t, terminal = 0.02 * np.arange(len(log.qvel)), np.sqrt(force / k)
        # body velocity along the axis; a spinning hull stays where it is
        measured = log.qvel[:, axis]
        np.testing.assert_allclose(measured[1] / 0.02, force / inertial, rtol=1e-2)
        np.testing.assert_allclose(measured, terminal * np.tanh(force * t / inertial / terminal), rtol=1e-5, atol=1e-9)
        without = force / whole[axis]
        assert axis in (0, 3) or abs(measured[1] / 0.02 - without) > 0.3 * without  # what no added mass would give

    @pytest.mark.parametrize("axis", range(6))
    def test_whole_vehicle_starts_with_the_inverse_of_the_full_mass(self, axis: int) -> None:
        model = AUV.model()
        wrench = np.eye(6)[axis] * (30.0 if axis < 3 else 3.0)
        data = mujoco.MjData(model)
        data.ctrl[:] = thrusts(model, wrench)
        log = run(model, data, 0.02, 0.001)
        expected = np.linalg.solve(Fossen(model).total, wrench)
        np.testing.assert_allclose(log.accel[0], expected, rtol=0.01, atol=1e-5)


CASES = {
    "all": {"current": (-0.25, 0.15, 0.05), "ballast": (-30.0, -0.3), "thrust": True},
    "still water": {},
    "current": {"current": (0.3, -0.2, 0.1)},
    "ballast": {"ballast": (60.0, 0.2)},
}


class TestAgainstFossen:
    @pytest.mark.parametrize("name", first_daily(sorted(CASES, key=lambda name: name != "all")))
    def test_twenty_seconds_from_generic_velocities(self, name: str) -> None:
        """Tumbling in all six degrees of freedom, solved by another integrator from independently coded equations."""
        case, rng, model = CASES[name], np.random.default_rng(len(name)), AUV.model()
        fossen, data = Fossen(model, current=np.array(case.get("current", (0.0, 0.0, 0.0)))), mujoco.MjData(model)
        if case.get("thrust"):
            data.ctrl[:8] = rng.uniform(-10, 10, 8)
            mujoco.mj_forward(model, data)
            fossen.tau = data.qfrc_actuator.copy()
        fossen.ballast_N, fossen.trim_m = case.get("ballast", (0.0, 0.0))
        data.ctrl[8:] = -fossen.ballast_N * np.array([1 - fossen.trim_m, fossen.trim_m])
        turn = Rotation.random(random_state=rng)
        data.qpos[3:7] = turn.as_quat(scalar_first=True)
        data.qvel[:] = rng.uniform(-1, 1, 6) * [0.8, 0.8, 0.8, 0.6, 0.6, 0.6]
        start = np.concatenate([data.qpos, turn.as_matrix().T @ data.qvel[:3], data.qvel[3:]])
        log = run(model, data, 20.005, 0.005, fossen.current, every=200)
        times = np.arange(len(log.qpos)) * 1.0
        y = solve_ivp(fossen.slope, (0, 20), start, "DOP853", times, rtol=1e-7, atol=1e-8).y.T
        R = Rotation.from_quat(y[:, 3:7], scalar_first=True)
        apart = (R.inv() * Rotation.from_quat(log.qpos[:, 3:], scalar_first=True)).magnitude()
        assert np.abs(y[:, :3] - log.qpos[:, :3]).max() < 2e-5
        assert np.degrees(apart).max() < 1e-3
        assert np.abs(R.apply(y[:, 7:10]) - log.qvel[:, :3]).max() < 2e-6
        assert np.ptp(log.qpos[:, :3], axis=0).max() > 1.0


class TestEnergy:
    @staticmethod
    def ideal() -> mujoco.MjModel:
        """Water without viscosity, drag or lift: only its inertia."""
        model = AUV.model()
        model.geom_fluid[:, 1:6] = 0.0
        model.opt.viscosity = 0.0
        return model

    @pytest.mark.parametrize("seed", [1, 2])
    def test_body_and_fluid_keep_their_energy_and_impulse(self, seed: int) -> None:
        """(nu^T (M_RB + M_A) nu) / 2 + m g z_cm stays in ideal water; so does the whole's impulse."""
        model, rng = self.ideal(), np.random.default_rng(seed)
        data, fossen = mujoco.MjData(model), Fossen(model)
        turn = Rotation.random(random_state=rng)
        data.qpos[3:7] = turn.as_quat(scalar_first=True)
        data.qvel[:] = rng.uniform(-1, 1, 6) * [1, 1, 1, 1, 0.5, 0.5]
        log = run(model, data, 60.0, 0.01, every=50)
        R = Rotation.from_quat(log.qpos[:, 3:], scalar_first=True).as_matrix()
        nu = np.array([nu_of(qvel, r) for qvel, r in zip(log.qvel, R, strict=True)])
        body = model.body("auv")
        potential = body.mass[0] * GRAVITY * (R @ body.ipos)[:, 2]
        kinetic = np.einsum("ni,ij,nj->n", nu, fossen.total, nu) / 2
        energy = kinetic + potential
        assert np.ptp(kinetic) > 0.05 * kinetic.mean()
        assert np.ptp(energy) < 1e-7 * kinetic.mean()
        impulse = np.einsum("nij,nj->ni", R, (nu @ fossen.total)[:, :3])
        assert np.ptp(impulse, axis=0).max() < 1e-5

    def test_a_current_only_carries_the_motion_along(self) -> None:
        """In ideal water too, seen from the moving water nothing differs but the start (Galilean invariance)."""
        current = np.array([0.4, -0.3, 0.2])
        ends = []
        for stream in (np.zeros(3), current):
            model = AUV.model()
            data = mujoco.MjData(model)
            data.qpos[3:7] = [0.9, 0.1, -0.3, 0.3]
            data.qvel[:] = [0.5, 0.2, -0.3, 0.4, 0.3, -0.2]
            data.qvel[:3] += stream
            log = run(model, data, 10.0, 0.02, stream)
            log.qpos[-1, :3] -= stream * 0.02 * (len(log.qpos) - 1)
            ends.append(np.concatenate([log.qpos[-1], log.qvel[-1, 3:]]))
        np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


class TestLoop:
    def test_step_error_falls_with_the_fourth_power(self) -> None:
        """Sixteenfold at half the step while the axis of rotation turns."""
        ends = []
        for dt in (0.04, 0.02, 0.00125):
            model = TestEnergy.ideal()
            data = mujoco.MjData(model)
            data.qvel[:] = [0.8, 0.3, -0.2, 0.3, 0.4, 0.2]
            run(model, data, 16.0, dt)
            ends.append(data.qpos.copy())
        coarse, fine = (np.abs(e - ends[2]).max() for e in ends[:2])
        assert fine < 2e-6
        assert 14 < coarse / fine < 18

    @pytest.mark.parametrize("depth_m", [2.0, 3.0, 4.0])
    def test_end_at_a_depth_falls_on_a_row_of_the_log(self, depth_m: float) -> None:
        model = AUV.model()
        data = mujoco.MjData(model)
        data.ctrl[8] = -100.0
        plant, log = plant_of(model, data, AUV.body, AUV.added_mass(model)), log_of(model, 400)
        nothing = np.zeros(1)
        down = ReferenceTrack(np.zeros((2000, 18)), np.zeros((2000, 3)), nothing, nothing, 5, Stop(-depth_m, -1.0))
        done = advance(hold, plant, down, log)
        assert 0 < done < 2000
        assert done % 5 == 0
        assert log.qpos[done // 5 - 1, 2] > -depth_m > data.qpos[2]

    def test_accelerations_in_the_log_are_those_of_the_velocity(self) -> None:
        model = AUV.model()
        data = mujoco.MjData(model)
        data.ctrl[0] = 20.0
        log = run(model, data, 2.0, 0.02)
        np.testing.assert_allclose(np.diff(log.qvel, axis=0) / 0.02, log.accel[:-1], atol=1e-12)


class TestLibraryFile:
    @pytest.mark.parametrize(
        ("platform", "name"),
        [("linux", "libmujoco.so.4.0.0"), ("darwin", "libmujoco.4.0.0.dylib"), ("win32", "mujoco.dll")],
    )
    def test_each_system_has_its_own_name(self, platform: str, name: str, tmp_path: Path) -> None:
        for other in ("libmujoco.so.4.0.0", "libmujoco.4.0.0.dylib", "mujoco.dll", "mujoco.txt"):
            (tmp_path / other).touch()
        assert library_file(tmp_path, platform) == tmp_path / name

    def test_a_package_without_it_is_refused_by_name(self, tmp_path: Path) -> None:
        with pytest.raises(ImportError, match=r"mujoco.dll is not in .*: install the package mujoco again"):
            library_file(tmp_path, "win32")

    def test_an_unknown_system_is_refused_with_the_known_ones(self, tmp_path: Path) -> None:
        with pytest.raises(ImportError, match="not known for aix, only for linux, darwin, win32"):
            library_file(tmp_path, "aix")
