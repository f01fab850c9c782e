"""How many trials are enough: `median offset_error_nT +-5%`, looked at at fixed numbers of trials."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.comparison.statistics import Interval, median
from validation.scoring.definitions import score_definition

FIRST_LOOK = 20
GROWTH = 1.5
"""From look to look: at most so many times more trials than were needed are run."""
FORM = re.compile(r"\s*median\s+(?P<score>\w+)\s*(?:\+-|\+/-|±)\s*(?P<width>[\d.eE+-]+?)\s*(?P<percent>%)?\s*")
EXAMPLE = '"median offset_error_nT +-5%", or +-0.2 for a width in the score\'s unit'


@dataclass(frozen=True)
class StoppingRule:
    """The median of a score (a table's column) is to be known to within a width: a part of it, or in its unit."""

    score: str
    width: float
    relative: bool

    @classmethod
    def parsed(cls, text: str) -> StoppingRule:
        """Read `median SCORE +-WIDTH` with or without %; InputError for anything else."""
        found = FORM.fullmatch(text)
        try:
            width = float(found["width"]) if found else 0.0
        except ValueError:
            width = 0.0
        if not found or not width > 0:
            raise InputError(f"{text!r} is no rule to stop by", where="--until", do=f"write {EXAMPLE}")
        relative = found["percent"] is not None
        return cls(score_definition(found["score"], "--until").column, width / 100 if relative else width, relative)

    def reached(self, columns: Iterable[Array]) -> bool:
        """Whether every column (n,), a calibrator's score at one point, has its median known well enough.

        A calibrator whose median is infinite, since it gives no estimate in half of the trials, asks for no more.
        """
        return all(self._narrow(median(values)) for values in columns)

    def _narrow(self, found: Interval) -> bool:
        if found.value == float("inf"):
            return True
        allowed = self.width * abs(found.value) if self.relative else self.width
        return max(found.high - found.value, found.value - found.low) <= allowed


def interim_looks(most: int) -> Iterator[int]:
    """Numbers of trials after which the rule is asked, up to `most`: the same however the trials are computed."""
    number = FIRST_LOOK
    while number < most:
        yield number
        number = int(number * GROWTH)
    yield most
