"""What an inspection of a long log of the field alone costs, for each row.

Four million rows from Parquet took 10.2 s of CPU and 6.7 s of the system, and 1.3 GB; before, 19 and 12.8 s
and 2.1 GB. The goal of 11 s together is not reached. A profile of one million rows, 6.6 s of CPU on a busy machine:

| part | s |
|---|---|
| three fits; of them 2.3 the covariance of flicker noise that the sphere's misfit looks like | 3.4 |
| converter's step of three axes, before the search stopped sorting 1.5 | 0.8 |
| largest hole of the sphere | 0.6 |
| white noise | 0.5 |
| sound rows in order of time, rates and intervals | 0.5 |
| tones and block means | 0.3 |

The system's part are the pages of arrays of 96 MB, which every step takes anew.
"""

from __future__ import annotations

import numpy as np

import magbench
from benchmarks.measure import Row, cpu_s
from recordings import Recording

MOST_US = 9.0
ROWS, SMALL = 1_000_000, 5_000
"""Rows of the log; the second is for a test of the benchmark."""
RATE_HZ, NOISE_NT, STRENGTH_NT = 50.0, 10.0, 47_000.0


def rows(small: bool = False) -> list[Row]:
    """Return the microseconds of CPU for a row, the system's included."""
    count = SMALL if small else ROWS
    log = tumbling(count)
    magbench.inspect(tumbling(SMALL))
    taken_s = cpu_s(lambda: magbench.inspect(log))
    note = f"{count} rows of time and field: {taken_s:.2f} s"
    return [Row("inspect, us a row", 1e6 * taken_s / count, MOST_US, False, note)]


def tumbling(count: int) -> Recording:
    """Return a field that slowly turns through all directions, through an ellipsoid, with noise."""
    time_s = np.arange(count) / RATE_HZ
    height, angle = np.sin(0.031 * time_s), 0.4 * time_s
    level = np.sqrt(1 - height**2)
    field_nT = STRENGTH_NT * np.column_stack([level * np.cos(angle), level * np.sin(angle), height])
    S, b_nT = np.array([[1.03, 0.01, -0.02], [0.01, 0.98, 0.005], [-0.02, 0.005, 1.01]]), (300.0, -800.0, 150.0)
    noise_nT = np.random.default_rng(0).normal(0, NOISE_NT, (count, 3))
    return Recording(time_s, field_nT @ S.T + b_nT + noise_nT)
