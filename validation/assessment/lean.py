"""Mean tilt of a vehicle in a level turn, which a planar calibration takes for a part of the offset."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib.numerics.rates import body_rate, world_to_body
from recordings import Recording
from scenarios.arrays import Array
from validation.assessment.policy import ASSESSMENT

GRAVITY_M_S2 = 9.80665
STRIDE_S = 5.0
"""Time between the positions that a speed is taken from."""


@dataclass(frozen=True)
class Lean:
    """Upward direction in the body, forward and left (2,), its standard deviation, rad, and the chance of no lean."""

    mean_rad: tuple[float, float]
    std_rad: float
    level: float

    @classmethod
    def of(cls, recording: Recording) -> Lean:
        """Return the mean lean of a recording: by its attitude, else by speed and turning rate, else unknown.

        A vehicle that turns at the rate w with the speed v leans by w v / g towards the left.
        """
        if recording.att_q is not None:
            up = world_to_body(recording.att_q, np.array([0.0, 0.0, 1.0])).mean(axis=0)
            return cls._about(float(up[0]), float(up[1]), ASSESSMENT.attitude_deg)
        rate, speed = body_rate(recording), _speed_m_s(recording)
        left = 0.0 if rate is None or speed is None else -float(np.mean(rate[:, 2])) * speed / GRAVITY_M_S2
        return cls._about(0.0, left, ASSESSMENT.lean_deg)

    @classmethod
    def _about(cls, forward: float, left: float, std_deg: float) -> Lean:
        """Return a lean about a mean; one beyond two standard deviations is none of a level vehicle."""
        std = float(np.radians(std_deg))
        return cls((forward, left), std, ASSESSMENT.level if np.hypot(forward, left) < 2.0 * std else 0.0)

    def drawn(self, count: int) -> Array:
        """Return draws (count, 2)."""
        rng = np.random.default_rng(1)
        leaning = self.mean_rad + self.std_rad * rng.standard_normal((count, 2))
        return np.where(rng.random(count)[:, None] < self.level, 0.0, leaning)


def _speed_m_s(recording: Recording) -> float | None:
    """Return the median speed by the positions; None without, and in a recording shorter than two strides."""
    if recording.pos_enu_m is None or not recording.origin.timed or np.ptp(recording.time_s) < 2.0 * STRIDE_S:
        return None
    stride = np.unique(np.floor((recording.time_s - recording.time_s[0]) / STRIDE_S))  # that have samples
    at_s, next_to = recording.time_s[0] + STRIDE_S * stride, np.diff(stride) == 1.0
    places = np.column_stack([np.interp(at_s, recording.time_s, column) for column in recording.pos_enu_m[:, :2].T])
    moved_m = np.linalg.norm(np.diff(places, axis=0), axis=1)[next_to]
    return float(np.median(moved_m)) / STRIDE_S if len(moved_m) else None
