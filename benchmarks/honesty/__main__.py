"""Run with ``python -m benchmarks.honesty --logs 2000 --jobs 2``: a table by disturbance, and the shares with bars."""

from __future__ import annotations

import argparse

from benchmarks.honesty.bench import LOGS, each_of, rows_of, table, verdicts
from benchmarks.honesty.logs import DISTURBANCES


def main() -> None:
    """Print the table and the shares; with --show also what was told of each log that misses a bar."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=LOGS)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", choices=DISTURBANCES, nargs="*", default=list(DISTURBANCES))
    parser.add_argument("--show", action="store_true")
    asked = parser.parse_args()
    found = verdicts(each_of(asked.logs), asked.jobs, asked.only)
    print("\n".join(table(found)))
    if set(asked.only) == set(DISTURBANCES):
        print("\n".join(row.text(45) for row in rows_of(found)))
    for one in found if asked.show else ():
        if one.wrong or not one.explained or not one.agree or (one.disturbance == "sound" and not one.ok):
            marks = f"{'WRONG ' * one.wrong}{'unnamed ' * (not one.explained)}{'DISAGREE ' * (not one.agree)}"
            print(f"{one.disturbance}: {marks}{one.status}, {one.error:.3g} nT, d2 {one.squared:.3g}: {one.told[:400]}")


if __name__ == "__main__":
    main()
