"""Stopping rule of a comparison, `median offset_error_nT +-5%`, checked at fixed numbers of trials."""

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
"""Ratio of trials between checks, so at most GROWTH times the needed trials are run."""
FORM = re.compile(r"\s*median\s+(?P<score>\w+)\s*(?:\+-|\+/-|±)\s*(?P<width>[\d.eE+-]+?)\s*(?P<percent>%)?\s*")
EXAMPLE = '"median offset_error_nT +-5%", or +-0.2 for a width in the score\'s unit'


@dataclass(frozen=True)
class StoppingRule:
    """Stop when the interval of a score's median is within a width, relative or in the unit of the score."""

    score: str
    width: float
    relative: bool

    @classmethod
    def parsed(cls, text: str) -> StoppingRule:
        """Parse `median SCORE +-WIDTH` with or without %; InputError for any other text."""
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
        """Return whether the median of every column (n,), a calibrator's score at a point, is known to the width.

        An infinite median (no estimate in half of the trials) counts as known.
        """
        return all(self._narrow(median(values)) for values in columns)

    def _narrow(self, found: Interval) -> bool:
        if found.value == float("inf"):
            return True
        allowed = self.width * abs(found.value) if self.relative else self.width
        return max(found.high - found.value, found.value - found.low) <= allowed


def interim_looks(most: int) -> Iterator[int]:
    """Yield the numbers of trials at which the rule is checked, up to `most`, whatever the engine."""
    number = FIRST_LOOK
    while number < most:
        yield number
        number = int(number * GROWTH)
    yield most
