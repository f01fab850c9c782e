"""Prints every ratio with its limit, or that it was skipped; exit status 1 where one is missed.

python -m benchmarks
python -m benchmarks --only kalman,norm
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from benchmarks import (
    closed_loop,
    comparison,
    dataset,
    diagnosing,
    engines,
    gates,
    inspecting,
    kalman,
    norm,
    population,
    report,
    text_logs,
)

MODULES = (
    *(closed_loop, dataset, text_logs, norm, kalman, population),
    *(comparison, report, engines, gates, diagnosing, inspecting),
)
PARTS = {part.__name__.rpartition(".")[2]: part for part in MODULES}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the parts that are asked for, all by default, and print their rows; 1 where a limit is missed."""
    given = _arguments().parse_args(arguments)
    rows = [row for name in given.only for row in PARTS[name].rows(given.small)]
    width = max(len(row.what) for row in rows)
    for row in rows:
        print(row.text(width))
    return int(any(row.verdict == "MISSED" for row in rows))


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--only", type=_parts, default=tuple(PARTS), metavar="PART,...", help="of " + ", ".join(PARTS))
    parser.add_argument("--small", action="store_true", help="every part once and short: whether it runs, not how fast")
    return parser


def _parts(text: str) -> tuple[str, ...]:
    names = tuple(text.split(","))
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        raise argparse.ArgumentTypeError(f"no part {unknown[0]!r}, there are {', '.join(PARTS)}")
    return names


if __name__ == "__main__":
    sys.exit(main())
