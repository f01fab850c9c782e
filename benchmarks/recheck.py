"""Error rates of `magbench recheck`: how often "valid" is wrong, and how often a change is found.

Each log is of another instrument: soft iron, offset, motion, length, noise (white, wandering, flickering steps of a
converter) and a motor's field in a third of them; the old calibration is fitted to a log of its own, of equal motion.

python -m benchmarks.recheck [LOGS] [SEED]
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, get
from recordings import Recording
from scenarios.arrays import Array
from validation.rechecking.parts import OFFSET, SCALE
from validation.rechecking.recheck import TOLERANCE_DEG, Recheck, recheck

FIELD_ENU_NT = np.array([0.0, 20_000.0, -45_000.0])
STRENGTH = Reference(float(np.linalg.norm(FIELD_ENU_NT)))
LOGS, SEED = 1000, 20_000
TILTS_DEG = (0.0, -3.0, 3.0)


@dataclass(frozen=True, eq=False)
class Instrument:
    """An instrument and its motion: m = S h + b + k I + noise."""

    soft: Array
    offset_nT: Array
    motor_nT_A: Array
    noise_nT: float
    wandering: float
    step_nT: float
    samples: int
    tilt_deg: float

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Instrument:
        """Return a random instrument."""
        return cls(
            np.eye(3) + 0.05 * rng.standard_normal((3, 3)),
            5000.0 * rng.standard_normal(3),
            20.0 * rng.standard_normal(3) * (rng.random() < 1 / 3),
            float(np.exp(rng.uniform(np.log(5.0), np.log(300.0)))),
            float(rng.uniform(0.0, 0.5)),
            float(rng.choice([0.0, 15.0, 150.0])),
            int(rng.integers(200, 1500)),
            float(rng.uniform(10.0, 80.0)),
        )

    def changed(self, offset_nT: Array, soft: Array) -> Instrument:
        """Return the instrument with another offset, and soft iron (1 + soft) on its own."""
        return Instrument(self.soft @ (np.eye(3) + soft), self.offset_nT + offset_nT, *self._rest())

    def _rest(self) -> tuple[Array, float, float, float, int, float]:
        return self.motor_nT_A, self.noise_nT, self.wandering, self.step_nT, self.samples, self.tilt_deg

    def log(self, rng: np.random.Generator) -> Recording:
        """Return a log: a turn with swinging roll and pitch."""
        t = 0.1 * np.arange(self.samples, dtype=np.float64)
        turn = self._turn(t, rng)
        current_A = 5.0 + 5.0 * np.sin(2 * np.pi * t / 7.3 + rng.uniform(0, 6))
        mag = turn.apply(FIELD_ENU_NT) @ self.soft.T + self.offset_nT + np.outer(current_A, self.motor_nT_A)
        mag += self.noise_nT * self._noise(rng)
        if self.step_nT:
            mag = self.step_nT * np.round(mag / self.step_nT)
        up = turn.apply([0.0, 0.0, 9.81])
        return Recording(t, np.asarray(mag, dtype=np.float64), accel_m_s2=up, current_A=current_A[:, None])

    def _turn(self, t: Array, rng: np.random.Generator) -> Rotation:
        """Return the attitudes, world to body."""
        radians = np.radians(self.tilt_deg)
        phases = rng.uniform(0, 2 * np.pi, 2)
        swings = [radians * np.sin(2 * np.pi * t / p + q) for p, q in zip((13.0, 31.0), phases, strict=True)]
        return Rotation.from_euler("ZYX", np.column_stack([2 * np.pi * t / 20.0, swings[0], 2 * swings[1]])).inv()

    def _noise(self, rng: np.random.Generator) -> Array:
        """Return noise of unit variance: white, and a part that wanders within thirty samples."""
        wander = np.zeros((self.samples, 3))
        kicks = np.sqrt(1 - np.exp(-2 / 30)) * rng.standard_normal((self.samples, 3))
        for i in range(1, self.samples):
            wander[i] = np.exp(-1 / 30) * wander[i - 1] + kicks[i]
        white = rng.standard_normal((self.samples, 3))
        return np.asarray(np.sqrt(1 - self.wandering) * white + np.sqrt(self.wandering) * wander)


def heading_error_deg(old: Calibration, old_is: Instrument, new: Instrument) -> float:
    """Return the largest change of the heading on a level survey, from the headings themselves."""
    yaw = np.arange(0.0, 360.0, 5.0)
    worst = 0.0
    for pitch, roll in [(p, r) for p in TILTS_DEG for r in TILTS_DEG if 0.0 in (p, r)]:
        turn = Rotation.from_euler("ZYX", np.column_stack([yaw, 0 * yaw + pitch, 0 * yaw + roll]), degrees=True)
        h = turn.inv().apply(FIELD_ENU_NT)
        told = [_heading(turn, old, one, h) for one in (old_is, new)]
        worst = max(worst, float(np.abs((told[1] - told[0] + 180) % 360 - 180).max()))
    return worst


def _heading(turn: Rotation, old: Calibration, one: Instrument, h: Array) -> Array:
    level = turn.apply((h @ one.soft.T + one.offset_nT - old.offset_nT) @ old.matrix.T)
    return np.asarray(np.degrees(np.arctan2(level[:, 0], level[:, 1])))


def at_tolerance(rng: np.random.Generator, exact: Calibration, now: Instrument) -> Instrument:
    """Return the instrument with a change of offset and soft iron that turns a heading by the tolerance."""
    offset_nT, soft = rng.standard_normal(3), rng.standard_normal((3, 3)) / 45_000.0 * (rng.random() < 0.5)
    soft = (soft + soft.T) / 2
    low, high = 0.0, 1e5
    for _ in range(50):
        middle = (low + high) / 2
        much = heading_error_deg(exact, now, now.changed(middle * offset_nT, middle * soft)) > TOLERANCE_DEG
        low, high = (low, middle) if much else (middle, high)
    return now.changed(high * offset_nT, high * soft)


def answers(seed: int) -> dict[str, Recheck]:
    """Return the answers on one instrument: unchanged, changed by the tolerance, by two deviations, as stated.

    fitted : by an old calibration that is itself fitted to a log; motors : with a motor's field that it has not.
    """
    rng = np.random.default_rng(seed)
    now = Instrument.drawn(rng)
    quiet = Instrument(now.soft, now.offset_nT, np.zeros(3), *now._rest()[1:])
    clean = Instrument(now.soft, now.offset_nT, np.zeros(3), 0.0, 0.0, 0.0, 1500, 70.0)
    exact, fitted = (get("ellipsoid").fit(one.log(rng), STRENGTH) for one in (clean, quiet))
    found = {
        "unchanged": recheck(exact, quiet.log(rng), STRENGTH),
        "unchanged, fitted": recheck(fitted, quiet.log(rng), STRENGTH),
        "changed by the tolerance": recheck(exact, at_tolerance(rng, exact, quiet).log(rng), STRENGTH),
    }
    if now.motor_nT_A.any():
        found["motors"] = recheck(exact, now.log(rng), STRENGTH)
    return found | _of_sizes(found["unchanged"], exact, quiet, rng)


def _of_sizes(
    unchanged: Recheck, exact: Calibration, quiet: Instrument, rng: np.random.Generator
) -> dict[str, Recheck]:
    """Return the answers on an offset moved by two standard deviations, and by what the log states to find."""
    (offset,) = [part for part in unchanged.parts if part.what == OFFSET]
    sizes = {"two deviations": 2.0 * float(np.linalg.norm(offset.std)), "as stated": unchanged.found_nT}
    axes, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    moved = {what: size * axis for (what, size), axis in zip(sizes.items(), axes[:2], strict=True)}
    logs = {what: quiet.changed(offset_nT, np.zeros((3, 3))).log(rng) for what, offset_nT in moved.items()}
    return {what: recheck(exact, log, STRENGTH) for what, log in logs.items()}


def main(logs: int = LOGS, seed: int = SEED) -> None:
    """Print how often each answer was given."""
    told: dict[str, Counter[str]] = {}
    for number in range(logs):
        for what, one in answers(seed + number).items():
            shows = [part.what for part in one.parts if part.significant and part.what != SCALE]
            told.setdefault(what, Counter()).update([one.verdict, *(["significant"] if shows else []), "logs"])
    for what, counts in told.items():
        shares = {name: f"{100 * count / counts['logs']:.1f} %" for name, count in counts.items() if name != "logs"}
        print(f"{what} ({counts['logs']}): {shares}")


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:3]))
