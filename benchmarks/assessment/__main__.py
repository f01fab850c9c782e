"""Run with ``python -m benchmarks.assessment --logs 400 --jobs 2``: coverage by group, and figures with their bars."""

from __future__ import annotations

import argparse

from benchmarks.assessment.bench import all_judged, rows_of, table
from benchmarks.assessment.logs import SCORING, TUNING


def main() -> None:
    """Print table and figures; --tuning: of the seeds that the statistics were chosen on; --show: outside intervals."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=400)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--tuning", action="store_true")
    parser.add_argument(
        "--simple", action="store_true", help="logs of the bench's own generator, without the simulator"
    )
    parser.add_argument("--show", action="store_true")
    asked = parser.parse_args()
    bank = TUNING if asked.tuning else SCORING
    found = all_judged(asked.logs, asked.jobs, bank, catalogue=not asked.simple)
    print("\n".join([*table(found), *(row.text(28) for row in rows_of(found))]))
    for one in found if asked.show else ():
        if one.recommended and not one.inside:
            print(one.seed, one.name, f"{one.true_deg:.3g} {one.value_deg:.3g} {one.rank:.3f}", *one.tags)


if __name__ == "__main__":
    main()
