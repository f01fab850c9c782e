"""Which calibrator the answer names, and what it says of how sure that is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.validation.comparison.example import table_of
from validation.comparison.ranking import frequent_reason, overall_sentence, quoted, rank_calibrators
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


def test_a_difference_is_counted_for_the_best_whichever_is_listed_first():
    worse = np.r_[GOOD[:7] / 2, 3 * GOOD[7:]]
    for scores in ({"good": GOOD, "worse": worse}, {"worse": worse, "good": GOOD}):
        found = rank_calibrators(table_of(scores | {"uncorrected": RAW}), SCORE)
        assert found.best.calibrator == "good"
        pair = found.against("worse")
        assert (pair.one, pair.other, pair.better, pair.worse) == ("good", "worse", N - 7, 7)
        assert f"better than worse in {N - 7} of {N} trials" in found.sentence
        with pytest.raises(KeyError):
            found.against("nobody")


def test_one_that_fails_in_half_of_its_trials_still_counts_and_in_more_does_not():
    """And is no rival, though its few scores show no clear difference."""
    half, more = np.array(GOOD), np.array(GOOD)
    half[: N // 2], more[: N // 2 + 1] = np.inf, np.inf
    found = rank_calibrators(table_of({"half": half, "more": more, "works": 2 * GOOD, "uncorrected": RAW}), SCORE)
    assert [one.place[0] for one in found.calibrators] == [False, False, True]
    assert found.calibrators[-1].calibrator == "more"
    assert "more" not in found.rivals
    assert found.sentence.endswith(f"more fails in {N // 2 + 1} of {N} trials: it broke down")


def test_the_reason_is_the_most_frequent_one_of_the_failures_alone():
    table = table_of({"a": GOOD, "uncorrected": RAW})
    reasons = ["level"] * 2 + ["flat"] * 3 + ["fine"] * (2 * N - 5)
    status = ["unobservable"] * 5 + ["ok"] * (2 * N - 5)
    rows = range(0, 2 * N, 2)  # the first calibrator's
    columns = {"reason": [""] * 2 * N, "status": ["ok"] * 2 * N}
    for name, told in (("reason", reasons), ("status", status)):
        for row, word in zip(rows, told, strict=False):
            columns[name][row] = word
    held = table.columns
    for name, words in columns.items():
        held = held.set_column(held.column_names.index(name), name, [words])
    found = rank_calibrators(replace(table, columns=held), SCORE)
    assert (found.best.failures, found.best.reason) == (5, "flat")
    assert found.sentence.endswith("fails in 5 of 100")


def test_the_raw_measurement_is_beaten_where_a_calibrator_is_better():
    raw = np.r_[np.full(3, 1e-3), RAW[3:]]
    found = rank_calibrators(table_of({"good": GOOD, "uncorrected": raw}), SCORE)
    assert found.better_than_none == N - 3
    assert f"better than no correction in {N - 3} of {N} trials" in found.sentence


def test_what_the_intervals_cost_is_said():
    found = rank_calibrators(table_of({"good": GOOD, "uncorrected": RAW}), SCORE)
    assert found.cost.endswith(
        "95 % however often trials are added: 1.6 times as wide as for 100 trials fixed in advance"
    )


def test_a_list_of_failures_is_cut_after_five_and_a_reason_after_120_letters():
    for count, ends in ((5, "trials: it broke down"), (6, "; 1 more fail in most")):
        many = {f"crash{k}": np.full(N, np.inf) for k in range(count)}
        assert rank_calibrators(table_of({"good": GOOD, **many, "uncorrected": RAW}), SCORE).sentence.endswith(ends)
    assert quoted("a" * 120) == ": " + "a" * 120
    assert quoted("a" * 119 + " b") == ": " + "a" * 119 + " ..."
    assert quoted("not on a sphere: moves by 9 nT; " + "a" * 119) == ": not on a sphere: moves by 9 nT"
    assert quoted(" \n") == ""


def test_a_best_at_every_point_and_none_at_any_are_said_so():
    table = table_of(*[{"a": GOOD, "b": 2 * GOOD, "uncorrected": RAW}] * 2, sweep=[1.0, 5.0])
    answers = [rank_calibrators(table, SCORE, point) for point in table.points]
    text = overall_sentence(answers, ["noise 1", "noise 5"])
    assert text.startswith("use a, the best at every one of 2 points: at noise 1 use a: ")
    assert overall_sentence(answers[:1], ["noise 1"]) == answers[0].sentence
    never = np.full(N, np.inf)
    table = table_of(*[{"a": never, "uncorrected": RAW}] * 2, sweep=[1.0, 5.0])
    answers = [rank_calibrators(table, SCORE, point) for point in table.points]
    text = overall_sentence(answers, ["noise 1", "noise 5"])
    assert text.startswith("none can be used at any of 2 points: none can be used here: a fails in 100 of 100")


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_trials_give_an_answer_too(n):
    found = rank_calibrators(table_of({"a": GOOD[:n], "b": 9 * GOOD[:n], "uncorrected": RAW[:n]}), SCORE)
    assert found.best.calibrator == "a"


def test_the_best_at_most_points_is_named_and_of_equals_the_first():
    one, other = {"a": GOOD, "b": 2 * GOOD, "uncorrected": RAW}, {"a": 3 * GOOD, "b": 2 * GOOD, "uncorrected": RAW}
    for points, says in (
        ((one, other, other), "use b, the best at 2 of 3"),
        ((other, one), "use b, the best at 1 of 2"),
        ((one, other), "use a, the best at 1 of 2"),
    ):
        table = table_of(*points, sweep=range(len(points)))
        answers = [rank_calibrators(table, SCORE, point) for point in table.points]
        assert overall_sentence(answers, [str(point) for point in table.points]).startswith(says)


def test_what_is_asked_without_a_point_is_of_the_first():
    first = {"a": np.r_[np.full(9, np.inf), GOOD[9:]], "uncorrected": RAW}
    table = table_of(first, {"a": 2 * GOOD, "uncorrected": RAW}, sweep=[1.0, 5.0])
    assert rank_calibrators(table, SCORE) == rank_calibrators(table, SCORE, 0)
    assert rank_calibrators(table, SCORE).best.failures == 9
    assert rank_calibrators(table, SCORE, 1).best.failures == 0
    assert frequent_reason(table, "a") == "it broke down"
    assert frequent_reason(table, "a", 1) == ""
