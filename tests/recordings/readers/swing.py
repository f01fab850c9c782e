"""A sensor swung through all attitudes in a known field, for tests that write the flight in a format of their own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recordings import Recording, read_recording
from scenarios.errors import InputError

Array = NDArray[np.float64]
SOFT = np.array([[1.06, 0.03, -0.02], [0.03, 0.95, 0.04], [-0.02, 0.04, 1.01]])
HARD_NT = np.array([3000.0, -5000.0, 8000.0])
FIELD_ENU_NT = np.array([1500.0, 21_000.0, -43_000.0])
"""North of the equator: the field points down."""
DOWN = np.diag([1.0, -1.0, -1.0])
NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True)
class Swing:
    """Times (n,) s, the attitude of the body (FLU) in the world (ENU), and what sensors on the body measure (n, 3)."""

    time_s: Array
    attitude: Rotation
    rate_rad_s: Array

    @property
    def mag_nT(self) -> Array:
        """The measured field S R^T h + b."""
        return self.attitude.inv().apply(FIELD_ENU_NT) @ SOFT.T + HARD_NT

    @property
    def accel_m_s2(self) -> Array:
        """The specific force at rest: 9.81 up."""
        return self.attitude.inv().apply([0.0, 0.0, 9.81])

    @property
    def roll_pitch_yaw_deg(self) -> Array:
        """Aerospace angles of FRD in NED."""
        ned = Rotation.from_matrix(NED @ self.attitude.as_matrix() @ DOWN)
        return ned.as_euler("ZYX", degrees=True)[:, ::-1]

    def wxyz(self) -> Array:
        """The attitude as quaternions, FLU in ENU."""
        return self.attitude.as_quat(scalar_first=True)


def swing(samples: int = 400, step_s: float = 0.05) -> Swing:
    """Return a swing at rates of some tenths of a rad/s about all axes, integrated in small steps."""
    time_s = samples * step_s * np.linspace(0, 1, samples, endpoint=False)
    rates = np.column_stack([0.9 * np.sin(0.5 * time_s), 0.8 * np.cos(0.37 * time_s), 0.7 * np.sin(0.23 * time_s + 1)])
    now, found = Rotation.from_euler("ZYX", [0.4, 0.1, -0.2]), []
    for rate in rates:
        found.append(now)
        now = now * Rotation.from_rotvec(rate * step_s)
    return Swing(time_s, Rotation.concatenate(found), rates)


def assert_the_same_field(found: Recording, of: Swing, within_nT: float, scale: float = 1.0) -> None:
    """The field comes back, with its dip and in the body that the gyro and the attitude turn."""
    np.testing.assert_allclose(found.mag_nT * scale, of.mag_nT, atol=within_nT)
    clean = np.linalg.solve(SOFT, (found.mag_nT * scale - HARD_NT).T).T
    if found.att_q is not None:
        world = Rotation.from_quat(found.att_q, scalar_first=True).apply(clean)
        np.testing.assert_allclose(world, np.broadcast_to(FIELD_ENU_NT, world.shape), atol=3 * within_nT + 20)
    if found.gyro_rad_s is not None:
        rate = (found.gyro_rad_s[1:] + found.gyro_rad_s[:-1]) / 2
        seen = np.diff(clean, axis=0) / np.diff(found.time_s)[:, None]
        turning = -np.cross(rate, (clean[1:] + clean[:-1]) / 2)
        assert np.corrcoef(seen.ravel(), turning.ravel())[0, 1] > 0.95
    if found.accel_m_s2 is not None:
        np.testing.assert_allclose(found.accel_m_s2, of.accel_m_s2, atol=0.02)


def damaged(whole: bytes, count: int, seed: int = 1) -> Iterator[bytes]:
    """Yield versions of a file: cut off, with single bits turned, with some bytes or one in fifty replaced."""
    rng, plain = np.random.default_rng(seed), np.frombuffer(whole, np.uint8)
    for k in range(count):
        found = plain.copy()
        if k % 4 == 0:
            found = found[: rng.integers(1, len(found))]
        elif k % 4 == 1:
            found[rng.integers(len(found))] ^= np.uint8(1 << rng.integers(8))
        else:
            places = rng.integers(0, len(found), 4 if k % 4 == 2 else 1 + len(found) // 50)
            found[places] = rng.integers(0, 256, len(places))
        yield found.tobytes()


def assert_read_or_refused(path: Path, versions: Iterable[bytes]) -> None:
    """Every version is read, or refused in one line; another exception fails the test."""
    for version in versions:
        path.write_bytes(version)
        said = ""
        try:
            read_recording(path)
        except InputError as error:
            said = str(error)
        assert "\n" not in said
