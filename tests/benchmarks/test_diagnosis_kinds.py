"""What the kinds of wrong answers hide is what their words say."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.diagnosis.kinds import Trial, pulse_windows_s, run


@pytest.mark.parametrize("duration_s", [119.9, 599.9])
def test_two_pulses_are_apart_and_end_within_the_flight(duration_s: float) -> None:
    drawn = (pulse_windows_s(duration_s, np.random.default_rng(seed)) for seed in range(1000))
    ends_s = np.array([np.concatenate([[0.0], windows_s.ravel(), [duration_s]]) for windows_s in drawn])
    assert (np.diff(ends_s, axis=1) > 5.0).all()


@pytest.mark.slow
def test_a_magnet_that_is_there_twice_in_two_minutes_is_iron() -> None:
    """Of this seed the pulses once overlapped and lasted to the end, a jump, and its right name counted as wrong."""
    row = run(Trial("pulses", 413))
    assert row["right"]
    assert "hard_iron" in row["told"]
