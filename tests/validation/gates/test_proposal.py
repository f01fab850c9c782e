"""The limits that a file of gates begins with, from comparisons whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.errors import InputError
from tests.validation.comparison.example import table_of
from validation.comparison.statistics import rate
from validation.gates.power import fewest_trials, trials_to_pass
from validation.gates.proposal import AFFORDABLE, LADDER, ProposedLimit, cost, gate_proposals
from validation.gates.sequential import SequentialTest
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
    for _ in range(4):
        values = rng.lognormal(0.0, spread, trials)
        (found,) = gate_proposals(table_of({"a": values, "uncorrected": 100 * values}), SCORE).gates
        below += found.limit.value < 1.0
    assert below <= 1  # of 4, where one in forty is below


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


def test_a_limit_is_the_next_of_a_few_multiples_of_the_best() -> None:
    """1.1 to 100 times: of calibrators that are as many times worse in every trial, the first multiple that holds."""
    times = (1.05, 1.2, 1.4, 1.9, 2.5, 4.0, 8.0, 15.0, 40.0, 90.0)
    scores = {f"x{by:g}": np.full(40, by) for by in times} | {"best": np.ones(40), "uncorrected": np.full(40, 1e3)}
    best, *others = gate_proposals(table_of(scores), SCORE).gates
    assert (best.calibrator, best.reference, best.limit.value) == ("best", None, 1.1)
    assert [one.reference for one in others] == ["best"] * len(times)
    assert [one.limit.value for one in others] == [1.1, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0]


def test_a_gate_is_proposed_for_the_test_that_it_will_be_decided_by() -> None:
    """Half of the trials may exceed; a ten-thousandth of false failures is shared by the gates; one in a hundred
    passes falsely."""
    found = gate_proposals(table_of({"a": np.ones(40), "b": 2 * np.ones(40), "uncorrected": np.ones(40)}), SCORE).gates
    assert [one.test for one in found] == [SequentialTest(0.5, 0.5e-4, pytest.approx(0.01))] * 2
    (alone,) = gate_proposals(table_of({"a": np.ones(40), "uncorrected": np.ones(40)}), SCORE).gates
    assert alone.test.false_fail_rate == 1e-4
    over = rate(0, 40).high  # of no exceedance in forty
    assert alone.limit.trials == trials_to_pass(alone.test, over, 0.99)
    assert alone.limit.usually == trials_to_pass(alone.test, over, 0.5)
    assert alone.max_trials >= alone.limit.trials
    assert alone.caught == pytest.approx(1.1)  # without a spread whatever is over the limit fails


def failing_in(count: int, of: int) -> np.ndarray:
    """One in every trial, but no estimate in some."""
    return np.where(np.arange(of) < count, np.inf, 1.0)


def test_where_no_limit_passes_soon_the_highest_is_proposed_beside_the_next(rng: np.random.Generator) -> None:
    """Whatever the limit, ten failures of forty may be four in ten, which takes hundreds of trials to pass."""
    (found,) = gate_proposals(table_of({"a": failing_in(10, 40), "uncorrected": np.full(40, 1e3)}), SCORE).gates
    assert found.limit.trials is not None
    assert found.limit.trials > AFFORDABLE
    assert (found.limit.value, found.stricter and found.stricter.value) == (100.0, 50.0)
    assert found.max_trials == found.limit.trials


def test_the_next_lower_limit_is_told_with_its_price_where_the_median_keeps_it(rng: np.random.Generator) -> None:
    values = rng.lognormal(0.0, 0.3, 40)
    (found,) = gate_proposals(table_of({"a": values, "uncorrected": 100 * values}), SCORE).gates
    assert found.limit.trials is not None
    assert found.limit.trials <= AFFORDABLE
    assert found.stricter is not None
    steps = [float(f"{step * np.median(values):.3g}") for step in LADDER]
    assert steps.index(found.limit.value) == steps.index(found.stricter.value) + 1
    assert found.stricter.trials is None or found.stricter.trials > AFFORDABLE
    (best, other) = gate_proposals(
        table_of({"a": np.ones(40), "b": np.full(40, 1.3), "uncorrected": np.full(40, 1e3)}), SCORE
    ).gates
    assert best.stricter is None  # the lowest limit is kept
    assert (other.limit.value, other.stricter) == (1.5, None)  # 1.25 would not be


def test_the_price_of_a_limit_in_words() -> None:
    assert cost(ProposedLimit(2.0, 120, 40)) == (
        "Passing takes 40 trials in half of the runs, 120 at most in 99 % of them"
    )
    assert cost(ProposedLimit(2.0, None, None)) == "Passing takes more than 5000 trials"


def test_a_limit_has_three_figures_and_enough_trials_to_fail_too(rng: np.random.Generator) -> None:
    (found,) = gate_proposals(table_of({"a": np.full(400, 0.123456), "uncorrected": np.ones(400)}), SCORE).gates
    assert found.limit.value == 0.136
    assert found.max_trials == max(found.limit.trials or 0, 2 * fewest_trials(found.test))
