"""Wrong answers about a magnetometer's axes: random motions, instruments and signed axis maps.

Run with ``python -m benchmarks.axes_alarms``; `validation/axes/policy.py` names the run beside its numbers.
Motions, rates and fields come from sums of sines and finite differences, not from the simulator.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from validation.axes.estimate import Axes, axes_of

MAPS = tuple(
    np.diag(signs) @ np.eye(3)[list(order)]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
)
"""All signed axis maps: the body's axes of a log are ``P m``."""
INSTRUMENTS = (("gyro",), ("accel",), ("gyro", "accel"), ("q",), ("gyro", "accel", "q"))
STRENGTH_NT, DIP_DEG, GRAVITY_M_S2 = 48_000.0, 64.0, 9.81
MOTIONS = ("tumble", "vehicle", "circles", "turntable", "still")


@dataclass(frozen=True)
class Conditions:
    """Motion and instruments of a trial.

    rate_rad_s : typical turning rate. tilt_deg : roll and pitch of a vehicle. noise_nT, hard (of the strength),
    soft (each element): magnetometer. late_s, bias_rad_s, gain : gyro. shaking_m_s2 : accelerations.
    """

    motion: str = "tumble"
    rows: int = 600
    rate_hz: float = 10.0
    rate_rad_s: float = 0.6
    tilt_deg: float = 20.0
    noise_nT: float = 150.0
    hard: float = 0.6
    soft: float = 0.05
    late_s: float = 0.0
    bias_rad_s: float = 0.005
    gain: float = 1.0
    shaking_m_s2: float = 0.2


@dataclass(frozen=True)
class Log:
    """Columns of a trial: field in the body's axes, gyro, specific force, and attitude."""

    time_s: Array
    mag_nT: Array
    gyro: Array
    accel: Array
    q: Array

    def axes(self, taken: Array, instruments: Sequence[str], *, down: bool | None = None) -> Axes:
        """Return the estimate of a log whose magnetometer has axes P^T m, P = taken (3, 3)."""
        columns = {name: getattr(self, name) for name in instruments}
        return axes_of(self.time_s, self.mag_nT @ taken, down=down, **columns)


def simulated(rng: np.random.Generator, given: Conditions) -> Log:
    """Return a log under conditions; the gyro's rates are differences of the attitude on a finer grid."""
    time_s = np.arange(given.rows) / given.rate_hz
    phases = rng.uniform(0, 2 * np.pi, (3, 4))
    attitude = _attitude(time_s, phases, given)
    shaking = np.stack([_swing(time_s, 1.0, rng.uniform(0, 2 * np.pi, 4)) for _ in range(3)], axis=1)
    accel = attitude.inv().apply([0.0, 0.0, GRAVITY_M_S2]) + given.shaking_m_s2 * shaking
    accel += rng.normal(0, 0.05, accel.shape)
    gyro = _gyro(rng, time_s, phases, given)
    return Log(time_s, _field_nT(rng, attitude, given), gyro, accel, attitude.as_quat(scalar_first=True))


def _gyro(rng: np.random.Generator, time_s: Array, phases: Array, given: Conditions) -> Array:
    step_s = 1e-3
    ahead, behind = (_attitude(time_s - given.late_s + sign * step_s, phases, given) for sign in (1, -1))
    rate_rad_s = (behind.inv() * ahead).as_rotvec() / (2 * step_s)
    measured = rate_rad_s * rng.normal(1, 0.02, 3) + given.bias_rad_s * rng.normal(0, 1, 3)
    return np.asarray(given.gain * (measured + rng.normal(0, 0.003, rate_rad_s.shape)))


def _field_nT(rng: np.random.Generator, attitude: Rotation, given: Conditions) -> Array:
    dip = np.radians(DIP_DEG)
    field = attitude.inv().apply(STRENGTH_NT * np.array([0.05, np.cos(dip), -np.sin(dip)]))
    hard = rng.normal(0, 1, 3)
    hard *= given.hard * STRENGTH_NT / np.linalg.norm(hard)
    soft = np.eye(3) + given.soft * rng.uniform(-1, 1, (3, 3))
    return np.asarray(field @ soft + hard + rng.normal(0, given.noise_nT, field.shape))


def _attitude(time_s: Array, phases: Array, given: Conditions) -> Rotation:
    rate, tilt = given.rate_rad_s, np.radians(given.tilt_deg)
    yaw, pitch, roll = (_swing(time_s, rate, own) for own in phases)
    if given.motion == "tumble":
        angles = [rate * time_s + yaw, 1.1 * np.sin(0.83 * rate * time_s + pitch), 0.7 * rate * time_s + roll]
    elif given.motion == "vehicle":
        angles = [2 * yaw, tilt * pitch, tilt * roll]
    elif given.motion == "circles":
        turn = rate * time_s + phases[0, 0]
        angles = [turn, tilt * np.sin(turn + phases[1, 0]), tilt * np.sin(turn + phases[2, 0])]
    elif given.motion == "turntable":
        angles = [rate * time_s + yaw, np.full_like(time_s, tilt), np.full_like(time_s, -tilt)]
    else:
        angles = [0.01 * yaw, 0.005 * pitch, 0.005 * roll]
    return Rotation.from_euler("ZYX", np.stack(angles, axis=1))


def _swing(time_s: Array, rate_rad_s: float, phases: Array) -> Array:
    """Return a sum (n,) of sines of incommensurable frequencies about a rate, of rms 1."""
    rates = rate_rad_s * np.array([0.43, 0.71, 1.0, 1.37])
    return np.asarray(np.sin(np.outer(time_s, rates) + phases).sum(axis=1) / np.sqrt(2))


def random_conditions(rng: np.random.Generator) -> Conditions:
    """Return conditions over the range of logs that people have, the harsh end included."""
    return Conditions(
        motion=str(rng.choice(MOTIONS, p=[0.35, 0.35, 0.15, 0.1, 0.05])),
        rows=int(rng.choice([300, 600, 2000])),
        rate_hz=float(rng.choice([8.0, 10.0, 25.0, 50.0])),
        rate_rad_s=float(10 ** rng.uniform(-1.5, 0.3)),
        tilt_deg=float(rng.choice([3.0, 10.0, 25.0])),
        noise_nT=float(10 ** rng.uniform(1, 3.3)),
        hard=float(rng.choice([0.0, 0.5, 2.0, 5.0])),
        soft=float(rng.choice([0.0, 0.05, 0.1, 0.2])),
        late_s=float(rng.choice([0.0, rng.uniform(-0.2, 0.2)])),
        bias_rad_s=float(rng.choice([0.0, 0.01, 0.05])),
        gain=float(rng.choice([1.0, 180 / np.pi, 1e3])),
        shaking_m_s2=float(rng.choice([0.0, 0.3, 1.0, 2.0])),
    )


def outcome(found: Axes, taken: Array) -> str:
    """Return how an estimate compares with the true map, up to the sign of all three axes.

    A field reversed in all three axes looks sound to every instrument; only place or heading tell.
    """
    among = any(abs(abs(np.sum(one * taken)) - 3) < 1e-6 for one in found.maps)
    if not found.turns:
        return "contradiction"
    if not among:
        return "wrong"
    return "named" if found.decided else "undetermined" if found.agree else "narrowed"


def main() -> None:
    """Print counts of each outcome for each set of instruments."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    counts: dict[tuple[str, ...], Counter[str]] = {instruments: Counter() for instruments in INSTRUMENTS}
    for seed in range(given.logs):
        rng = np.random.default_rng([given.seed, seed])
        log, taken = simulated(rng, random_conditions(rng)), MAPS[rng.integers(len(MAPS))]
        for instruments, counter in counts.items():
            counter[outcome(log.axes(taken, instruments), taken)] += 1
    for instruments, counter in counts.items():
        print(f"{'+'.join(instruments):16}", dict(counter.most_common()))


if __name__ == "__main__":
    main()
