"""Prints every ratio with its limit, or that it was skipped; exit status 1 where one is missed."""

from __future__ import annotations

import sys

from benchmarks import closed_loop, dataset, gates, kalman, norm, population

if __name__ == "__main__":
    rows = [*closed_loop.rows(), *dataset.rows(), *norm.rows(), *kalman.rows(), *population.rows(), *gates.rows()]
    width = max(len(row.what) for row in rows)
    for row in rows:
        print(row.text(width))
    sys.exit(any(row.verdict == "MISSED" for row in rows))
