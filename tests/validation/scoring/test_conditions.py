"""Conditions on scores: what they hold for, and what is refused."""

from __future__ import annotations

import pytest

from scenarios.errors import InputError
from validation.scoring.conditions import Condition, row_names
from validation.scoring.scores import Score

SCORES = {"ellipsoid": [Score("heading_rms", 0.25, "deg"), Score("offset_error", 3.0, "nT")], "twostep": []}


@pytest.mark.parametrize(
    ("text", "fails"),
    [
        ("ellipsoid.heading_rms > 0.1", True),
        ("ellipsoid.heading_rms>0.25", False),
        ("ellipsoid.heading_rms >= 0.25", True),
        ("ellipsoid.heading_rms_deg < 0.25", False),
        ("ellipsoid.heading_rms <= 0.25 deg", True),
        ("ellipsoid.offset_error > 2.5e0 nT", True),
        ("twostep.offset_error < 1", True),  # no score is no good score
    ],
)
def test_a_condition_holds_or_does_not(text: str, fails: bool) -> None:
    assert bool(Condition.parsed(text, "--fail-if").failure(SCORES)) is fails


def test_the_line_says_what_the_score_is() -> None:
    line = Condition.parsed("ellipsoid.heading_rms > 0.1", "--fail-if").failure(SCORES)
    assert line == "ellipsoid.heading_rms is 0.25 deg, failed by --fail-if 'ellipsoid.heading_rms > 0.1'"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("ellipsoid heading_rms > 0.1", "no condition"),
        ("ellipsoid.heading_rms = 0.1", "no condition"),
        ("ellipsoid.heading_rms > wide", "no condition"),
        ("ellipsoid.heading_rms > nan", "no condition"),
        ("ellipsoid.heading > 0.1", "did you mean heading_rms_deg"),
        ("ellipsoid.heading_rms > 0.1 rad", "is in deg, not in rad"),
    ],
)
def test_what_is_no_condition_is_refused(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Condition.parsed(text, "--fail-if")


def test_a_calibrator_that_is_not_in_the_run_is_refused() -> None:
    condition = Condition.parsed("elipsoid.heading_rms > 0.1", "--fail-if")
    with pytest.raises(InputError, match="did you mean ellipsoid"):
        condition.check(row_names(["sphere", "ellipsoid"], 1))
    with pytest.raises(InputError, match="no calibrator 'ellipsoid'"):
        Condition.parsed("ellipsoid.heading_rms > 0.1", "--fail-if").check(row_names(["ellipsoid"], 2))
    Condition.parsed("ellipsoid@2.heading_rms > 0.1", "--fail-if").check(row_names(["ellipsoid"], 2))
