"""What a row of the speed benchmark says of its figure."""

from __future__ import annotations

import pytest

from benchmarks.measure import Row


@pytest.mark.parametrize(
    ("value", "least", "verdict"),
    [
        (0.9, True, "holds"),
        (0.8, True, "MISSED"),
        (0.8, False, "holds"),
        (0.9, False, "MISSED"),
        (None, True, "skipped"),
    ],
)
def test_a_figure_holds_on_one_side_of_its_limit_and_none_is_skipped(value, least, verdict):
    row = Row("loop", value, 0.85, least, "")
    assert row.verdict == verdict
    assert f"limit 0.85  {verdict}" in row.text(10)
