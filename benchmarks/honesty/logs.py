"""Simulated logs with one disturbance each, written as text; the truth is known, nothing of the product makes them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.honesty.motion import GRAVITY_M_S2, LARGEST_HOLE_DEG, Course, largest_hole_deg, rocking, tumbling
from scenarios.arrays import Array

SEED = 31_000_000
"""First seed of the bench; no test uses seeds near."""
INTEGER = 32_768


@dataclass(frozen=True)
class Log:
    """A log: header and cells (n, k), with the Earth's strength F and the offset (3,) that made it, nT."""

    disturbance: str
    header: tuple[str, ...]
    cells: Array
    strength_nT: float
    offset_nT: Array
    digits: tuple[int, ...]

    def text(self) -> str:
        """Return the log as comma-separated text."""
        form = ",".join(f"%.{digits}f" for digits in self.digits)
        return "\n".join([",".join(self.header), *(form % tuple(row) for row in self.cells)]) + "\n"


@dataclass(frozen=True)
class Plain:
    """A sound magnetometer on a course: m = S h + b + noise, nT."""

    rng: np.random.Generator
    course: Course
    strength_nT: float
    soft: Array
    offset_nT: Array
    noise_nT: float
    mag_nT: Array


Disturb = Callable[[Plain], tuple[Plain, Array | None]]
"""From a sound recording to the disturbed one, and the times (n,) as logged where they are not the true ones."""


def log_of(disturbance: str, seed: int) -> Log:
    """Return the log of a disturbance and a seed."""
    plain, time_s = DISTURBANCES[disturbance](_plain(disturbance, seed))
    times = plain.course.time_s if time_s is None else time_s
    axes = ("x", "y", "z")
    header, columns = ["time_s", *(f"mag_{a}_nT" for a in axes)], [times[:, None], plain.mag_nT]
    digits = [3, 1, 1, 1]
    if disturbance in WITH_IMU:
        rng, course = plain.rng, plain.course
        gyro = course.rate_rad_s + rng.normal(0, 0.003, course.rate_rad_s.shape)
        accel = course.seen(np.array([0, 0, GRAVITY_M_S2])) + rng.normal(0, 0.05, gyro.shape)
        header += [*(f"gyro_{a}_rad_s" for a in axes), *(f"accel_{a}_m_s2" for a in axes)]
        columns, digits = [*columns, gyro, accel], [*digits, *[5] * 3, *[4] * 3]
    if disturbance == "wrong unit":
        digits[1:4] = [4] * 3
    return Log(disturbance, tuple(header), np.hstack(columns), plain.strength_nT, plain.offset_nT, tuple(digits))


def _plain(disturbance: str, seed: int) -> Plain:
    rng = np.random.default_rng([SEED, seed])
    strength = rng.uniform(25_000, 62_000)
    dip = np.radians(rng.uniform(20, 75))
    world = strength * np.array([0, np.cos(dip), -np.sin(dip)])
    rate_hz = float(rng.choice([10, 20, 50]))
    rows = int(rng.uniform(60, 120) * rate_hz)
    course = rocking(rng, rows, rate_hz, rng.uniform(10, 30)) if disturbance == "half a sphere" else None
    while course is None:
        tried = tumbling(rng, rows, rate_hz)
        course = tried if largest_hole_deg(tried.seen(world) / strength) < LARGEST_HOLE_DEG else None
    lean = rng.normal(0, 0.02, (3, 3))
    soft = np.eye(3) + np.diag(rng.normal(0, 0.04, 3)) + (lean + lean.T) / 2
    offset = rng.uniform(-0.5, 0.5, 3) * strength
    noise = strength * rng.uniform(0.0005, 0.004)
    mag = course.seen(world) @ soft.T + offset + rng.normal(0, noise, (rows, 3))
    return Plain(rng, course, strength, soft, offset, noise, mag)


def _with(plain: Plain, mag_nT: Array) -> tuple[Plain, None]:
    return replace(plain, mag_nT=mag_nT), None


def _slow(plain: Plain, length_s: float) -> Array:
    """Return a smooth course (n,) of unit rms."""
    time_s = plain.course.time_s
    phase = plain.rng.uniform(0, 2 * np.pi, 6)
    wave = sum(
        np.sin(2 * np.pi * time_s / (length_s * scale) + p)
        for scale, p in zip((1, 1.6, 2.3, 3.1, 4.7, 6), phase, strict=True)
    )
    return np.asarray(wave / np.std(wave))


def _sound(plain: Plain) -> tuple[Plain, None]:
    return plain, None


def _stuck(plain: Plain) -> tuple[Plain, None]:
    mag, rows, rng = plain.mag_nT.copy(), len(plain.mag_nT), plain.rng
    first, axis = int(rng.uniform(0.2, 0.7) * rows), int(rng.integers(3))
    last = rows if rng.random() < 0.5 else first + int(rng.uniform(0.1, 0.3) * rows)
    mag[first:last, axis] = mag[first, axis]
    return _with(plain, mag)


def _sentinel(plain: Plain) -> tuple[Plain, None]:
    mag, rng = plain.mag_nT.copy(), plain.rng
    at = rng.choice(len(mag), max(2, int(rng.uniform(0.002, 0.03) * len(mag))), replace=False)
    value = rng.choice([99_999.0, -99_999.0, 99_999.9, 0.0, -999_999.0])
    mag[at] = value
    return _with(plain, mag)


def _saturated(plain: Plain) -> tuple[Plain, None]:
    both = plain.rng.random() < 0.7
    size = np.abs(plain.mag_nT) if both else plain.mag_nT
    level = np.quantile(size.max(axis=1), plain.rng.uniform(0.75, 0.97))
    return _with(plain, np.clip(plain.mag_nT, -level if both else None, level))


def _wrapped(plain: Plain) -> tuple[Plain, None]:
    most = np.quantile(np.abs(plain.mag_nT).max(axis=1), plain.rng.uniform(0.8, 0.97))
    counts = np.rint(plain.mag_nT * INTEGER / most)
    return _with(plain, ((counts + INTEGER) % (2 * INTEGER) - INTEGER) * most / INTEGER)


def _mirrored(plain: Plain) -> tuple[Plain, None]:
    mag = plain.mag_nT[:, [1, 0, 2]] if plain.rng.random() < 0.5 else plain.mag_nT * [1, 1, -1]
    return _with(plain, mag)


def _wrong_unit(plain: Plain) -> tuple[Plain, None]:
    return _with(plain, plain.mag_nT / plain.rng.choice([1e3, 1e5, 1e2]))


def _wild(plain: Plain) -> tuple[Plain, None]:
    mag, rng = plain.mag_nT.copy(), plain.rng
    at = rng.random(len(mag)) < 0.01
    mag[at] += rng.normal(0, rng.uniform(0.05, 0.4) * plain.strength_nT, (int(at.sum()), 3))
    return _with(plain, mag)


def _uneven_room(plain: Plain) -> tuple[Plain, None]:
    change = plain.rng.uniform(0.005, 0.03) * _slow(plain, plain.rng.uniform(5, 20))
    h = (plain.mag_nT - plain.offset_nT) * (1 + change[:, None])
    return _with(plain, h + plain.offset_nT)


def _characteristic(plain: Plain) -> tuple[Plain, None]:
    share = plain.rng.uniform(0.02, 0.06) * plain.rng.choice([-1, 1])
    full = np.abs(plain.mag_nT).max()
    return _with(plain, plain.mag_nT - share * full * (plain.mag_nT / full) ** 3)


def _clock(plain: Plain) -> tuple[Plain, Array]:
    time_s, rng = plain.course.time_s.copy(), plain.rng
    at, kind = int(rng.uniform(0.2, 0.8) * len(time_s)), rng.integers(3)
    if kind == 0:
        time_s[at:] -= rng.uniform(2, 20)
    elif kind == 1:
        time_s[at:] += rng.uniform(1000, 5000)
    else:
        time_s = np.floor(time_s)
    return plain, time_s


def _held(plain: Plain) -> tuple[Plain, None]:
    every = int(plain.rng.integers(3, 9))
    return _with(plain, plain.mag_nT[np.arange(len(plain.mag_nT)) // every * every])


def _flicker(plain: Plain) -> tuple[Plain, None]:
    """Noise of density 1 / f, as large as three to ten times the white noise."""
    rows = len(plain.mag_nT)
    spectrum = plain.rng.normal(size=(rows // 2 + 1, 3)) + 1j * plain.rng.normal(size=(rows // 2 + 1, 3))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))[:, None]
    spectrum[0] = 0
    noise = np.fft.irfft(spectrum, rows, axis=0)
    return _with(plain, plain.mag_nT + plain.rng.uniform(3, 10) * plain.noise_nT * noise / noise.std())


DISTURBANCES: dict[str, Disturb] = {
    "sound": _sound,
    "stuck axis": _stuck,
    "sentinel": _sentinel,
    "saturation": _saturated,
    "wrap": _wrapped,
    "mirrored axes": _mirrored,
    "wrong unit": _wrong_unit,
    "wild values": _wild,
    "uneven room": _uneven_room,
    "characteristic": _characteristic,
    "half a sphere": _sound,
    "clock": _clock,
    "held rows": _held,
    "short flicker": _flicker,
}
WITH_IMU = ("mirrored axes",)
"""Disturbances of logs with gyro and accelerometer."""
