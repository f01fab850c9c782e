"""The flight of the docs' native logs: a quadrotor, turned by hand before the start, then swaying while it yaws."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

import magbench
from scenarios.arrays import Array
from scenarios.spec import FieldSpec
from sim.field import earth_field_enu_nT

PLACE = (48.1, 11.6, 520.0)
"""Latitude and longitude in degrees, altitude in m."""
UTC = datetime.datetime(2025, 6, 1, 9, 30, tzinfo=datetime.UTC)
IRON_NT = np.array([5200.0, -3100.0, 7400.0])
SOFT = np.array([[1.06, 0.02, -0.015], [0.02, 0.96, 0.03], [-0.015, 0.03, 1.01]])
MOTOR_NT_A = np.array([28.0, -19.0, 46.0])
NOISE_NT = 60.0
START_S, STEP_S, CLIMB_S = 40.0, 0.04, 10.0
IDLE_A = 0.6
"""The battery's current while the motors stand still."""
HAND = ("phases.0.duration_s=70", "sampling.rate_hz=25")
SWAY = ("sampling.rate_hz=25", "phases.0.duration_s=10", "phases.1.duration_s=110", "phases.2.duration_s=5")
G_M_S2 = np.array([0.0, 0.0, 9.80665])
FRD_OF_FLU = np.diag([1.0, -1.0, -1.0])
NED_OF_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True)
class QuadrotorFlight:
    """The motion in knots: times (n,), attitude FLU to ENU, position (n, 3) in ENU, the battery's current (n,)."""

    knots_s: Array
    attitudes: Rotation
    position_m: Array
    knots_A: Array
    take_off_s: float

    @cached_property
    def time_s(self) -> Array:
        """The times of attitude and inertial unit."""
        return np.arange(self.knots_s[0] + STEP_S, self.knots_s[-1] - STEP_S, STEP_S)

    def attitude(self, time_s: Array) -> Rotation:
        """The attitude, along the shorter arc between the knots."""
        return Slerp(self.knots_s, self.attitudes)(time_s)

    def ned(self, time_s: Array) -> Array:
        """The attitude FRD to NED, quaternions w x y z (n, 4)."""
        turned = Rotation.from_matrix(NED_OF_ENU @ self.attitude(time_s).as_matrix() @ FRD_OF_FLU)
        return np.asarray(turned.as_quat(canonical=True)[:, [3, 0, 1, 2]])

    def rate_rad_s(self, time_s: Array) -> Array:
        """The body rate (n, 3), FLU."""
        before, after = self.attitude(time_s - STEP_S / 2), self.attitude(time_s + STEP_S / 2)
        return np.asarray((before.inv() * after).as_rotvec() / STEP_S)

    def enu_m(self, time_s: Array) -> Array:
        """The position (n, 3)."""
        return np.asarray(CubicSpline(self.knots_s, self.position_m)(time_s))

    def force_m_s2(self, time_s: Array) -> Array:
        """The specific force (n, 3), FLU: R^T (a + g)."""
        acceleration = CubicSpline(self.knots_s, self.position_m)(time_s, 2)
        return np.asarray(self.attitude(time_s).apply(acceleration + G_M_S2, inverse=True))

    def current_A(self, time_s: Array) -> Array:
        """The battery's current (n,)."""
        return np.interp(time_s, self.knots_s, self.knots_A)

    def measured_nT(self, time_s: Array, rng: np.random.Generator) -> Array:
        """The magnetometer's field (n, 3), FLU: m = S R^T h + b + k I + noise."""
        place = FieldSpec(latitude_deg=PLACE[0], longitude_deg=PLACE[1], altitude_m=PLACE[2], date=UTC.date())
        field = self.attitude(time_s).apply(earth_field_enu_nT(place), inverse=True)
        motors = self.current_A(time_s)[:, None] * MOTOR_NT_A
        return np.asarray(field @ SOFT.T + IRON_NT + motors + NOISE_NT * rng.standard_normal(field.shape))


def quadrotor_flight() -> QuadrotorFlight:
    """Simulate both parts and join them by a climb."""
    (by_hand, turned), (swaying, flown) = (
        magbench.simulate(name, overrides=list(keys)) for name, keys in (("tumble", HAND), ("quad-calibration", SWAY))
    )
    assert swaying.current_A is not None
    hand_s = START_S + by_hand.time_s - by_hand.time_s[0]
    flight_s = hand_s[-1] + CLIMB_S + swaying.time_s - swaying.time_s[0]
    xyzw = np.concatenate([turned.q, flown.q])[:, [1, 2, 3, 0]]
    ground_m = np.broadcast_to(flown.pos_enu_m[0] * [1.0, 1.0, 0.0], (len(hand_s), 3))
    drawn_A = np.concatenate([np.full(len(hand_s), IDLE_A), IDLE_A + swaying.current_A.sum(axis=1)])
    position_m = np.concatenate([ground_m, flown.pos_enu_m])
    times_s = np.concatenate([hand_s, flight_s])
    return QuadrotorFlight(times_s, Rotation.from_quat(xyzw), position_m, drawn_A, float(hand_s[-1]) + 1.0)
