"""What was run before is not run again, and rows come back in the order that was asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.diagnosis.resumed import resumed


def test_a_stopped_bench_goes_on_where_it_was(tmp_path: Path) -> None:
    ran: list[int] = []

    def run(trial: int) -> dict[str, Any]:
        ran.append(trial)
        return {"key": str(trial), "square": trial**2}

    resumed([3, 1], tmp_path / "out", run, str)
    rows = resumed([1, 2, 3], tmp_path / "out", run, str)
    assert ran == [3, 1, 2]
    assert [row["square"] for row in rows] == [1, 4, 9]
