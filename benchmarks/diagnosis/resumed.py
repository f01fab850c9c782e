"""Trials that land in trials.jsonl as they end, so that the same command goes on where it was stopped."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from sim.pool import map_unordered

T = TypeVar("T")
TOLD = 20
"""Trials between two words of how far it is."""


def resumed(
    wanted: Sequence[T], out: Path, run: Callable[[T], dict[str, Any]], key: Callable[[T], str], jobs: int = 1
) -> list[dict[str, Any]]:
    """The rows of trials, in their order; those that the log in `out` does not hold are run and put there.

    key : what tells a trial from every other, which is its row's "key" too. One job is run in this process.
    """
    out.mkdir(parents=True, exist_ok=True)
    log = out / "trials.jsonl"
    done = {row["key"]: row for row in map(json.loads, log.read_text().splitlines())} if log.exists() else {}
    still = [one for one in wanted if key(one) not in done]
    with log.open("a") as file:
        for count, (one, row) in enumerate(map_unordered(run, still, jobs), 1):
            done[key(one)] = row
            file.write(json.dumps(row) + "\n")
            file.flush()
            if count % TOLD == 0:
                print(f"{count} of {len(still)}", file=sys.stderr, flush=True)
    return [done[key(one)] for one in wanted]
