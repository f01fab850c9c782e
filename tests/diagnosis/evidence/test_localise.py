"""Which channels a gap goes with, in which frame, in means of what length they are asked, and how many are listed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.localise import TIME, channels, explained_share, localise
from diagnosis.policy import STANDARD
from tests.diagnosis.synthetic import problem, recording


def test_eight_channels_are_listed_at_most_the_best_first() -> None:
    posed = problem(n=1000)
    slow = posed.state.time_s[:, None] * np.ones(3) + posed.state.field_nT / 200
    found = localise(replace(posed, policy=replace(STANDARD, least_channel_share=1e-9)), slow)
    assert len(list(channels(posed))) > len(found) == 8
    assert [one.share for one in found] == sorted((one.share for one in found), reverse=True)


def test_a_channel_is_listed_that_explains_more_than_the_least_share() -> None:
    posed = problem()
    white = np.random.default_rng(1).normal(size=(4000, 3))
    assert localise(posed, white) == ()
    (best, *_) = localise(posed, white + 0.3 * np.sign(posed.state.time_s - 200)[:, None])
    for least, listed in ((0.99 * best.share, True), (1.01 * best.share, False)):
        stricter = replace(posed, policy=replace(STANDARD, least_channel_share=least))
        assert bool(localise(stricter, white + 0.3 * np.sign(posed.state.time_s - 200)[:, None])) is listed


@pytest.mark.parametrize(("n", "samples"), [(4000, 5), (1000, 2)])
def test_means_are_of_half_a_second_and_four_hundred_at_least(n: int, samples: int) -> None:
    """At ten samples a second: noise of twice a course is ``4 / samples`` of its power in means."""
    posed = problem(n=n)
    course = np.sign(posed.state.time_s - posed.state.time_s.mean())[:, None]
    residual = course + 2 * np.random.default_rng(2).normal(size=(n, 3))
    share = next(one.share for one in localise(posed, residual) if one.channel == "time_s")
    assert share == pytest.approx(1 / (1 + 4 / samples), abs=0.06)


def test_a_gap_goes_first_with_the_channel_that_drives_it() -> None:
    posed = problem(replace(recording(), channels={"pump": np.sin(0.9 * recording().time_s) > 0.3}))
    for name, values in channels(posed):
        if name != TIME and not name.startswith("field"):
            left = np.asarray(values)[:, None] * np.array([1.0, 0.5, -0.5]) / np.std(values)
            first = localise(posed, left - left.mean(axis=0))[0]
            assert first.channel == name
            assert first.share > 0.9


def test_the_share_of_a_channel_that_has_nothing_to_do_with_it_is_none() -> None:
    rng = np.random.default_rng(6)
    shares = [explained_share(rng.normal(size=800), rng.normal(size=(800, 3)), STANDARD) for _ in range(40)]
    assert max(shares) < STANDARD.least_channel_share
    assert explained_share(np.full(800, 3.0), rng.normal(size=(800, 3)), STANDARD) == 0.0


def test_an_error_of_the_earths_frame_is_told_by_its_frame() -> None:
    posed = problem()
    wave = np.sin(0.02 * posed.state.time_s)[:, None] * np.array([3.0, -2.0, 1.0])
    left = np.einsum("nji,nj->ni", posed.state.R_wb, wave)
    time = next(one for one in localise(posed, left) if one.channel == TIME)
    assert time.frame == "earth"
