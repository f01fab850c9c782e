"""Numbers in sentences: what a reader would write by hand."""

from __future__ import annotations

import pytest

from validation.text import (
    all_of,
    counted,
    digits,
    duration,
    figure,
    figures,
    frequency,
    listed,
    measured,
    plainly,
    quantity,
    sentence,
    short,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (-0.0, "0"), (1234.5, "1234"), (12.345, "12.3"), (12.0, "12"), (-0.0012, "-0.0012"),
     (1.5e-7, "1.5e-7"), (2.5e9, "2.5e9"), (9.999, "10"), (1e6, "1e6"), (999.96, "1000"),
     (float("nan"), "–"), (float("-inf"), "–")],
)  # fmt: skip
def test_figure(value: float, text: str) -> None:
    assert figure(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1234.5, "1234"), (12.345, "12.3"), (-0.00123456, "−0.00123"), (1.5e-7, "1.50e−7"),
     (float("nan"), "–"), (float("inf"), "–"), (2.5e9, "2.50e9"), (9.999, "10.0"), (99_960.0, "99960"), (12.0, "12.0")],
)  # fmt: skip
def test_digits_keep_what_was_measured(value: float, text: str) -> None:
    assert digits(value) == text


def test_given_numbers_stay_as_given() -> None:
    assert plainly(-50_000.5) == "−50000.5"
    assert plainly(3) == "3"
    assert [plainly(123_456.789), plainly(12_345_678.0)] == ["123456.8", "1.234568e7"]


def test_a_degree_follows_its_number_and_other_units_a_space() -> None:
    assert [quantity(1234.5, "nT"), quantity(0.021, "deg"), quantity(0.5, "")] == ["1234 nT", "0.021°", "0.5"]


def test_a_clause_becomes_a_sentence() -> None:
    assert [sentence("use it: 1 nT"), sentence("")] == ["Use it: 1 nT.", "."]


def test_figures_are_one_where_all_are_the_same() -> None:
    assert figures([5.0, 5.001, 5.002]) == "5"
    assert figures([1.0, 2.0, 30_000.0]) == "1, 2 and 30000"


def test_listed() -> None:
    assert [listed(["a", "b", "c"][:k]) for k in range(4)] == ["", "a", "a and b", "a, b and c"]


@pytest.mark.parametrize(("number", "text"), [(0, "no gap"), (1, "1 gap"), (2, "2 gaps"), (1500, "1500 gaps")])
def test_counted(number: int, text: str) -> None:
    assert counted(number, "gap") == text


def test_two_are_both() -> None:
    assert [all_of(number, "runs") for number in (2, 3)] == ["both runs", "all 3 runs"]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.02, "20 ms"), (0.0, "0 s"), (1.5, "1.5 s"), (119.0, "119 s"), (120.0, "2 min"), (7200.0, "2 h"),
     (172_800.0, "2 d")],
)  # fmt: skip
def test_duration(seconds: float, text: str) -> None:
    assert duration(seconds) == text


@pytest.mark.parametrize(
    ("hertz", "text"), [(50.0, "50 Hz"), (0.1, "one in 10 s"), (0.001, "one in 16.7 min"), (0.0, "0 Hz")]
)
def test_frequency(hertz: float, text: str) -> None:
    assert frequency(hertz) == text


@pytest.mark.parametrize(
    ("value", "half", "text"),
    [(5209.42, 38.2, "5209 ± 38"), (-3.2, 0.0421, "-3.200 ± 0.042"), (-0.04, 28.1, "0 ± 28"),
     (7171.3, 3301.0, "7171 ± 3301"), (1.23, 1e-7, "1.23 ± 1e-7"), (1.23, float("nan"), "1.23"), (1.23, 0.0, "1.23")],
)  # fmt: skip
def test_a_measured_value_has_the_decimals_of_its_interval(value: float, half: float, text: str) -> None:
    assert measured(value, half) == text


def test_short_is_three_digits_of_each_number_and_a_word_as_it_is() -> None:
    assert short(12.34567) == "12.3"
    assert short(13_250.4) == "13250"
    assert short([[1.0, -2.00001e-7], "high"]) == "((1, -2e-7), high)"
