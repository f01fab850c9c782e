"""The times of a bag's topics on one clock: the stamps of the magnetometer."""

from __future__ import annotations

import datetime
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from recordings.readers.ros.bag import Stamps, Topic
from scenarios.arrays import Array

SAME_CLOCK_NS = 1_000_000_000
"""Stamps whose age at receipt differs by more than this from the magnetometer's are of another clock."""
REPEATED = 0.5
"""Share of stamps that repeat the last one, above which the driver does not set them."""
YEAR_2000_NS = 946_684_800 * 10**9
"""Earlier times are no date: of a simulation, or since the start."""


@dataclass(frozen=True)
class Clock:
    """The clock of a magnetometer's stamps: origin_ns is zero, lag_ns the median age of the stamps at receipt.

    A message without a stamp, or with a stamp of another clock, is dated by its receipt minus lag_ns.
    """

    origin_ns: int
    lag_ns: int

    @classmethod
    def of(cls, topic: Topic) -> Clock:
        """Return the clock of a topic."""
        lag_ns = _lag_ns(topic)
        times_ns = topic.received_ns - lag_ns
        first = int(np.min(np.where(_is_set(topic), topic.stamp_ns, times_ns))) if lag_ns else int(np.min(times_ns))
        return cls(first, lag_ns)

    def times_s(self, topic: Topic) -> Array:
        """Return the times of a topic's messages (n,), in seconds since the origin."""
        received_ns = topic.received_ns - self.lag_ns
        own = self.shares(topic)
        times_ns = np.where(_is_set(topic) & own, topic.stamp_ns, received_ns)
        return np.asarray((times_ns - self.origin_ns) * 1e-9)

    def shares(self, topic: Topic) -> bool:
        """Return whether a topic's stamps are of this clock, or not set."""
        return not _is_set(topic).any() or (_advance(topic) and abs(_lag_ns(topic) - self.lag_ns) < SAME_CLOCK_NS)


def date_of(topics: Iterable[Topic]) -> datetime.date | None:
    """Return the UTC date of the first topic with stamps since 1970, else of the first receipt; None for neither."""
    found = list(topics)
    stamps = [topic.stamp_ns[_is_set(topic)] for topic in found] + [topic.received_ns for topic in found]
    times_ns = next((int(np.median(one)) for one in stamps if len(one) and np.median(one) > YEAR_2000_NS), None)
    if times_ns is None:
        return None
    try:
        return datetime.datetime.fromtimestamp(times_ns / 1e9, datetime.UTC).date()
    except (OverflowError, ValueError, OSError):
        return None


def _is_set(topic: Topic) -> Stamps:
    return np.asarray(topic.stamp_ns > 0)


def _advance(topic: Topic) -> bool:
    """Return whether the stamps change from message to message."""
    return len(topic.stamp_ns) < 2 or float(np.mean(np.diff(topic.stamp_ns) == 0)) < REPEATED


def _lag_ns(topic: Topic) -> int:
    """Return the median age of the stamps at receipt; 0 where they are not set."""
    known = _is_set(topic)
    return int(np.median((topic.received_ns - topic.stamp_ns)[known])) if known.any() and _advance(topic) else 0
