"""Recordings of a smooth full tumble with iron and noise, made apart from the simulator."""

from __future__ import annotations

import numpy as np

from recordings import Recording

F_NT, OFFSET_NT, NOISE_NT = 48_000.0, np.array([12_000.0, -8_000.0, 25_000.0]), 150.0
SOFT = np.array([[1.05, 0.02, -0.01], [0.02, 0.96, 0.015], [-0.01, 0.015, 1.01]])


def tumble(seed: int, rows: int = 600, rate_hz: float = 10.0, noise_nT: float = NOISE_NT) -> Recording:
    """Return a tumble that covers the sphere within a minute."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(rows) / rate_hz
    lift = np.sin(0.31 * time_s + rng.uniform(0, 6)) * 0.99
    turn = 0.83 * time_s + rng.uniform(0, 6) + 0.7 * np.sin(0.17 * time_s)
    level = np.sqrt(1 - lift**2)
    unit = np.column_stack([level * np.cos(turn), level * np.sin(turn), lift])
    return Recording(time_s, F_NT * unit @ SOFT + OFFSET_NT + rng.normal(0, noise_nT, (rows, 3)))
