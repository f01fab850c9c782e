"""Which calibrator the answer names, and what it says of how sure that is."""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation.comparison.example import table_of
from validation.comparison.ranking import overall_sentence, quoted, rank_calibrators
from validation.scoring.definitions import SCORE_DEFINITIONS

SCORE = SCORE_DEFINITIONS["offset_error"]
RNG = np.random.default_rng(5)
N = 100
GOOD = RNG.lognormal(0.0, 0.1, N)
RAW = np.full(N, 2000.0)


def test_a_clear_best_is_named_with_its_interval_and_the_next():
    found = rank_calibrators(table_of({"poor": 3 * GOOD, "good": GOOD, "uncorrected": RAW}), SCORE)
    assert [one.calibrator for one in found.calibrators] == ["good", "poor"]
    assert found.sentence.startswith("use good: ")
    assert "nT [" in found.sentence
    assert found.sentence.endswith("of the offset, better than poor in 100 of 100 trials; fails in 0 of 100")
    assert found.against("poor").better == N
    assert not found.rivals


def test_equals_are_named_together():
    other = RNG.permutation(GOOD)
    found = rank_calibrators(table_of({"one": GOOD, "other": other, "uncorrected": RAW}), SCORE)
    assert found.rivals
    assert found.sentence.startswith(f"use {found.best.calibrator} or {found.rivals[0]}: ")
    assert "no clear difference" in found.sentence


def test_one_that_mostly_fails_is_last_whatever_its_score():
    table = table_of({"fails": GOOD / 10, "works": GOOD, "uncorrected": RAW}, failing=["fails"])
    found = rank_calibrators(table, SCORE)
    assert found.best.calibrator == "works"
    assert found.calibrators[-1].reason == "flat motion"
    assert found.calibrators[-1].failures == N


def test_where_all_fail_none_is_named():
    nothing = np.full(N, np.inf)
    found = rank_calibrators(table_of({"a": nothing, "b": nothing, "uncorrected": RAW}), SCORE)
    failing = [f"{name} fails in 100 of 100 trials: it broke down" for name in "ab"]
    assert found.sentence == f"none can be used here: {'; '.join(failing)}"


def test_one_that_fails_in_most_trials_is_named_beside_the_recommendation():
    found = rank_calibrators(table_of({"good": GOOD, "crash": np.full(N, np.inf), "uncorrected": RAW}), SCORE)
    assert found.sentence.startswith("use good: ")
    assert found.sentence.endswith("; fails in 0 of 100; crash fails in 100 of 100 trials: it broke down")
    many = {f"crash{k}": np.full(N, np.inf) for k in range(9)}
    found = rank_calibrators(table_of({"good": GOOD, **many, "uncorrected": RAW}), SCORE)
    assert found.sentence.endswith("it broke down; 4 more fail in most")
    assert quoted("ab\n" * 1000) == ": " + "ab " * 40 + "..."


def test_a_calibration_that_makes_it_worse_is_not_recommended():
    found = rank_calibrators(table_of({"bad": 3 * RAW, "uncorrected": RAW}), SCORE)
    assert found.sentence.startswith("use none of them: bad leaves 6000 nT")


def test_alone_it_is_compared_with_no_correction():
    found = rank_calibrators(table_of({"good": GOOD, "uncorrected": RAW}), SCORE)
    assert "better than no correction in 100 of 100 trials" in found.sentence


def test_sensors_of_an_array_are_each_compared_with_their_own_measurement():
    table = table_of({"a@1": GOOD, "a@2": 2 * GOOD, "uncorrected@1": RAW, "uncorrected@2": 2 * RAW})
    found = rank_calibrators(table, SCORE)
    assert found.uncorrected.value == 2000.0
    assert {one.calibrator for one in found.calibrators} == {"a@1", "a@2"}


def test_several_points_are_summed_up_and_told_each():
    table = table_of(
        {"a": GOOD, "b": 2 * GOOD, "uncorrected": RAW},
        {"a": 3 * GOOD, "b": 2 * GOOD, "uncorrected": RAW},
        {"a": GOOD, "b": 2 * GOOD, "uncorrected": RAW},
        sweep=[1.0, 5.0, 10.0],
    )
    answers = [rank_calibrators(table, SCORE, point) for point in table.points]
    text = overall_sentence(answers, ["noise 1", "noise 5", "noise 10"])
    assert text.startswith("use a, the best at 2 of 3 points: at noise 1 use a: ")
    assert "at noise 5 use b: " in text


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_trials_give_an_answer_too(n):
    found = rank_calibrators(table_of({"a": GOOD[:n], "b": 9 * GOOD[:n], "uncorrected": RAW[:n]}), SCORE)
    assert found.best.calibrator == "a"
