"""A flight for tests of readers: a tumbling body in the Earth's field, in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array

FIELD_ENU_NT = np.array([1_450.0, 20_900.0, -43_300.0])
"""East, north, up: the dip points down in the northern hemisphere."""
GRAVITY_M_S2 = 9.80665


@dataclass(frozen=True)
class Flight:
    """Attitude R(t) = Rz(yaw) Ry(pitch) Rx(roll), FLU to ENU, and what sensors measure at times t (n,)."""

    time_s: Array

    @cached_property
    def rotation(self) -> Rotation:
        """The attitude at all times."""
        return self._at(self.time_s)

    @staticmethod
    def _at(t: Array) -> Rotation:
        yaw, pitch, roll = 0.8 * t + 0.3, 0.7 * np.sin(0.45 * t), 1.1 * np.sin(0.62 * t + 0.4)
        return Rotation.from_euler("ZYX", np.column_stack([yaw, pitch, roll]))

    @cached_property
    def field_nT(self) -> Array:
        """The Earth's field in the body frame, (n, 3)."""
        return np.asarray(self.rotation.inv().apply(FIELD_ENU_NT))

    @cached_property
    def rate_rad_s(self) -> Array:
        """The body rate (n, 3), of the turn within 2 ms around each time."""
        h = 1e-3
        turn = self._at(self.time_s - h).inv() * self._at(self.time_s + h)
        return np.asarray(turn.as_rotvec() / (2 * h))

    @cached_property
    def specific_force_m_s2(self) -> Array:
        """The specific force of a body at rest, (n, 3): up."""
        return np.asarray(self.rotation.inv().apply([0.0, 0.0, GRAVITY_M_S2]))

    @cached_property
    def q(self) -> NDArray[np.float64]:
        """The attitude as quaternions w x y z, w >= 0, (n, 4)."""
        xyzw = self.rotation.as_quat(canonical=True)
        return np.asarray(xyzw[:, [3, 0, 1, 2]])


def assert_same_flight(table: dict[str, Array], tolerance_nT: float) -> None:
    """Attitude turns the field to the same ENU vector; the gyro turns the field as dm/dt = -w x m; up is up at rest."""
    m = np.column_stack([table[f"mag_{a}_nT"] for a in "xyz"])
    q = np.column_stack([table[f"att_q{a}"] for a in "xyzw"])
    enu = Rotation.from_quat(q).apply(m)
    np.testing.assert_allclose(enu, np.tile(FIELD_ENU_NT, (len(m), 1)), atol=tolerance_nT)
    up = Rotation.from_quat(q).apply(np.column_stack([table[f"accel_{a}_m_s2"] for a in "xyz"]))
    np.testing.assert_allclose(up, np.tile([0, 0, GRAVITY_M_S2], (len(m), 1)), atol=0.1)
    t = table["time_s"]
    gyro = np.column_stack([table[f"gyro_{a}_rad_s"] for a in "xyz"])
    change = (m[2:] - m[:-2]) / (t[2:] - t[:-2])[:, None]
    expected = -np.cross(gyro[1:-1], m[1:-1])
    assert np.median(np.linalg.norm(change - expected, axis=1)) < 0.05 * np.median(np.linalg.norm(expected, axis=1))
