"""Run what is missing of the bench and report it.

    python -m benchmarks.diagnosis --seeds 10 --jobs 2 -o out/diagnosis-bench
    python -m benchmarks.diagnosis --tuning --seeds 2 --set alpha=0.001

Trials land one by one in trials.jsonl; the same command goes on where it was stopped. With --set a number of the
diagnosis' policy is another one, and the rows have a directory of their own.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # a trial a core; before numpy is imported
    os.environ.setdefault(_name, "1")

import argparse  # noqa: E402
from functools import partial  # noqa: E402
from operator import attrgetter  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

from benchmarks.diagnosis.report import write_report  # noqa: E402
from benchmarks.diagnosis.resumed import resumed  # noqa: E402
from benchmarks.diagnosis.trials import run, trials  # noqa: E402
from diagnosis.policy import STANDARD, changed  # noqa: E402
from scenarios.errors import InputError  # noqa: E402

SCORED, TUNED = 2000, 0
"""First seed of the scoring set, which is run once a release, and of the tuning set."""
Row = dict[str, Any]


def main() -> None:
    """Run the trials that are not in the log yet, and report."""
    given = _arguments().parse_args()
    try:
        policy = changed(STANDARD, given.set)
    except InputError as wrong:
        raise SystemExit(str(wrong)) from wrong
    out = given.out.joinpath(*sorted(given.set))  # rows of two policies never mix
    first = (TUNED if given.tuning else SCORED) + given.spent
    kinds = given.only.split(",") if given.only else None
    wanted = [trial for trial in trials(first, given.seeds) if kinds is None or trial.kind in kinds]
    rows = resumed(wanted, out, partial(run, policy=policy), attrgetter("key"), given.jobs)
    seeds = f"seeds {first} to {first + given.seeds - 1} ({'tuning' if given.tuning else 'scoring'})"
    write_report(rows, out, ", ".join([seeds, *given.set]))
    print((out / "report.md").read_text().split("```json")[0])


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.diagnosis", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--tuning", action="store_true", help="the tuning seeds instead of the scoring ones")
    parser.add_argument("--spent", type=int, default=0, help="seeds that were run before and are left out, e.g. 2")
    parser.add_argument("--only", help="kinds of trials, e.g. single,left-out")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="another number of the policy: alpha=0.001",
    )
    parser.add_argument("-o", "--out", type=Path, default=Path("out/diagnosis-bench"))
    return parser


if __name__ == "__main__":
    main()
