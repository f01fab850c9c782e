"""An attitude that is repeated row after row: a slower navigation's, in a log of the magnetometer's rate."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from diagnosis.problem.rates import attitude_at, attitude_course
from diagnosis.problem.repeated_rows import repeated
from recordings import Recording


class Steady(NamedTuple):
    """A recording whose attitude goes on from row to row, the share that was repeated, rows (n,) after the last."""

    recording: Recording
    repeated: float
    unknown: NDArray[np.bool_]


def between_repeats(recording: Recording, policy: Policy) -> Steady:
    """The recording with its attitude (n, 4) going on between the rows in which it is new.

    Only where it is new at one pace, by a row, beside few longer rests; it stays as it is for these, but for one pace
    at their end. Nothing is known after the last. The share is 0 where nothing was done.
    """
    q, n = recording.att_q, len(recording)
    as_it_is = Steady(recording, 0.0, np.zeros(n, np.bool_))
    if q is None:
        return as_it_is
    new = np.flatnonzero(np.concatenate([[True], (np.diff(q, axis=0) != 0).any(axis=1)]))
    again = np.delete(~repeated(recording.mag_nT), new)  # a whole row that is repeated is told by the magnetometer
    rows = np.diff(new)
    pace = int(np.median(rows)) if len(rows) else 0
    share = float(min(again.sum(), (rows[rows <= pace + 1] - 1).sum())) / n
    if share <= policy.held_attitude or np.mean(np.abs(rows - pace) > 1) > policy.held_attitude:
        return as_it_is
    known = _known(new, pace)
    course = attitude_course(recording.time_s[known], q[known])
    going_on = replace(recording, att_q=attitude_at(course, recording.time_s))
    return Steady(going_on, share, np.arange(n) > known[-1])


def _known(new: NDArray[np.intp], pace: int) -> NDArray[np.intp]:
    """Rows (m,) whose attitude is known: where it is new, and in a rest all but the last pace."""
    rests = np.flatnonzero(np.diff(new) > pace + 1)
    return np.unique(np.concatenate([new, *(np.arange(new[i], new[i + 1] - pace + 1) for i in rests)]))
