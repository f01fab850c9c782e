"""Payloads of no effect's form: their currents, their lag, and how their curves are counted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.diagnosis.curves import COURSES, FORMS, PAYLOAD, STRENGTHS, current, figures, late, payloads

TIME_S = np.arange(0.0, 600.0, 0.1)


@pytest.mark.parametrize("course", COURSES)
def test_a_current_goes_between_its_ends_and_another_flight_has_another(course: str) -> None:
    one, other = (current(course, TIME_S, np.random.default_rng(seed)) for seed in range(2))
    assert np.abs(one).max() <= 1.0
    assert one.std() > 0.2
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.5


def test_a_lag_is_that_of_one_time_constant() -> None:
    """After a step ``1 - exp(-t / tau)``."""
    step = (TIME_S >= 100.0).astype(float)
    answered = late(step, 5.0, 0.1)
    assert answered[np.searchsorted(TIME_S, 105.0)] == pytest.approx(1 - np.exp(-1), abs=0.01)
    assert late(step, 0.0, 0.1) is step


def test_every_form_is_tried_on_every_vehicle_and_drawn_anew_for_each_seed() -> None:
    some = list(payloads(0, 2))
    assert len({one.key for one in some}) == len(some) == 2 * 2 * len(FORMS) * len(STRENGTHS)
    assert len({tuple(one.drawn[2]) for one in some}) == len(some)


def row(key: str, channels: list[str], elsewhere: float | None) -> dict[str, Any]:
    return {"key": key, "channels": channels, "elsewhere": elsewhere, "verdict": "unknown", "names": []}


def test_a_payload_counts_as_followed_by_its_own_channel_alone() -> None:
    rows = [row("a", [PAYLOAD], 0.95), row("b", [PAYLOAD], 0.8), row("c", [PAYLOAD, "x"], 0.9), row("d", [], None)]
    told = figures(rows)
    assert (told["followed"], told["at least 0.9 elsewhere"], told["by another channel too"]) == (2, 1, 1)
    assert list(told["not followed"]) == ["c", "d"]
