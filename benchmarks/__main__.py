"""Prints every ratio with its limit; exit status 1 where one is missed."""

from __future__ import annotations

import sys

from benchmarks import closed_loop, dataset, kalman, norm, population

if __name__ == "__main__":
    rows = [*closed_loop.rows(), *dataset.rows(), *norm.rows(), *kalman.rows(), *population.rows()]
    width = max(len(row.what) for row in rows)
    for row in rows:
        verdict = "holds" if row.holds else "MISSED"
        print(f"{row.what:{width}}  {row.value:8.3f}  limit {row.limit:g}  {verdict}  {row.note}")
    sys.exit(not all(row.holds for row in rows))
