"""What a fit from the field's strength costs on the standard case.

The ellipsoid's limit is not that of a plain quadric (0.4 to 0.6 ms). Of 2 ms its own solution takes 0.6; the search for
colour and a characteristic in the residual 0.6; covariance, condition and misfit 0.3; unit, extent and wild rows 0.3.
The rest is 1,300 calls of Python and numpy. The judgement is the same for ml_newton and ml_geometric.
"""

from __future__ import annotations

import statistics

from benchmarks.measure import Row, cpu_s
from benchmarks.population import STRENGTH_NT, recording
from calib import CALIBRATORS, Reference

MOST_MS = {"ellipsoid": 2.0, "ml_newton": 10.0, "ml_geometric": 20.0}
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
