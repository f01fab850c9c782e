"""The page of verdicts: a section for each verdict, and the commands in it earn that verdict."""

from __future__ import annotations

import pytest
import shown
import verdicts

from diagnosis.verdict import Verdict


def test_every_verdict_has_a_section_with_what_the_command_says_and_a_picture() -> None:
    sections = verdicts.sections()
    assert tuple(sections) == tuple(Verdict) == tuple(verdicts.PICTURES)
    for verdict, text in sections.items():
        assert f"\nverdict: {verdict} (" in text, "run `make pictures`"
        assert f"(pictures/verdict-{verdict}.png)" in text


@pytest.mark.slow
def test_every_section_earns_its_verdict() -> None:
    found = {name: diagnosis.verdict for name, diagnosis in verdicts.diagnosed().items()}
    assert found == {name: name for name in Verdict}


@pytest.mark.slow
def test_the_verdicts_texts_and_pictures_show_what_the_program_finds_today() -> None:
    if shown.kept()["names"] != shown.names():
        pytest.skip("effects or calibrators were added since the pictures were made: run `make pictures`")
    now = verdicts.kept()
    old = {verdict: shown.changed(parts, now.get(verdict, {})) for verdict, parts in shown.kept()["verdicts"].items()}
    assert not {verdict: parts for verdict, parts in old.items() if parts}, "run `make pictures`"
