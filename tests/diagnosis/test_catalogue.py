"""A flight of every scenario that draws nothing anew agrees with the scenario, its navigation's errors and all."""

from __future__ import annotations

import pytest

import magbench
from tests.nightly import first_daily

LONG = ("auv-dive", "auv-spiral", "auv-comb", "quad-spiral")
"""Scenarios whose motion another flies in less time."""
AS_WRITTEN = [name for name in magbench.catalogue() if not magbench.load(name).vary]


@pytest.mark.parametrize("seed", first_daily([34, 36]))
@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n in LONG)) for n in AS_WRITTEN])
def test_a_flight_agrees_with_its_own_scenario(name: str, seed: int) -> None:
    recording, _ = magbench.simulate(name, seed=seed)
    found = magbench.diagnose(recording, name)
    assert (found.verdict, found.named) == ("none", ())
