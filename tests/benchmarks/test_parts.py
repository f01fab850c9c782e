"""Every part of the speed benchmark runs, once and small, so that a changed signature is noticed."""

from __future__ import annotations

import math
from types import ModuleType

import pytest

from benchmarks import dataset, diagnosing, engines, kalman, norm, population
from benchmarks.__main__ import PARTS
from benchmarks.honesty import bench as honesty

SLOW = (engines, diagnosing, dataset, norm, kalman, population)
"""Parts that start other processes, or fit for more than five seconds however small they are."""


@pytest.mark.parametrize(
    "part",
    [pytest.param(part, marks=[pytest.mark.slow] * (part in SLOW), id=part.__name__) for part in (*PARTS, honesty)],
)
def test_a_part_runs_once_and_small(part: ModuleType) -> None:
    rows = list(part.rows(small=True))
    assert rows
    assert all(row.value is None or math.isfinite(row.value) for row in rows)
    assert all(row.what in row.text(60) for row in rows)
