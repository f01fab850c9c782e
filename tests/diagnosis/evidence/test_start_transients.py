"""Samples after a start that a late measurement does not know."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.direct import find_start_samples
from tests.diagnosis.synthetic import problem, recording


@pytest.mark.parametrize(("n", "left_out_s"), [(4000, 1.0), (1000, 1.0), (300, 0.6)])
def test_a_second_after_a_start_is_unknown_or_a_fiftieth_of_a_short_recording(n: int, left_out_s: float) -> None:
    """At 10 samples a second."""
    assert find_start_samples(problem(n=n)).sum() == pytest.approx(10 * left_out_s, abs=1)


def test_it_is_shared_between_starts_and_asked_beside_an_attitude_alone() -> None:
    given = recording(1000)
    paused = problem(replace(given, time_s=given.time_s + 60.0 * (np.arange(1000) >= 500)))
    assert find_start_samples(paused).sum() == pytest.approx(20, abs=2)
    assert find_start_samples(paused)[500:510].all()
    assert not find_start_samples(replace(paused, still=True)).any()
