"""Values with their first two time derivatives, which keep every reference's derivatives exact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array


@dataclass(frozen=True)
class Jet:
    """x(t), x'(t), x''(t) at n times, each (n,); sums, products and chains keep the derivatives exact."""

    x: Array
    dx: Array
    ddx: Array

    def __add__(self, other: Jet | Array | float) -> Jet:
        if isinstance(other, Jet):
            return Jet(self.x + other.x, self.dx + other.dx, self.ddx + other.ddx)
        return Jet(self.x + other, self.dx, self.ddx)

    def __mul__(self, other: Jet | Array | float) -> Jet:
        if isinstance(other, Jet):
            cross = self.ddx * other.x + 2.0 * self.dx * other.dx + self.x * other.ddx
            return Jet(self.x * other.x, self.dx * other.x + self.x * other.dx, cross)
        return Jet(self.x * other, self.dx * other, self.ddx * other)

    def __sub__(self, other: Jet) -> Jet:
        return self + other * -1.0

    def through(self, f: Array, df: Array, ddf: Array) -> Jet:
        """Return f(x(t)), given f, f', f'' at x: derivatives f' x' and f'' x'^2 + f' x''."""
        return Jet(f, df * self.dx, ddf * self.dx**2 + df * self.ddx)

    def sin(self) -> Jet:
        return self.through(np.sin(self.x), np.cos(self.x), -np.sin(self.x))

    def cos(self) -> Jet:
        return self.through(np.cos(self.x), -np.sin(self.x), -np.cos(self.x))


def constant(value: float, t_s: Array) -> Jet:
    """Return a constant."""
    return Jet(np.full_like(t_s, value), np.zeros_like(t_s), np.zeros_like(t_s))


def smoothstep(t_s: Array, duration_s: Array | float) -> Jet:
    """Return 10 u^3 - 15 u^4 + 6 u^5, u = t / duration: from 0 to 1, zero slope and curvature at both ends."""
    u = np.clip(t_s / duration_s, 0.0, 1.0)
    cube = u * u * u  # as products: the last bit of numpy's powers depends on the processor
    rate = 30.0 * u**2 * (1.0 - u) ** 2
    bend = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)
    return Jet(cube * (10.0 + u * (6.0 * u - 15.0)), rate / duration_s, bend / duration_s**2)


def run_up(t_s: Array, from_rate: float, to_rate: float, ramp_s: float) -> Jet:
    """Return the distance travelled while the rate changes by a smoothstep over ramp_s and then stays constant."""
    step = smoothstep(t_s, ramp_s)
    u = np.clip(t_s / ramp_s, 0.0, 1.0)
    fourth = u * u * u * u
    area = ramp_s * fourth * (2.5 + u * (u - 3.0)) + np.maximum(t_s - ramp_s, 0.0)
    gain = to_rate - from_rate
    return Jet(from_rate * t_s + gain * area, from_rate + gain * step.x, gain * step.dx)


def run(t_s: Array, from_rate: float, rate: float, ramp_s: float, brake_s: float) -> Jet:
    """Return `run_up`, braked to rest from the time brake_s on, within ramp_s."""
    return run_up(t_s, from_rate, rate, ramp_s) + run_up(t_s - brake_s, 0.0, -rate, ramp_s)


def pushed(t_s: Array, ramp_s: float) -> Jet:
    """Return the way from rest while the acceleration rises by a smoothstep over ramp_s from 0 to 1 and stays 1."""
    step = smoothstep(t_s, ramp_s)
    u = np.clip(t_s / ramp_s, 0.0, 1.0)
    fourth, after = u * u * u * u, np.maximum(t_s - ramp_s, 0.0)
    speed = ramp_s * fourth * (2.5 + u * (u - 3.0)) + after
    way = ramp_s**2 * fourth * u * (0.5 + u * (u / 7.0 - 0.5)) + 0.5 * after * (ramp_s + after)
    return Jet(way, speed, step.x)


def window(t_s: Array, duration_s: float, ramp_s: float) -> Jet:
    """Return 0 outside [0, duration_s], 1 inside, with smooth ramps of ramp_s at both ends."""
    out = smoothstep(duration_s - t_s, ramp_s)
    return smoothstep(t_s, ramp_s) * Jet(out.x, -out.dx, out.ddx)


def sine(t_s: Array, amplitude: float, period_s: float, phase_rad: float = 0.0) -> Jet:
    """Return amplitude sin(2 pi t / period_s + phase_rad)."""
    rate = np.full_like(t_s, 2.0 * np.pi / period_s)
    return Jet(rate * t_s + phase_rad, rate, np.zeros_like(t_s)).sin() * amplitude


def assemble(position: tuple[Jet, Jet, Jet], yaw: Jet, pitch: Jet, roll: Jet) -> Array:
    """Return the (n, 18) reference in the order of REFERENCE_COLUMNS."""
    angles = (yaw, pitch, roll)
    parts = [[j.x for j in p] + [j.dx for j in p] + [j.ddx for j in p] for p in (position, angles)]
    return np.column_stack(parts[0] + parts[1])
