"""Error rates of `magbench recheck`: how often "valid" is wrong, and how often a change is found.

Each log is of another instrument: soft iron, offset, motion, noise (white, and a part that wanders), converter steps,
and a motor's field. Kinds of log follow each other by number; every log has a motor's current beside.

python -m benchmarks.recheck [LOGS] [SEED]
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, Status, get
from recordings import Recording
from scenarios.arrays import Array
from validation.rechecking.parts import MOTORS, SCALE
from validation.rechecking.recheck import TOLERANCE_DEG, Recheck, recheck

FIELD_ENU_NT = np.array([0.0, 20_000.0, -45_000.0])
STRENGTH = Reference(float(np.linalg.norm(FIELD_ENU_NT)))
LOGS, SEED = 1000, 60_000
TILTS_DEG = (0.0, -3.0, 3.0)
KINDS = ("sphere", "spiral", "level boat", "short", "wandering noise", "motors")
"""Kinds of log: swings of 50 to 80 deg; turns at a pitch of 20 to 40 deg down and up; swell of 2 to 6 deg; 200 to 300
samples; noise of which half or more wanders; a motor's field that the old calibration has not."""
CALMER = 30.0
"""Time constant of noise that wanders, in samples."""
STEPS = 8
"""Secant steps to a change of the tolerance: the heading error is nearly linear in the change."""


@dataclass(frozen=True, eq=False)
class Instrument:
    """An instrument and its motion: m = S h + b + k I + noise."""

    kind: str
    soft: Array
    offset_nT: Array
    motor_nT_A: Array
    noise_nT: float
    wandering: float
    step_nT: float
    samples: int
    tilt_deg: float

    @classmethod
    def drawn(cls, kind: str, rng: np.random.Generator) -> Instrument:
        """Return a random instrument."""
        tilts = {"spiral": (20.0, 40.0), "level boat": (2.0, 6.0)}.get(kind, (50.0, 80.0))
        return cls(
            kind,
            np.eye(3) + 0.05 * rng.standard_normal((3, 3)),
            5000.0 * rng.standard_normal(3),
            20.0 * rng.standard_normal(3) * (kind == "motors"),
            float(np.exp(rng.uniform(np.log(5.0), np.log(300.0)))),
            float(rng.uniform(0.5, 0.9) if kind == "wandering noise" else rng.uniform(0.0, 0.5)),
            float(rng.choice([0.0, 15.0, 150.0])),
            int(rng.integers(200, 300) if kind == "short" else rng.integers(300, 1500)),
            float(rng.uniform(*tilts)),
        )

    def changed(self, offset_nT: Array, soft: Array) -> Instrument:
        """Return the instrument with another offset, and soft iron (1 + soft) on its own."""
        return replace(self, soft=self.soft @ (np.eye(3) + soft), offset_nT=self.offset_nT + offset_nT)

    @property
    def exact(self) -> Calibration:
        """Return the calibration without an error, of the static field."""
        status, matrix = Status("ok"), np.asarray(np.linalg.inv(self.soft), dtype=np.float64)
        return Calibration(name="exact", status=status, offset_nT=self.offset_nT, matrix=matrix)

    def log(self, rng: np.random.Generator) -> Recording:
        """Return a log of the kind's motion."""
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
        """Return the attitudes, world to body: turns of 20 s with the kind's pitch and roll."""
        radians = np.radians(self.tilt_deg)
        phases = rng.uniform(0, 2 * np.pi, 2)
        swings = [radians * np.sin(2 * np.pi * t / p + q) for p, q in zip((13.0, 31.0), phases, strict=True)]
        if self.kind == "spiral":
            swings = [np.where(t < t[-1] / 2, radians, -radians), 0.1 * swings[1]]
        return Rotation.from_euler("ZYX", np.column_stack([2 * np.pi * t / 20.0, swings[0], 2 * swings[1]])).inv()

    def _noise(self, rng: np.random.Generator) -> Array:
        """Return noise of unit variance: white, and a part that wanders."""
        kept = np.exp(-1 / CALMER)
        kicks = np.sqrt(1 - kept**2) * rng.standard_normal((self.samples, 3))
        wander = lfilter([1.0], [1.0, -kept], kicks, axis=0)
        white = rng.standard_normal((self.samples, 3))
        return np.asarray(np.sqrt(1 - self.wandering) * white + np.sqrt(self.wandering) * wander)


def heading_error_deg(old: Calibration, old_is: Instrument, new: Instrument) -> float:
    """Return the largest change of the heading on a level survey, from the headings themselves."""
    yaw = np.arange(0.0, 360.0, 5.0)
    tilts = [(p, r) for p in TILTS_DEG for r in TILTS_DEG if 0.0 in (p, r)]
    angles = np.concatenate([np.column_stack([yaw, 0 * yaw + pitch, 0 * yaw + roll]) for pitch, roll in tilts])
    turn = Rotation.from_euler("ZYX", angles, degrees=True)
    before, after = (_heading(turn, old, one, turn.inv().apply(FIELD_ENU_NT)) for one in (old_is, new))
    return float(np.abs((after - before + 180) % 360 - 180).max())


def _heading(turn: Rotation, old: Calibration, one: Instrument, h: Array) -> Array:
    level = turn.apply((h @ one.soft.T + one.offset_nT - old.offset_nT) @ old.matrix.T)
    return np.asarray(np.degrees(np.arctan2(level[:, 0], level[:, 1])))


def at_tolerance(rng: np.random.Generator, now: Instrument) -> Instrument:
    """Return the instrument with a change of offset and soft iron that turns a heading by the tolerance, or by more."""
    offset_nT, soft = rng.standard_normal(3), rng.standard_normal((3, 3)) / 45_000.0 * (rng.random() < 0.5)
    soft = (soft + soft.T) / 2
    size = 100.0
    for _ in range(STEPS):
        size *= TOLERANCE_DEG / heading_error_deg(now.exact, now, now.changed(size * offset_nT, size * soft))
    return now.changed(size * offset_nT, size * soft)


def answers(seed: int) -> tuple[str, dict[str, Recheck]]:
    """Return the kind of log, and the answers on one instrument.

    unchanged, and an offset moved by what the answer on the unchanged log states to find : by an old calibration fitted
    to a log of its own; changed by the tolerance, and a motor's field : by the exact old calibration.
    """
    rng = np.random.default_rng(seed)
    now = Instrument.drawn(KINDS[seed % len(KINDS)], rng)
    quiet = replace(now, motor_nT_A=np.zeros(3))
    by_hand = replace(quiet, kind="sphere", samples=1000, tilt_deg=60.0)
    fitted = get("ellipsoid").fit(by_hand.log(rng), STRENGTH)
    found = {
        "unchanged": recheck(fitted, quiet.log(rng), STRENGTH),
        "changed by the tolerance": recheck(quiet.exact, at_tolerance(rng, quiet).log(rng), STRENGTH),
    }
    if now.motor_nT_A.any():
        return now.kind, found | {"a motor's field": recheck(quiet.exact, now.log(rng), STRENGTH)}
    axis = rng.standard_normal(3)
    moved = quiet.changed(found["unchanged"].found_nT * axis / np.linalg.norm(axis), np.zeros((3, 3)))
    return now.kind, found | {"offset moved by the stated size": recheck(fitted, moved.log(rng), STRENGTH)}


def main(logs: int = LOGS, seed: int = SEED) -> None:
    """Print how often each answer was given, by kind of log."""
    told: dict[tuple[str, str], Counter[str]] = {}
    for number in range(seed, seed + logs):
        kind, found = answers(number)
        for what, one in found.items():
            shown = {part.what for part in one.parts if part.significant and part.what != SCALE}
            words = [one.verdict, *(["a part shows"] if shown else []), *(["motors show"] if MOTORS in shown else [])]
            told.setdefault((what, kind), Counter()).update([*words, "logs"])
    for (what, kind), counts in sorted(told.items()):
        print(f"{what}; {kind}: {dict(counts)}")


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:3]))
