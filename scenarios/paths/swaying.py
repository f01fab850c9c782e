"""Motion to and fro along a line by a push of constant strength against drag, so that the tilt is constant."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from scenarios.arrays import Array
from scenarios.paths.jet import Jet, smoothstep

STEP_S = 0.05
"""Step of the integration: a twelfth of the usual switch; steps a tenth as long differ by under a millimetre."""
ROUNDS, CLOSE_M_S = 60, 1e-9
"""Bisections for the speed at which a swing repeats, and their tolerance."""
LONGEST_HALVES = 8.0
"""Time, in units of half_s, within which every speed of a swing is reached; usually about one half_s is enough."""


@dataclass(frozen=True, eq=False)
class PushTransition:
    """A change of the push between two levels: way, speed and acceleration, state (n, 3), on a grid of step_s."""

    levels: tuple[float, float]
    step_s: float
    state: Array

    @property
    def lasts_s(self) -> float:
        """The length of the transition."""
        return self.step_s * (len(self.state) - 1)

    def at(self, t_s: Array) -> tuple[Array, Array]:
        """Return way and speed at times within the transition, by cubics between the points of the grid."""
        place = np.clip((t_s / self.step_s).astype(int), 0, len(self.state) - 2)
        u = t_s / self.step_s - place
        before, after = self.state[place], self.state[place + 1]
        way, speed = (
            _cubic(u, before[:, k], after[:, k], self.step_s * before[:, k + 1], self.step_s * after[:, k + 1])
            for k in (0, 1)
        )
        return way, speed


@dataclass(frozen=True)
class Swaying:
    """x'' = push p(t) - drag |x'| x',  p to and fro between + 1 and - 1, each change a smoothstep over switch_s.

    push_m_s2 : g tan(tilt). drag_1_m : the vehicle's drag coefficient over its mass. half_s : half the time of a tilt.
    The motion starts and ends at rest; in between every swing mirrors the previous swing.
    """

    push_m_s2: float
    drag_1_m: float
    half_s: float
    switch_s: float

    def lasts_s(self, times: int) -> float:
        """Return the length of a number of swings to and fro."""
        return sum(part.lasts_s for _, part in self._parts(times))

    def way(self, t_s: Array, times: int) -> Jet:
        """Return way, speed and acceleration at times (n,) since the start; at rest before and after."""
        parts = self._parts(times)
        ends = np.cumsum([part.lasts_s for _, part in parts])
        which = np.minimum(np.searchsorted(ends, t_s, side="right"), len(parts) - 1)
        found, here = np.zeros((3, len(t_s))), 0.0
        for number, (sign, part) in enumerate(parts):
            mine = which == number
            local = np.clip(t_s[mine] - (ends[number] - part.lasts_s), 0.0, part.lasts_s)
            found[:, mine] = sign * self._within(part, local)
            found[0, mine] += here
            here += sign * part.state[-1, 0]
        found[1:, (t_s <= 0.0) | (t_s >= ends[-1])] = 0.0
        return Jet(*found)

    def _parts(self, times: int) -> list[tuple[float, PushTransition]]:
        """Return the stretches in sequence, each with the sign of its direction."""
        first, swing, last, stop = _stretches(self)
        swings = [((-1.0) ** number, swing) for number in range(2 * times - 1)]
        return [(1.0, first), *swings, (1.0, last), (1.0, stop)]

    def _within(self, part: PushTransition, t_s: Array) -> Array:
        """Return way, speed and acceleration (3, n) at times within a stretch."""
        way, speed = part.at(t_s)
        push = self.push_m_s2 * self._level(part.levels, t_s)
        return np.array([way, speed, push - self.drag_1_m * np.abs(speed) * speed])

    def _level(self, levels: tuple[float, float], t_s: Array) -> Array:
        return levels[0] + (levels[1] - levels[0]) * smoothstep(t_s, self.switch_s).x

    def stretch(self, levels: tuple[float, float], speed: float, lasts_s: float) -> PushTransition:
        """Integrate from a speed for a time; a negative time integrates backwards."""
        count = max(1, math.ceil(abs(lasts_s) / STEP_S))
        step = lasts_s / count
        begin = 0.0 if step > 0 else -lasts_s
        pushes = self.push_m_s2 * self._level(levels, np.asarray(begin + step * np.arange(2 * count + 1) / 2.0))
        return PushTransition(levels, abs(step), _integrated(pushes.tolist(), step, speed, self.drag_1_m))

    def until(self, levels: tuple[float, float], speed: float, reached: float) -> PushTransition:
        """Integrate from a speed until a larger speed is reached."""
        long = self.stretch(levels, speed, LONGEST_HALVES * self.half_s + self.switch_s)
        speeds = long.state[:, 1]
        after = int(np.argmax(speeds >= reached))
        share = (reached - speeds[after - 1]) / (speeds[after] - speeds[after - 1])
        return self.stretch(levels, speed, long.step_s * (after - 1 + float(share)))


@lru_cache(maxsize=4096)
def _stretches(sway: Swaying) -> tuple[PushTransition, PushTransition, PushTransition, PushTransition]:
    """Return four stretches: from rest to full speed, a swing to the opposite speed, back until slow, to rest."""
    low, high = 0.0, sway.push_m_s2 * sway.half_s
    for _ in range(ROUNDS):
        speed = (low + high) / 2
        swing = sway.stretch((1.0, -1.0), speed, 2.0 * sway.half_s)
        low, high = (speed, high) if -swing.state[-1, 1] > speed else (low, speed)
        if high - low < CLOSE_M_S:
            break
    slow = sway.stretch((1.0, 0.0), 0.0, -sway.switch_s).state[-1, 1]
    first, last = sway.until((0.0, 1.0), 0.0, speed), sway.until((-1.0, 1.0), -speed, slow)
    return first, swing, last, sway.stretch((1.0, 0.0), last.state[-1, 1], sway.switch_s)


def _integrated(pushes: list[float], step: float, speed: float, drag_1_m: float) -> Array:
    """Return way, speed and acceleration (n, 3) by fourth-order Runge-Kutta; pushes (2 n - 1) at ends and middles."""

    def rate(push: float, at: float) -> float:
        return push - drag_1_m * abs(at) * at

    way, state = 0.0, []
    for low, middle, high in zip(pushes[:-2:2], pushes[1:-1:2], pushes[2::2], strict=True):
        k1 = rate(low, speed)
        state.append((way, speed, k1))
        v2 = speed + step / 2 * k1
        v3 = speed + step / 2 * (k2 := rate(middle, v2))
        v4 = speed + step * (k3 := rate(middle, v3))
        way += step / 6 * (speed + 2 * v2 + 2 * v3 + v4)
        speed += step / 6 * (k1 + 2 * k2 + 2 * k3 + rate(high, v4))
    return np.array([*state, (way, speed, rate(pushes[-1], speed))])


def _cubic(u: Array, a: Array, b: Array, da: Array, db: Array) -> Array:
    """Return the cubic with values a, b and slopes da, db at u = 0 and 1."""
    square, cube = u * u, u * u * u
    return np.asarray(
        a * (2 * cube - 3 * square + 1)
        + b * (3 * square - 2 * cube)
        + da * (cube - 2 * square + u)
        + db * (cube - square)
    )
