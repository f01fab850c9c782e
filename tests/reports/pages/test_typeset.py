"""Texts as pages show them: code, signs and units typeset, all else as it was."""

from __future__ import annotations

import pytest

from reports.pages.typeset import breakable, coded, columns_of_text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (
            "give `--unit uT` or --field-enu-nT E,N,U",
            "give <code>--unit uT</code> or <code>--field-enu-nT</code> E,N,U",
        ),
        ("(direction -0.30, 0.25)", "(direction −0.30, 0.25)"),
        ("-8013 ± 22", "−8013 ± 22"),
        ("on 2024-05-01, run-00003, 1e-5, 10-20", "on 2024-05-01, run-00003, 1e-5, 10-20"),
        ("5 nT, 74 % and 3 minutes, 12 of 20", "5\xa0nT, 74\xa0% and 3 minutes, 12 of 20"),
        ("0.05 deg of a <b>", "0.05° of a &lt;b&gt;"),
        ("`set x=-1`", "<code>set x=-1</code>"),
    ],
)
def test_numbers_and_code_are_typeset_and_dates_names_and_commands_stay(text: str, shown: str) -> None:
    assert str(coded(text)) == shown


def test_what_is_typeset_once_or_is_no_text_stays() -> None:
    assert coded(coded("-1 `a`")) == coded("-1 `a`")
    assert coded(3) == 3


def test_a_name_breaks_at_its_words() -> None:
    assert str(breakable("vector_least_squares <1.5")) == "vector_<wbr>least_<wbr>squares &lt;1.5"


def test_columns_of_sentences_stand_at_the_left() -> None:
    rows = [("x", "1.2° [0.9, 1.7]", "rms of the corrected field"), ("y", "16.5 nT", "–")]
    assert columns_of_text(rows) == {0, 2}
