"""White recordings from each converter show nothing that is not in them."""

from __future__ import annotations

from benchmarks.inspection_alarms import STEPS_NT, alarms


def test_a_white_recording_of_each_converter_shows_nothing() -> None:
    assert [alarms(seed) for seed in range(len(STEPS_NT))] == [set()] * len(STEPS_NT)
