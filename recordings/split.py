"""The parts of a split dataset, training, validation and test, and the part of each run."""

from __future__ import annotations

import math
import re
from functools import lru_cache

import numpy as np
from pydantic import ConfigDict, NonNegativeInt, ValidationError
from pydantic.dataclasses import dataclass

from scenarios.errors import InputError
from scenarios.seeds import stream

PARTS = ("train", "validation", "test")
PERCENT = 100
_SHARES = re.compile(r"(\d{1,3})/(\d{1,3})/(\d{1,3})")
Shares = tuple[int, ...]


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class Split:
    """Shares of the runs in per cent, and the seed of the order in which the runs are dealt out.

    The runs fall into blocks of equal order, drawn by the seed. For every n, each part's share of the first n runs is
    exact to less than one run: a growing dataset keeps the shares, and no run moves to a different part.
    """

    train: NonNegativeInt
    validation: NonNegativeInt
    test: NonNegativeInt
    seed: NonNegativeInt

    def __post_init__(self) -> None:
        if self.train + self.validation + self.test != PERCENT:
            raise ValueError(f"the shares do not add up to {PERCENT} per cent")

    @property
    def _order(self) -> tuple[int, ...]:
        """The part of each run of a block."""
        return _block((self.train, self.validation, self.test), self.seed)

    def part_of(self, run: int) -> str:
        """Return the part of a run."""
        return PARTS[self._order[run % len(self._order)]]

    def counts(self, runs: int) -> dict[str, int]:
        """Return the number of runs of each part, among the first `runs`."""
        blocks, rest = divmod(runs, len(self._order))
        return {part: blocks * self._order.count(k) + self._order[:rest].count(k) for k, part in enumerate(PARTS)}

    def index_of(self, run: int) -> int:
        """Return how many runs of the same part come before a run."""
        return self.counts(run)[self.part_of(run)]

    def run_of(self, part: str, index: int) -> int:
        """Return the run with `index` runs of the same part before it."""
        places = [place for place, one in enumerate(self._order) if one == PARTS.index(part)]
        block, place = divmod(index, len(places))
        return block * len(self._order) + places[place]


def split_from(text: str, seed: int) -> Split:
    """Return the split of `--split`, such as "80/10/10"; InputError unless the shares add up to 100."""
    match = _SHARES.fullmatch(text.strip())
    train, validation, test = map(int, match.groups()) if match else (0, 0, 0)
    try:
        return Split(train, validation, test, seed)
    except ValidationError:
        what = f"{text!r} is not three shares of {PERCENT} per cent"
        raise InputError(what, where="--split", do="give train/validation/test, e.g. 80/10/10") from None


@lru_cache(maxsize=8)
def _block(shares: Shares, seed: int) -> tuple[int, ...]:
    """Return the order of a block of whole shares, the shortest; drawn from the orders that keep every share exact."""
    rng = stream(seed, 0, "split")
    weights = tuple(share // math.gcd(*shares) for share in shares)
    taken, order = (0,) * len(shares), list[int]()
    for _ in range(sum(weights)):
        choices = [part for part in range(len(shares)) if _can_go_on(_with(taken, part), weights)]
        chances = np.array([weights[part] for part in choices])
        order.append(int(rng.choice(choices, p=chances / chances.sum())))
        taken = _with(taken, order[-1])
    return tuple(order)


def _can_go_on(taken: Shares, weights: Shares) -> bool:
    """Return whether the block can be completed with every share exact to less than one run all along.

    The remaining runs are jobs of unit length, done in the order of their deadlines: if the order of deadlines misses
    a deadline, every order does.
    """
    while _in_time(taken, weights):
        if sum(taken) == sum(weights):
            return True
        may = [part for part in range(len(taken)) if _in_advance(taken, weights, part) < sum(weights)]
        taken = _with(taken, min(may, key=lambda part: _due(taken[part] + 1, weights[part], sum(weights))))
    return False


def _in_time(taken: Shares, weights: Shares) -> bool:
    """Return whether every part is less than one run behind or ahead of its share."""
    n, whole = sum(taken), sum(weights)
    return all(abs(have * whole - n * weight) < whole for have, weight in zip(taken, weights, strict=True))


def _in_advance(taken: Shares, weights: Shares, part: int) -> int:
    """Return the lead of a part over its share after the next run, in runs times the sum of the weights."""
    return (taken[part] + 1) * sum(weights) - (sum(taken) + 1) * weights[part]


def _due(job: int, weight: int, whole: int) -> int:
    """Return the number of runs after which a part must have its j-th run: ceil(j W / w)."""
    return -(-job * whole // weight)


def _with(taken: Shares, part: int) -> Shares:
    return tuple(have + (k == part) for k, have in enumerate(taken))
