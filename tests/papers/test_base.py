"""What the reproductions share: verdicts, spreads, poses, and tasks gathered in their order."""

from __future__ import annotations

import operator

import numpy as np
import pytest

from papers import PAPERS, Findings, chosen
from papers.attitudes import state_at_attitudes
from papers.base import PaperRow, run_tasks, spread_text
from papers.judgement import claim, error_size, incomparable, number
from papers.report import as_dict
from scenarios.errors import InputError


def test_spread_is_median_and_ninety_percent():
    values = np.arange(101.0)
    assert spread_text(values, "nT") == "50 nT (5 to 95)"
    assert spread_text(values / 7, decimals=1) == "7.1 (0.7 to 13.6)"
    assert spread_text([1234.5, 1234.5], significant=4) == "1234 (1234 to 1234)"


@pytest.mark.parametrize(
    ("ours", "printed", "verdict"),
    [
        (5.4, 5.0, "same number"),
        (-99.98, -99.988, "same number"),
        (7.0, 5.0, "same order"),
        (2.0, 5.0, "same order"),
        (16.0, 5.0, "does not hold"),
        ((16.7, 90.0, 122.0), (59.2, 110.2, 122.2), "does not hold"),
        ((45.0, 110.0, 122.0), (59.2, 110.2, 122.2), "same order"),
    ],
)
def test_a_printed_number_is_the_same_or_of_its_order_or_neither(ours, printed, verdict):
    judged = number(ours, printed)
    assert judged.verdict == verdict
    assert "10 %" in judged.text
    assert "factor of 3" in judged.text


def test_a_printed_error_is_compared_with_the_spread_of_the_seeds():
    """Of 1 to 2: 5 to 95 % are 1.05 to 1.95, the median 1.5."""
    seeds = np.linspace(1.0, 2.0, 21)
    verdicts = [error_size(seeds, printed).verdict for printed in (2.5, 1.9, 1.06, 0.9, 0.4)]
    assert verdicts == ["better", "same number", "same number", "same order", "does not hold"]


def test_a_claim_holds_or_does_not_and_every_row_says_within_what():
    judged = [claim(holds, "2 nT", "noise") for holds in (True, np.bool(False))]
    assert [one.verdict for one in judged] == ["holds", "does not hold"]
    row = PaperRow("error", "2 nT", "1 nT", judged[0])
    assert (row.tolerance, row.holds) == ("2 nT: noise", True)
    assert not PaperRow("error", "", "1 nT", incomparable("not printed")).holds
    paper = chosen("zhou2012", 2)[0]
    (told,) = as_dict({paper: Findings((row,))})["papers"][0]["rows"]
    assert (told["verdict"], told["tolerance"], told["holds"]) == ("holds", "2 nT: noise", True)


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
