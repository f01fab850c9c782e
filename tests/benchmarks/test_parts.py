"""Every part of the speed benchmark runs, once and small, so that a changed signature is noticed."""

from __future__ import annotations

import math
from types import ModuleType

import pytest

from benchmarks import dataset, diagnosing, engines, kalman, norm, population, report
from benchmarks.__main__ import PARTS, main
from benchmarks.honesty import bench as honesty

SLOW = (engines, report, diagnosing, dataset, norm, kalman, population)
"""Parts that start other processes, or fit for more than five seconds however small they are."""


@pytest.mark.parametrize(
    "part",
    [
        pytest.param(part, marks=[pytest.mark.slow] * (part in SLOW), id=part.__name__)
        for part in (*PARTS.values(), honesty)
    ],
)
def test_a_part_runs_once_and_small(part: ModuleType) -> None:
    rows = list(part.rows(small=True))
    assert rows
    assert all(row.value is None or math.isfinite(row.value) for row in rows)
    assert all(row.what in row.text(60) for row in rows)


def test_help_and_an_unknown_part_run_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, status, words in ((["--help"], 0, "--only PART"), (["--only", "speed"], 2, "no part 'speed'")):
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        assert ended.value.code == status
        assert words in "".join(capsys.readouterr())


def test_one_part_is_run_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--only", "closed_loop", "--small"]) in (0, 1)
    assert len(capsys.readouterr().out.splitlines()) == len(list(PARTS["closed_loop"].rows(small=True)))
