"""What each rule and each number of the diagnosis changes: `ablate` and `sensitivity`.

    python -m benchmarks.diagnosis.ablation ablate --seeds 1 --jobs 2 -o out/ablation
    python -m benchmarks.diagnosis.ablation sensitivity --seeds 1 --drawn 60 --most 4 -o out/ablation

`ablate` runs the trials of the tuning seeds, and each trial again without each rule that had a say in it.
`sensitivity` runs some of them and notes which comparisons each number would turn, halved or doubled; those trials are
run again with that value. Trials land one by one; the same command goes on where it was stopped, and writes the table
of what has landed.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # a trial a core; before numpy is imported
    os.environ.setdefault(_name, "1")

import argparse  # noqa: E402
import random  # noqa: E402
from collections.abc import Iterator, Sequence  # noqa: E402
from dataclasses import dataclass, replace  # noqa: E402
from operator import attrgetter  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

from benchmarks.diagnosis.margins import LIMITS, watched_policy  # noqa: E402
from benchmarks.diagnosis.resumed import resumed  # noqa: E402
from benchmarks.diagnosis.rules import RULES, watched  # noqa: E402
from benchmarks.diagnosis.score import misses  # noqa: E402
from benchmarks.diagnosis.trials import Trial, run, trials  # noqa: E402
from diagnosis.policy import STANDARD, Policy  # noqa: E402
from scenarios.errors import InputError  # noqa: E402

FACTORS = (0.5, 2.0)
"""A number of the policy is tried at its value times each of these."""
MOST = 40
"""Trials in which one rule is off, or one number another, at most."""
DRAWN = 60
"""Trials in which the numbers are watched."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Changed:
    """A trial with a rule off or a number of the policy multiplied."""

    trial: Trial
    rule: str = ""
    number: str = ""
    factor: float = 1.0

    @property
    def what(self) -> str:
        """What is changed; empty for the diagnosis as it is."""
        return self.rule or (f"{self.number} x {self.factor:g}" if self.number else "")

    @property
    def key(self) -> str:
        """Tells the changed trial from every other."""
        return f"{self.trial.key} [{self.what}]"

    def policy(self) -> Policy:
        """The policy with the number multiplied; whole numbers stay whole."""
        if not self.number:
            return STANDARD
        return replace(STANDARD, **{self.number: multiplied(getattr(STANDARD, self.number), self.factor)})


def multiplied(value: Any, factor: float) -> Any:
    """A number, or each of several, times a factor; a whole number at least one and never the same."""
    if isinstance(value, tuple):
        return tuple(multiplied(one, factor) for one in value)
    return max(1, round(value * factor)) if isinstance(value, int) else value * factor


def run_changed(changed: Changed) -> Row:
    """The row of a changed trial, with the calls in which each rule had a say; a failure is an answer too."""
    with watched(changed.rule) as fired:
        row = _row(changed.trial, changed.policy())
    return row | {"key": changed.key, "what": changed.what, "fired": {name: n for name, n in fired.items() if n}}


def run_watched(changed: Changed) -> Row:
    """The row of a trial as it is, with the numbers and factors that would turn one of its comparisons."""
    with watched_policy(FACTORS) as (policy, turned):
        row = _row(changed.trial, policy)
    return row | {"key": changed.key, "what": "", "turned": sorted(map(list, turned))}


def _row(trial: Trial, policy: Policy) -> Row:
    try:
        return run(trial, policy)
    except (ArithmeticError, AssertionError, InputError, LookupError, TypeError, ValueError) as error:
        return {"kind": trial.kind, "verdict": "failed", "names": [], "error": repr(error)[:200]}


def ablated(plain: Sequence[Changed], most: int, out: Path, jobs: int) -> list[Row]:
    """Rows as they are, then without each rule in up to `most` trials in which the rule had a say."""
    rows = resumed(plain, out / "plain", run_changed, attrgetter("key"), jobs)
    wanted = [
        Changed(one.trial, rule)
        for rule in RULES
        for one in _drawn([one for one, row in zip(plain, rows, strict=True) if rule in row["fired"]], most)
    ]
    return rows + resumed(wanted, out / "without", run_changed, attrgetter("key"), jobs)


def varied(plain: Sequence[Changed], most: int, out: Path, jobs: int) -> list[Row]:
    """Rows as they are, then with each number halved and doubled, in up to `most` trials with a comparison that turns.

    A number that is not watched, such as a count, is tried in the first trials.
    """
    rows = resumed(plain, out / "watched", run_watched, attrgetter("key"), jobs)
    wanted = [
        Changed(one.trial, number=number, factor=factor)
        for number in LIMITS
        for factor in FACTORS
        for one in _turned(number, factor, plain, rows)[:most]
    ]
    return rows + resumed(wanted, out / "numbers", run_changed, attrgetter("key"), jobs)


def _turned(number: str, factor: float, plain: Sequence[Changed], rows: Sequence[Row]) -> list[Changed]:
    """The trials in which a number times a factor turns a comparison; all of them for a number not watched."""
    if not isinstance(getattr(STANDARD, number), float):
        return list(plain)
    return [one for one, row in zip(plain, rows, strict=True) if [number, factor] in row["turned"]]


def _drawn(some: Sequence[Changed], most: int) -> list[Changed]:
    """At most so many of them, drawn by their keys alone."""
    return sorted(some, key=lambda one: random.Random(one.trial.key).random())[:most]


def table(rows: Sequence[Row]) -> Iterator[str]:
    """Lines: what was changed, in how many trials it had a say, other answers, to right and to wrong."""
    plain = {_trial_of(row): row for row in rows if not row["what"]}
    say = _say(list(plain.values()))
    yield "| changed | had a say in | run again | other answers | to right | to wrong | failed |"
    yield "|---|---|---|---|---|---|---|"
    for what in dict.fromkeys(row["what"] for row in rows if row["what"]):
        counts = _counts([(plain[_trial_of(row)], row) for row in rows if row["what"] == what])
        yield "| " + " | ".join([what, str(say.get(what, "")), *map(str, counts)]) + " |"
    yield from (f"| {what} | 0 | | | | | |" for what, times in say.items() if not times)


def _say(plain: Sequence[Row]) -> dict[str, int]:
    """The number of trials in which each rule had a say, or each number, halved or doubled, turns a comparison."""
    if any("fired" in row for row in plain):
        return {rule: sum(rule in row["fired"] for row in plain) for rule in RULES}
    changed = [(number, factor) for number in LIMITS for factor in FACTORS]
    return {f"{n} x {f:g}": sum([n, f] in row["turned"] for row in plain) for n, f in changed}


def _trial_of(row: Row) -> str:
    """Key of the trial that a row is of, changed or not."""
    return str(row["key"].partition(" [")[0])


def _counts(pairs: Sequence[tuple[Row, Row]]) -> tuple[int, ...]:
    """Of rows before and after: how many, other answers, changed to right, changed to wrong, failed."""
    other = sum(_told(before) != _told(after) for before, after in pairs)
    right = sum(misses(before) and not _fails(after) for before, after in pairs)
    wrong = sum(not misses(before) and _fails(after) for before, after in pairs)
    return len(pairs), other, right, wrong, sum(after["verdict"] == "failed" for _, after in pairs)


def _told(row: Row) -> tuple[Any, ...]:
    """What a person is told: the verdict and the names with their look-alikes."""
    return row["verdict"], [(name, sorted(others)) for name, others, _ in row["names"]]


def _fails(row: Row) -> bool:
    return row["verdict"] == "failed" or misses(row)


def main() -> None:
    """Run what is missing, and write the table."""
    given = _arguments().parse_args()
    kinds = given.only.split(",") if given.only else ()
    plain = [Changed(trial) for trial in trials(given.first, given.seeds) if not kinds or trial.kind in kinds]
    if given.what == "ablate":
        rows = ablated(plain, given.most, given.out, given.jobs)
    else:
        rows = varied(_drawn(plain, given.drawn), given.most, given.out, given.jobs)
    path = given.out / f"{given.what}.md"
    path.write_text("\n".join(table(rows)) + "\n")
    print(path.read_text())


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.diagnosis.ablation", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("what", choices=("ablate", "sensitivity"))
    parser.add_argument("--first", type=int, default=0, help="first tuning seed")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--most", type=int, default=MOST, help="trials run again for one rule or number at most")
    parser.add_argument("--drawn", type=int, default=DRAWN, help="trials in which the numbers are watched")
    parser.add_argument("--only", help="kinds of trials, e.g. single,left-out")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/ablation"))
    return parser


if __name__ == "__main__":
    main()
