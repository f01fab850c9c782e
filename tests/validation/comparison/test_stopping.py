"""The rule that ends a comparison."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from scenarios.errors import InputError
from validation.comparison.statistics import median
from validation.comparison.stopping import FIRST_LOOK, GROWTH, StoppingRule, interim_looks

RNG = np.random.default_rng(3)


def test_words_become_a_rule():
    assert StoppingRule.parsed("median offset_error_nT +-5%") == StoppingRule("offset_error_nT", 0.05, True)
    assert StoppingRule.parsed(" median heading_rms ±0.2 ") == StoppingRule("heading_rms_deg", 0.2, False)
    assert StoppingRule.parsed("median matrix_error +/-1e-3") == StoppingRule("matrix_error", 1e-3, False)


@pytest.mark.parametrize(
    "words", ["", "mean x +-5%", "median x", "median x +-0%", "median x +--5%", "median x +-1.2.3"]
)
def test_other_words_are_refused_with_an_example(words):
    with pytest.raises(InputError, match="median offset_error_nT"):
        StoppingRule.parsed(words)


def test_a_score_that_is_none_is_told_the_near_ones():
    with pytest.raises(InputError, match="offset_error_nT"):
        StoppingRule.parsed("median offset_eror +-5%")


def test_looks_grow_and_end_at_the_most():
    found = list(interim_looks(1000))
    assert found[0] == FIRST_LOOK
    assert found[-1] == 1000
    assert all(b <= a * GROWTH for a, b in itertools.pairwise(found))
    assert list(interim_looks(5)) == [5]
    assert list(interim_looks(100)) == [20, 30, 45, 67, 100]
    assert list(interim_looks(20)) == [20]


@pytest.mark.parametrize(("words", "near", "far"), [("+-5%", 0.049, 0.051), ("+-0.5", 0.049, 0.051)])
def test_the_wider_side_of_the_interval_is_within_the_width(words, near, far):
    """Below eight values the interval is the range, of a median of 10; a negative one has the same width."""
    rule = StoppingRule.parsed(f"median offset_error {words}")
    for sign in (1.0, -1.0):
        for low, high, enough in ((near, near, True), (far, near, False), (near, far, False)):
            values = sign * np.array([10.0 * (1 - low), 10.0, 10.0 * (1 + high)])
            assert rule.reached([values]) is enough
    assert not rule.reached([np.full(3, 10.0), np.array([5.0, 10.0, 15.0])])


def test_the_median_is_as_near_as_was_asked_when_it_ends():
    """The interval holds at every look, so the look that ends a comparison costs no coverage."""
    rule, near, trials = StoppingRule.parsed("median offset_error +-10%"), 0, []
    for _ in range(300):
        values = RNG.lognormal(0.0, 0.5, size=2000)
        n = next(n for n in interim_looks(2000) if rule.reached([values[:n]]))
        near += abs(median(values[:n]).value - 1.0) <= 0.1
        trials.append(n)
    assert near / 300 > 0.97
    assert 200 < np.median(trials) < 800  # 1.96 x 0.5 x sqrt(pi / 2) / sqrt(n) = 0.1 at n = 151; 1.6 times as wide: 390


def test_what_never_gives_an_estimate_ends_nothing_and_delays_nothing():
    rule = StoppingRule.parsed("median offset_error +-10%")
    assert rule.reached([np.full(20, np.inf), np.ones(20)])
    assert not rule.reached([np.r_[np.ones(12), np.full(8, np.inf)]])
