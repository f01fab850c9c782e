"""What a fit from the field's strength costs on the standard case.

Goals of 0.4, 1.5 and 2.5 ms are not reached. Microseconds of the parts, the least of fifty calls on a busy machine:

| part | us |
|---|---|
| unit, extent, wild rows and copies, every method | 300 |
| search for a characteristic, 15 columns in five folds: products 350, predictions 150 | 500 |
| colour, covariance, condition and misfit | 200 |
| ellipsoid's own solution: a first quadric 80, three refits of 100 | 470 |
| ml_newton's own solution: two-step start 1000, three Newton steps of 200, covariance and bias 590 | 1900 |

A sum over the 3600 samples takes 45 us at least (ten columns in one pass), so that the limits below are those of the
judgement, which is the same for all three.
"""

from __future__ import annotations

import statistics

from benchmarks.measure import Row, cpu_s
from benchmarks.population import STRENGTH_NT, recording
from calib import CALIBRATORS, Reference

MOST_MS = {"ellipsoid": 2.0, "ml_newton": 5.0, "ml_geometric": 7.5}
REPEATS, SMALL = 200, 3
"""Fits that are timed; the second is for a test of the benchmark."""


def rows(small: bool = False) -> list[Row]:
    """Return a row for each method."""
    return [_row(name, limit_ms, SMALL if small else REPEATS) for name, limit_ms in MOST_MS.items()]


def _row(name: str, limit_ms: float, repeats: int) -> Row:
    method, measured, reference = CALIBRATORS[name](), recording(), Reference(STRENGTH_NT)
    method.fit(measured, reference)
    times_ms = sorted(1e3 * cpu_s(lambda: method.fit(measured, reference)) for _ in range(repeats))
    note = f"{len(measured)} samples, whole fit, warm; fastest {times_ms[0]:.2f} ms, slowest {times_ms[-1]:.2f} ms"
    return Row(f"{name}, ms", statistics.median(times_ms), limit_ms, False, note)
