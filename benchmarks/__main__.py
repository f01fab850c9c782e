"""Prints every ratio with its limit, or that it was skipped; exit status 1 where one is missed."""

from __future__ import annotations

import sys

from benchmarks import closed_loop, comparison, dataset, diagnosing, engines, gates, kalman, norm, population, text_logs

PARTS = (closed_loop, dataset, text_logs, norm, kalman, population, comparison, engines, gates, diagnosing)

if __name__ == "__main__":
    rows = [row for part in PARTS for row in part.rows()]
    width = max(len(row.what) for row in rows)
    for row in rows:
        print(row.text(width))
    sys.exit(any(row.verdict == "MISSED" for row in rows))
