"""Simulated logs with known heading error: several disturbances at a time, by numpy alone."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from benchmarks.assessment.level_truth import LevelTruth, level_field_nT
from benchmarks.honesty.motion import GRAVITY_M_S2, Course, rocking, tumbling
from calib import Calibration, Reference
from recordings import Recording
from scenarios.arrays import Array

TUNING, SCORING = 32_000_000, 33_000_000
"""First seeds: of the logs that the statistics were chosen on, and of the final figures."""
MOTIONS = ("tumble", "rocking", "steep rocking", "poses")
"""Motions: all attitudes; turns with tilts of 15 to 35 degrees, of 40 to 80; and attitudes held for a while."""
DISTURBANCES = ("soft iron", "flicker", "room", "motors", "temperature", "strength", "characteristic")
SHARE = 0.25
"""Probability of each disturbance in a log."""
KNOWS_DIP = 0.5
"""Probability that a log's field vector is stated; else the error is taken for the dip that is assumed."""


@dataclass(frozen=True, eq=False)
class SimulatedLog:
    """A recording and what made it: m = s - c s^3, s = S h + b, b the mean over the log.

    world_nT : the field (east, north, up). stated_nT : the strength as the user states it. driven_nT : field (n, 3) of
    motors and temperature, less the mean.
    """

    recording: Recording
    soft: Array
    offset_nT: Array
    cubic_nT2: float
    world_nT: Array
    stated_nT: float
    motion: str
    disturbances: tuple[str, ...]
    driven_nT: Array
    knows_vector: bool

    def level(self, dip_rad: float | None = None) -> LevelTruth:
        """Return the sensor's truth in level flight, at the log's own dip or at another."""
        strength = float(np.linalg.norm(self.world_nT))
        dip = float(np.arcsin(-self.world_nT[2] / strength)) if dip_rad is None else dip_rad
        linear = level_field_nT(strength, dip) @ self.soft.T + self.offset_nT
        return LevelTruth(linear - self.cubic_nT2 * linear**3, self.soft, self.driven_nT)

    def heading_rms_deg(self, fit: Calibration, dip_rad: float | None = None) -> float:
        """Return the rms heading error of a calibration in level flight, yaw misalignment removed."""
        return self.level(dip_rad).heading_rms_deg(fit, self.recording, turned=False)

    @property
    def reference(self) -> Reference:
        """Return the reference as stated: the field vector of some logs, the strength of the rest."""
        if not self.knows_vector:
            return Reference(self.stated_nT)
        scale = self.stated_nT / float(np.linalg.norm(self.world_nT))
        east, north, up = (scale * self.world_nT).tolist()
        return Reference.of_vector((east, north, up))


@dataclass
class _Draft:
    """A log in the making: a field h (n, 3) and additions to the measurement (n, 3), nT."""

    rng: np.random.Generator
    course: Course
    h: Array
    soft: Array
    offset_nT: Array
    noise_nT: float
    added: Array
    driven: Array
    cubic_nT2: float = 0.0
    channels: dict[str, Array] = field(default_factory=dict)
    temperature: Array | None = None
    current: Array | None = None


def log_of(seed: int, only: str | None = None, bank: int = TUNING) -> SimulatedLog:
    """Return the log of a seed; `only`: with this disturbance alone, or with none for ""."""
    rng = np.random.default_rng([bank, seed])
    motion = str(rng.choice(MOTIONS, p=(0.45, 0.2, 0.2, 0.15)))
    world = _world(rng)
    draft = _draft(rng, motion, world)
    drawn = tuple(name for name in DISTURBANCES if rng.random() < SHARE)
    chosen = drawn if only is None else tuple(name for name in DISTURBANCES if name == only)
    for name in chosen:
        DISTURB[name](draft)
    knows_vector = bool(np.random.default_rng([bank, seed, 1]).random() < KNOWS_DIP)
    return _finished(draft, world, motion, chosen, knows_vector)


def _world(rng: np.random.Generator) -> Array:
    """Return a field (east, north, up) of a place between 10 and 78 degrees of dip."""
    strength, dip = rng.uniform(25_000, 62_000), np.radians(rng.uniform(10, 78))
    declination = rng.uniform(-0.3, 0.3)
    level = strength * np.cos(dip)
    return np.array([level * np.sin(declination), level * np.cos(declination), -strength * np.sin(dip)])


def _draft(rng: np.random.Generator, motion: str, world: Array) -> _Draft:
    """Return a sound sensor in a motion; half of the sensors have hardly any soft iron."""
    rate_hz = float(rng.choice([5, 10, 20, 50]))
    course = _course(rng, motion, int(rng.uniform(60, 240) * rate_hz), rate_hz)
    lean, size = rng.normal(0, 1, (3, 3)), float(rng.choice([0.0005, 0.02]))
    soft = np.eye(3) * rng.uniform(0.9, 1.1) + size * (lean + lean.T) / 2
    strength = float(np.linalg.norm(world))
    offset, noise = rng.uniform(-0.5, 0.5, 3) * strength, strength * 10 ** rng.uniform(-3.7, -2.2)
    h = course.seen(world)
    return _Draft(rng, course, h, soft, offset, noise, np.zeros_like(h), np.zeros_like(h))


def _course(rng: np.random.Generator, motion: str, rows: int, rate_hz: float) -> Course:
    if motion == "tumble":
        return tumbling(rng, rows, rate_hz)
    if motion == "poses":
        course = tumbling(rng, rows, rate_hz)
        held = (np.arange(rows) // max(1, rows // int(rng.integers(16, 60)))) * max(1, rows // 40) % rows
        return Course(course.time_s, course.R_bw[held], np.zeros_like(course.rate_rad_s))
    low, high = (15, 35) if motion == "rocking" else (40, 80)
    return rocking(rng, rows, rate_hz, rng.uniform(low, high))


def _finished(draft: _Draft, world: Array, motion: str, chosen: tuple[str, ...], knows_vector: bool) -> SimulatedLog:
    rng, course = draft.rng, draft.course
    added = draft.added + draft.driven
    linear = draft.h @ draft.soft.T + draft.offset_nT + added
    mag = linear - draft.cubic_nT2 * linear**3 + rng.normal(0, draft.noise_nT, linear.shape)
    accel = course.seen(np.array([0, 0, GRAVITY_M_S2])) + rng.normal(0, 0.05, mag.shape)
    recording = Recording(
        course.time_s,
        mag,
        accel_m_s2=accel if rng.random() < 0.5 else None,
        temperature_degC=draft.temperature,
        current_A=draft.current,
        channels=draft.channels,
    )
    strength = float(np.linalg.norm(world))
    stated = strength * (1 + rng.normal(0, 0.003)) if "strength" in chosen else strength
    offset_nT, driven = draft.offset_nT + added.mean(axis=0), draft.driven - draft.driven.mean(axis=0)
    return SimulatedLog(
        recording, draft.soft, offset_nT, draft.cubic_nT2, world, stated, motion, chosen, driven, knows_vector
    )


def _slow(draft: _Draft, length_s: float) -> Array:
    """Return a smooth course (n,) of unit rms."""
    phase = draft.rng.uniform(0, 2 * np.pi, 6)
    scales = (1, 1.6, 2.3, 3.1, 4.7, 6)
    time_s = draft.course.time_s
    wave = sum(np.sin(2 * np.pi * time_s / (length_s * k) + p) for k, p in zip(scales, phase, strict=True))
    return np.asarray(wave / np.std(wave))


def _flicker(draft: _Draft) -> None:
    rows, rng = len(draft.h), draft.rng
    spectrum = rng.normal(size=(rows // 2 + 1, 3)) + 1j * rng.normal(size=(rows // 2 + 1, 3))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))[:, None]
    spectrum[0] = 0
    noise = np.fft.irfft(spectrum, rows, axis=0)
    draft.added += rng.uniform(0.5, 4) * draft.noise_nT * noise / noise.std()


def _room(draft: _Draft) -> None:
    change = draft.rng.uniform(0.001, 0.01) * _slow(draft, draft.rng.uniform(5, 20))
    draft.h = draft.h * (1 + change[:, None])


def _motors(draft: _Draft) -> None:
    rng = draft.rng
    current = 8 + 4 * np.clip(_slow(draft, rng.uniform(3, 15)), -1.9, 3)
    draft.current = current[:, None] + rng.normal(0, 0.1, (len(current), 1))
    draft.driven += np.outer(current, rng.normal(0, 1, 3)) * np.linalg.norm(draft.h[0]) * rng.uniform(1e-4, 8e-4)


def _temperature(draft: _Draft) -> None:
    rng, rows = draft.rng, len(draft.h)
    draft.temperature = 20 + rng.uniform(2, 10) * (1 - np.exp(-3 * np.arange(rows) / rows)) + rng.normal(0, 0.02, rows)
    slope = rng.normal(0, 1, 3) * np.linalg.norm(draft.h[0]) * rng.uniform(1e-4, 6e-4)
    draft.driven += np.outer(draft.temperature, slope)


def _strength(draft: _Draft) -> None:
    """The stated strength is wrong: see `_finished`."""


def _characteristic(draft: _Draft) -> None:
    full = np.abs(draft.h @ draft.soft.T + draft.offset_nT).max()
    draft.cubic_nT2 = draft.rng.uniform(0.001, 0.01) * draft.rng.choice([-1, 1]) / full**2


def _soft_iron(draft: _Draft) -> None:
    lean = draft.rng.normal(0, 0.08, (3, 3))
    draft.soft = draft.soft + (lean + lean.T) / 2


DISTURB = {
    "flicker": _flicker,
    "room": _room,
    "motors": _motors,
    "temperature": _temperature,
    "strength": _strength,
    "characteristic": _characteristic,
    "soft iron": _soft_iron,
}
"""What makes each disturbance."""
