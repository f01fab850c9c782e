"""The limits that a file of gates begins with, from comparisons whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.errors import InputError
from tests.validation.comparison.example import table_of
from validation.gates.proposal import gate_proposals
from validation.scoring.definitions import SCORE_DEFINITIONS

SCORE = SCORE_DEFINITIONS["offset_error"]


@pytest.fixture
def rng() -> np.random.Generator:
    """The same for each test, whichever ran before in its process."""
    return np.random.default_rng(20)


@pytest.mark.parametrize(("trials", "spread"), [(12, 0.8), pytest.param(60, 0.2, marks=pytest.mark.slow)])
def test_few_trials_do_not_give_a_limit_that_the_same_calibrator_breaks(
    trials: int, spread: float, rng: np.random.Generator
) -> None:
    """The true median is 1; a limit below it would fail a calibrator that did not change."""
    below = 0
    for _ in range(20):
        values = rng.lognormal(0.0, spread, trials)
        (found,) = gate_proposals(table_of({"a": values, "uncorrected": 100 * values}), SCORE).gates
        below += found.limit.value < 1.0
    assert below <= 2  # of 20, where one in forty is below


def test_more_trials_give_a_stricter_limit(rng: np.random.Generator) -> None:
    few, many = rng.lognormal(0.0, 0.3, 12), rng.lognormal(0.0, 0.3, 500)
    (one,), (other,) = (gate_proposals(table_of({"a": v, "uncorrected": v}), SCORE).gates for v in (few, many))
    limits = [one.limit.value / np.median(few), other.limit.value / np.median(many)]
    assert limits[1] < limits[0]
    assert limits[1] < 1.3


def test_one_that_is_worse_than_the_ladder_is_high_gets_a_limit_of_its_own(rng: np.random.Generator) -> None:
    good, bad = rng.lognormal(0.0, 0.3, 60), rng.lognormal(8.0, 0.01, 60)
    _, found = gate_proposals(table_of({"a": good, "b": bad, "uncorrected": bad}), SCORE).gates
    assert found.reference is None
    assert found.limit.trials is not None
    assert np.median(bad) < found.limit.value < 2 * np.median(bad)


def test_a_calibrator_that_fails_in_its_trials_gets_no_gate_but_a_reason(rng: np.random.Generator) -> None:
    """With an estimate in every trial, though: a gate of 50 times the best would pass."""
    good = rng.lognormal(0.0, 0.3, 20)
    broken = np.where(np.arange(20) < 9, np.inf, good)  # 9 of 20 may be as well one half
    scores = {"fails": 20 * good, "good": good, "sometimes": broken, "none": np.full(20, np.inf), "uncorrected": good}
    found = gate_proposals(table_of(scores, failing=["fails"]), SCORE)
    assert [one.calibrator for one in found.gates] == ["good"]
    assert found.left_out["fails"] == "fails in 20 of 20 trials: flat motion"
    assert found.left_out["none"] == "fails in 20 of 20 trials: it broke down"
    assert found.left_out["sometimes"].startswith("fails in 9 of 20 trials: it broke down: passing takes more than")


def test_no_file_is_proposed_where_no_gate_would_guard_anything() -> None:
    never = np.full(10, np.inf)
    with pytest.raises(InputError, match="no gate would guard anything: a fails in 10 of 10 trials: it broke down"):
        gate_proposals(table_of({"a": never, "uncorrected": np.ones(10)}), SCORE)
