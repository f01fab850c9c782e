"""A data set's bytes do not depend on the processor: other kernels of BLAS, numpy's plain series, the same columns."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from functools import cache

import pytest
from numpy._core._multiarray_umath import __cpu_dispatch__ as VECTOR_UNITS

from sim.scenario import load
from sim.simulation import blocks, plan
from tests.nightly import first_daily

SCENARIOS = {
    "auv-spiral": ("phases.0.duration_s=60", "effects.hard_iron_drift.rate_nT_h=[300,200,100]"),
    "quad-comb": ("phases.0.lines=2", "phases.0.line_length_m=60"),
    "tumble": ("phases.0.duration_s=60", "sensors=[{position_m = [0.1, 0.2, 0.3]}]"),
}
OTHERS = {
    "short vectors": {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": " ".join(VECTOR_UNITS)},
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
}


@cache
def digests() -> str:
    """A line a scenario: its name and the hash of its columns."""
    return "\n".join(f"{name} {_digest(name)}" for name in SCENARIOS)


def _digest(name: str) -> str:
    found = hashlib.sha256()
    for block in blocks(plan(load(name, SCENARIOS[name]))):
        for column in sorted(block):
            found.update(block[column].tobytes())
    return found.hexdigest()


@pytest.mark.parametrize("other", first_daily(OTHERS))
def test_the_same_columns_on(other: str) -> None:
    code = "from tests.sim.test_processor import digests; print(digests())"
    run = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | OTHERS[other], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == digests().split()
