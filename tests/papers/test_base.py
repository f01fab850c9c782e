"""What the reproductions share: verdicts, spreads, poses, and tasks gathered in their order."""

from __future__ import annotations

import operator

import numpy as np
import pytest

from papers import PAPERS, chosen
from papers.attitudes import state_at_attitudes
from papers.base import run_tasks, spread_text, verdict_of
from scenarios.errors import InputError


def test_spread_is_median_and_ninety_percent():
    values = np.arange(101.0)
    assert spread_text(values, "nT") == "50 nT (5 to 95)"
    assert spread_text(values / 7, decimals=1) == "7.1 (0.7 to 13.6)"
    assert spread_text([1234.5, 1234.5], significant=4) == "1234 (1234 to 1234)"


def test_judged():
    assert (verdict_of(True), verdict_of(np.bool(False))) == ("holds", "does not hold")


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_results_come_in_the_order_of_their_items(jobs):
    told = []
    work = [(operator.neg, [3, 1, 3]), (abs, range(-2, 0))]
    assert run_tasks(work, jobs, lambda done, total: told.append((done, total))) == ([-3, -1, -3], [2, 1])
    assert told == [(k, 5) for k in range(1, 6)]


def test_a_held_sensor_sees_the_field_turned():
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    state = state_at_attitudes(np.array([np.eye(3), quarter]), np.array([1.0, 2.0, 3.0]), interval_s=0.5)
    np.testing.assert_allclose(state.field_nT, [[1.0, 2.0, 3.0], [2.0, -1.0, 3.0]])
    np.testing.assert_allclose(state.time_s, [0.0, 0.5])
    assert not state.rate_rad_s.any()


def test_papers_are_chosen_by_key_whatever_its_case():
    assert [type(paper).__name__.lower() for paper in chosen("all", 2)] == list(PAPERS)
    assert len(chosen("ALL", 2)) == len(PAPERS)
    assert chosen("LI2017", 3)[0].seeds == 3
    with pytest.raises(InputError, match=r"choose among zhang2018, .*, all"):
        chosen("li2018", 2)
