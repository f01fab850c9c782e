"""The page of the method: its limits are the policy's, its pictures what the program finds."""

from __future__ import annotations

import re

import method
import pytest
import shown

from diagnosis.policy import STANDARD

LIMIT = re.compile(r"`(\w+) = ([\d.]+)`")
MOST_LINES, MOST_WORDS, STEPS = 115, 1700, 9


def test_each_limit_is_the_policys() -> None:
    told = LIMIT.findall(method.PAGE.read_text(encoding="utf-8"))
    known = STANDARD.numbers()
    assert len(told) > 20
    assert not [(name, value) for name, value in told if known.get(name) != float(value)]


def test_the_page_is_short_and_has_a_part_for_each_step_of_its_picture() -> None:
    text = method.PAGE.read_text(encoding="utf-8")
    drawn = {int(words[0]) for words in method.flow_words() if words[0].isdigit()}
    assert re.findall(r"^## (\d)\.", text, re.MULTILINE) == [str(step) for step in sorted(drawn)]
    assert len(drawn) == STEPS
    assert len(text.splitlines()) <= MOST_LINES
    assert len(text.split()) <= MOST_WORDS


def test_the_flow_shows_the_limits_of_today() -> None:
    assert shown.kept()["method"][method.FLOW]["words"] == method.flow_words(), "run `make pictures`"


@pytest.mark.slow
def test_the_pictures_show_what_the_program_finds_today() -> None:
    if shown.kept()["names"] != shown.names():
        pytest.skip("effects or calibrators were added since the pictures were made: run `make pictures`")
    now, made = method.kept(), shown.kept()["method"]
    old = {name: shown.changed(parts, now.get(name, {})) for name, parts in made.items()}
    assert not {name: parts for name, parts in old.items() if parts}, "run `make pictures`"
