"""Run what is missing of the bench and report it.

    python -m benchmarks.diagnosis --seeds 10 --jobs 2 -o out/diagnosis-bench

Trials land one by one in trials.jsonl; the same command goes on where it was stopped.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # a trial a core; before numpy is imported
    os.environ.setdefault(_name, "1")

import argparse  # noqa: E402
import json  # noqa: E402
from pathlib import Path  # noqa: E402

from benchmarks.diagnosis.report import write_report  # noqa: E402
from benchmarks.diagnosis.trials import run, trials  # noqa: E402
from sim.pool import map_unordered  # noqa: E402

SCORED, TUNED = 2000, 0
"""First seed of the scoring set, which is run once a release, and of the tuning set."""


def main() -> None:
    """Run the trials that are not in the log yet, and report."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.diagnosis", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--tuning", action="store_true", help="the tuning seeds instead of the scoring ones")
    parser.add_argument("--only", help="kinds of trials, e.g. single,left-out")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/diagnosis-bench"))
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    log = given.out / "trials.jsonl"
    done = {row["key"]: row for row in map(json.loads, log.read_text().splitlines())} if log.exists() else {}
    first = TUNED if given.tuning else SCORED
    wanted = [t for t in trials(first, given.seeds) if not given.only or t.kind in given.only.split(",")]
    still = [trial for trial in wanted if trial.key not in done]
    with log.open("a") as file:
        for count, (trial, row) in enumerate(map_unordered(run, still, given.jobs), 1):
            done[trial.key] = row
            file.write(json.dumps(row) + "\n")
            file.flush()
            if count % 20 == 0:
                print(f"{count} of {len(still)}", flush=True)
    seeds = f"seeds {first} to {first + given.seeds - 1} ({'tuning' if given.tuning else 'scoring'})"
    write_report([done[trial.key] for trial in wanted], given.out, seeds)
    print((given.out / "report.md").read_text().split("```json")[0])


if __name__ == "__main__":
    main()
