"""The report of a comparison: the answer comes first, every figure is there, and nothing comes from outside."""

from __future__ import annotations

import html
import re

import numpy as np
import pytest

from reports.pages.comparison import Comparison, comparison_page, point_title
from tests.reports.page import faults, figures, plots, without_scripts
from tests.validation.comparison.example import table_of
from validation.comparison.ranking import overall_sentence, rank_calibrators
from validation.scoring.definitions import SCORE_DEFINITIONS

RNG = np.random.default_rng(9)
GOOD = RNG.lognormal(0.0, 0.1, 40)


@pytest.fixture(scope="module")
def text() -> str:
    points = [{"good": k * GOOD, "<b>poor": 5 * k * GOOD, "uncorrected": 900 * k * GOOD} for k in (1.0, 4.0)]
    table = table_of(*points, sweep=[10.0, 40.0], failing=["<b>poor"])
    answers = tuple(rank_calibrators(table, SCORE_DEFINITIONS["offset_error"], point) for point in table.points)
    sentence = overall_sentence(answers, [point_title(values) for values in table.points.values()])
    return comparison_page(Comparison("somewhere", table, answers, sentence, "good", "run 3"))


def test_the_first_sentence_is_the_answer(text):
    lead = html.unescape(re.findall(r'<p class="answer">(.*?)</p>', text, re.DOTALL)[0])
    assert lead == "Use good, the best at every one of 2 points."
    assert "Use good: " in text[text.index("std_nT = 40</h2>") :]


def test_needs_nothing_from_outside_and_escapes_names(text):
    assert not re.findall(r'(?:src|href)="(?!data:|#)', without_scripts(text))
    assert "<b>poor" not in without_scripts(text)
    assert not faults(text)


def test_each_point_has_its_pictures_and_the_sweep_one(text):
    assert figures(text) == 2 * 2 + 1
    over = plots(text)[0]
    drawn = {trace["name"]: trace for trace in reversed(over["data"]) if trace["name"]}
    assert set(drawn) == {"good", "&lt;b&gt;poor", "uncorrected"}
    assert drawn["good"]["y"] == pytest.approx([np.median(GOOD), 4 * np.median(GOOD)], rel=1e-5)


def test_reasons_and_all_scores_are_told(text):
    shown = html.unescape(without_scripts(text))
    assert "flat motion" in shown
    assert SCORE_DEFINITIONS["offset_error"].explained in shown
