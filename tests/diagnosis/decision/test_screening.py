"""Which candidates of a round are tried."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision import screening as first_look
from diagnosis.decision.screening import Screening, best_of_each_name
from diagnosis.policy import STANDARD


@pytest.mark.parametrize(("gains", "kept"), [((100, 111), 0), ((100, 113), 1), ((2, 6), 0), ((2, 7), 1)])
def test_a_fuller_form_is_taken_from_the_start_where_it_gains_more_by_an_error_of_form(
    gains: tuple[float, float], kept: int
) -> None:
    assert best_of_each_name(["one", "one", "another"], np.array([*gains, 50.0]), STANDARD) == [kept, 2]


def test_a_first_look_counts_what_is_gained_between_the_samples_of_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    rows, within = SimpleNamespace(bin=lambda whole: whole), iter([4.0, 0.0])
    coloured_baseline: Any = SimpleNamespace(rows=rows, screening_gains=lambda columns: np.array([3.0, 5.0]))
    monkeypatch.setattr(first_look, "gain_within", lambda *_: next(within))
    baseline: Any = SimpleNamespace(problem=None, accepted_columns=())
    evidence: Any = SimpleNamespace(candidate=SimpleNamespace(columns=lambda problem: None))
    assert list(Screening.of([evidence, evidence], coloured_baseline, baseline).nats) == [7.0, 5.0]
