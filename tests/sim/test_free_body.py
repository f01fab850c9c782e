"""The controller of free bodies on another body than the AUV: six thrusters, no ballast, other places and limits."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import mujoco
import numpy as np
import pytest
from pydantic import TypeAdapter
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from scenarios.paths import Ability, Phase, PhaseBase, Start
from sim.engine import ReferenceTrack, StateLog, advance, log_of
from sim.plant import plant_of
from sim.vehicles.base import STEP_S, Kinematics, Vehicle, VehicleTable, free_body_kinematics
from sim.vehicles.fluid import added_mass
from sim.vehicles.free_body_control import MEMORY_SIZE, follow, tracking_gains

THRUSTERS = {
    "left": ((-0.2, 0.15, 0.0), (1, 0, 0)),
    "right": ((-0.2, -0.15, 0.0), (1, 0, 0)),
    "upper": ((0.05, 0.0, 0.1), (0, 1, 0)),
    "lower": ((0.05, 0.0, -0.1), (0, 1, 0)),
    "bow": ((0.25, 0.0, 0.0), (0, 0, 1)),
    "stern": ((-0.25, 0.0, 0.0), (0, 0, -1)),
}
"""Place in m and direction of each thruster, body frame."""
LIMITS_N = {"left": (-20.0, 30.0), "bow": (-25.0, 25.0)}
"""Range of a thruster's command where it is not -40 to 40 N."""


def mjcf(thrusters: dict[str, Any]) -> str:
    """A neutral ellipsoid of 20.9 kg in fresh water."""
    sites = [f'<site name="{name}" pos="{_text(place)}"/>' for name, (place, _) in thrusters.items()]
    motors = [
        f'<general name="{name}" site="{name}" gear="{_text(direction)} 0 0 0" ctrllimited="true"'
        f' ctrlrange="{_text(LIMITS_N.get(name, (-40.0, 40.0)))}"/>'
        for name, (_, direction) in thrusters.items()
    ]
    return f"""<mujoco>
      <option timestep="{STEP_S}" integrator="RK4" density="1000" viscosity="0.0013"/>
      <worldbody><body name="rov" gravcomp="1">
        <freejoint/>
        <inertial pos="0 0 -0.02" mass="20.9" diaginertia="0.4 0.7 0.8"/>
        <geom type="ellipsoid" size="0.25 0.2 0.1" mass="0" contype="0" conaffinity="0"
              fluidshape="ellipsoid" fluidcoef="0.5 0.1 0.5 0.5 0"/>
        {"".join(sites)}
      </body></worldbody>
      <actuator>{"".join(motors)}</actuator>
    </mujoco>"""


def _text(numbers: tuple[float, ...]) -> str:
    return " ".join(map(str, numbers))


class RovSpec(VehicleTable):
    """A vehicle for inspection."""

    kind: Literal["rov"] = "rov"


class Rov(Vehicle):
    """Six thrusters, as few as control along six axes needs."""

    name: ClassVar[str] = "rov"
    table: ClassVar[type[VehicleTable]] = RovSpec
    summary: ClassVar[str] = "neutral ellipsoid with six thrusters"
    noun: ClassVar[str] = "an ROV"
    abilities: ClassVar[frozenset[Ability]] = frozenset({Ability.TRAVEL, Ability.TILT})
    model_file: ClassVar[str] = ""
    body: ClassVar[str] = "rov"
    motors: ClassVar[int] = 6
    memory_size: ClassVar[int] = MEMORY_SIZE
    control = staticmethod(follow)

    def model(self) -> mujoco.MjModel:
        return mujoco.MjModel.from_xml_string(mjcf(THRUSTERS))

    def place(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        mujoco.mj_resetData(model, data)

    def gains(self, model: mujoco.MjModel, phase: PhaseBase) -> Array:
        return tracking_gains(model, phase.powered)

    def added_mass(self, model: mujoco.MjModel) -> Array:
        return added_mass(model)

    def currents_A(self, ctrl: Array) -> Array:
        return np.abs(ctrl)

    def kinematics(self, model: mujoco.MjModel, log: StateLog) -> Kinematics:
        return free_body_kinematics(log)


def flown(table: dict[str, Any]) -> tuple[PhaseBase, Array, StateLog]:
    """The phase, its reference (n, 18) and the log of every step, from rest at the origin."""
    phase: PhaseBase = TypeAdapter(Phase).validate_python(table)
    rov = Rov(RovSpec())
    model = rov.model()
    data = mujoco.MjData(model)
    rov.place(model, data)
    reference = phase.reference(Start((0.0, 0.0, 0.0), 0.0), STEP_S * np.arange(round(phase.duration_s / STEP_S)))
    log = log_of(model, len(reference))
    track = ReferenceTrack(reference, np.zeros((len(reference), 3)), rov.gains(model, phase), np.zeros(rov.memory_size))
    advance(rov.control, plant_of(model, data, rov.body, rov.added_mass(model)), track, log)
    return phase, reference, log


TILT = {"roll_amplitude_deg": 15, "pitch_amplitude_deg": 10}


@pytest.mark.parametrize(
    "table",
    [
        {"kind": "spiral", "radius_m": 5, "turn_rate_deg_s": 4, "vertical_speed_m_s": -0.05, "duration_s": 90} | TILT,
        {"kind": "comb", "line_length_m": 20, "line_spacing_m": 6, "lines": 3, "speed_m_s": 0.5},
    ],
    ids=["tilting spiral", "comb"],
)
def test_follows_a_path(table: dict[str, Any]) -> None:
    phase, reference, log = flown(table)
    settled = STEP_S * np.arange(len(reference)) > phase.settle_s
    apart_m = np.linalg.norm(log.qpos[:, :3] - reference[:, :3], axis=1)[settled]
    wanted = Rotation.from_euler("ZYX", reference[:, 9:12])
    turned = wanted.inv() * Rotation.from_quat(log.qpos[:, 3:], scalar_first=True)
    assert apart_m.max() < 0.05
    assert np.degrees(turned.magnitude()[settled].max()) < 1.0
    assert np.ptp(log.qpos[:, 0]) > 9


def test_the_thrusts_give_the_wrench_at_their_places() -> None:
    """B T = tau, B of cross products: column (direction, place x direction)."""
    B = np.array([np.concatenate([d, np.cross(p, d)]) for p, d in THRUSTERS.values()], dtype=float).T
    model = Rov(RovSpec()).model()
    memory, ctrl, row = np.zeros(MEMORY_SIZE), np.zeros(6), np.zeros(18)
    row[:3], row[9:12] = (0.3, -0.2, 0.1), (0.1, -0.05, 0.02)
    follow(np.array([0.0, 0, 0, 1, 0, 0, 0]), np.zeros(6), row, tracking_gains(model, True), memory, ctrl)
    np.testing.assert_allclose(B @ ctrl, memory[-6:], atol=1e-9)


def test_each_thruster_keeps_its_own_limit() -> None:
    """The smaller end of the range; all thrusts are scaled together, so the direction of the wrench stays."""
    model = Rov(RovSpec()).model()
    gains, free = tracking_gains(model, True), Rov(RovSpec()).model()
    free.actuator_ctrllimited[:] = 0
    limits_N = np.array([min(abs(end) for end in LIMITS_N.get(name, (-40.0, 40.0))) for name in THRUSTERS])
    for x_m, z_m in ((60.0, 0.0), (0.0, 60.0), (40.0, 40.0)):
        row, limited, wide = np.zeros(18), np.zeros(6), np.zeros(6)
        row[:3] = x_m, 0.0, z_m
        row[6:9] = 10.0 * row[:3] / np.linalg.norm(row[:3])
        for some, ctrl in ((gains, limited), (tracking_gains(free, True), wide)):
            follow(np.array([0.0, 0, 0, 1, 0, 0, 0]), np.zeros(6), row, some, np.zeros(MEMORY_SIZE), ctrl)
        assert (np.abs(limited) / limits_N).max() == pytest.approx(1.0)
        np.testing.assert_allclose(limited / np.linalg.norm(limited), wide / np.linalg.norm(wide), atol=1e-12)


def test_without_power_and_ballast_every_command_is_zero() -> None:
    ctrl = np.full(6, np.nan)
    gains = tracking_gains(Rov(RovSpec()).model(), False)
    follow(np.array([0.0, 0, 0, 1, 0, 0, 0]), np.ones(6), np.ones(18), gains, np.ones(MEMORY_SIZE), ctrl)
    np.testing.assert_array_equal(ctrl, 0.0)


def test_thrusters_that_leave_an_axis_out_are_refused_by_name() -> None:
    model = mujoco.MjModel.from_xml_string(mjcf({name: THRUSTERS[name] for name in list(THRUSTERS)[:4]}))
    with pytest.raises(ValueError, match=r"4 thrusters give no independent .*heave, .*pitch"):
        tracking_gains(model, True)
