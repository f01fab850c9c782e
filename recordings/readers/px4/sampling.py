"""Topics of a PX4 log at the times of another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from recordings.readers.px4.contents import UlogTopic
from recordings.streams import MAX_GAP_INTERVALS, Interpolation, covered, interpolated, ordered_rows, own_interval_s
from scenarios.arrays import Array

SAMPLE_TIME = "timestamp_sample"
LONGEST_DELAY_S = 1.0
"""A time of sampling that differs by more from the time of publication is not used."""


def sample_times_s(topic: UlogTopic) -> Array:
    """Return the times (n,) at which a topic's quantities were sampled, in s; of publication where it has no others."""
    published_s = topic.times_s()
    if SAMPLE_TIME not in topic:
        return published_s
    sampled_s = topic.times_s(SAMPLE_TIME)
    return np.where(np.abs(sampled_s - published_s) < LONGEST_DELAY_S, sampled_s, published_s)


def held(at_s: Array, times_s: Array, values: Array, before: float = 0.0) -> Array:
    """Return the last of the values (n,) at times (m,); `before` the first."""
    rows, _ = ordered_rows(times_s)
    place = np.searchsorted(times_s[rows], at_s, "right") - 1
    return np.where(place < 0, before, np.r_[before, values[rows]][place + 1])


def between(at_s: Array, times_s: Array, values: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return values (n, k) at times (m,), and at which of these times, away from gaps, they are known."""
    rows, _ = ordered_rows(times_s)
    times_s, values = times_s[rows], values[rows]
    if not len(times_s):
        return np.full((len(at_s), values.shape[1]), np.nan), np.zeros(len(at_s), np.bool_)
    known = covered(at_s, times_s, Interpolation.LINEAR, MAX_GAP_INTERVALS * own_interval_s(times_s))
    return np.asarray(interpolated(at_s, times_s, values, Interpolation.LINEAR)), known
