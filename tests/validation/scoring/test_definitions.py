"""The list of scores, and that the scores say the same."""

from __future__ import annotations

import re

import pytest

from scenarios.errors import InputError
from validation.scoring import scores
from validation.scoring.definitions import SCORE_DEFINITIONS, score_definition
from validation.scoring.outcome import RANKED_BY


def test_a_score_is_found_with_its_unit_or_without():
    for one in SCORE_DEFINITIONS.values():
        assert score_definition(one.name) is one
        assert score_definition(one.column) is one
    assert score_definition("heading_rms_deg").unit == "deg"


def test_another_name_is_told_the_near_ones():
    with pytest.raises(InputError, match="heading_rms_deg"):
        score_definition("heading_rms_nT")


def test_the_docstring_of_the_scores_has_these_scores_and_units():
    found = re.findall(r"^    (\w+) +(nT|deg|s|)(?:  .*)?$", scores.score.__doc__ or "", re.M)
    assert {name: SCORE_DEFINITIONS[name].unit for name, _ in found} == dict(found)
    assert {RANKED_BY, "heading_rms"} <= dict(found).keys()


def test_what_ranks_is_a_score_of_a_motion_that_no_fit_has_seen():
    assert SCORE_DEFINITIONS[RANKED_BY].lower
    assert not SCORE_DEFINITIONS[RANKED_BY].in_sample
