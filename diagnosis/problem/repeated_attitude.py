"""Interpolation of an attitude repeated over several rows, as logged from a slower navigation system."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from diagnosis.problem.rates import attitude_at, attitude_course
from diagnosis.problem.repeated_rows import repeated
from recordings import Recording


class ContinuousAttitude(NamedTuple):
    """A recording with interpolated attitude, the share of repeated rows, and rows (n,) after the last value."""

    recording: Recording
    repeated: float
    unknown: NDArray[np.bool_]


def interpolate_attitude(recording: Recording, policy: Policy) -> ContinuousAttitude:
    """The recording with its attitude (n, 4) interpolated between the rows with new values.

    Requires new values at a constant interval, within a row, and few longer rests. In a rest the attitude is constant
    up to one interval before the end. After the last value the attitude is unknown. The share is 0 where nothing was
    interpolated.
    """
    q, n = recording.att_q, len(recording)
    as_it_is = ContinuousAttitude(recording, 0.0, np.zeros(n, np.bool_))
    if q is None:
        return as_it_is
    new = np.flatnonzero(np.concatenate([[True], (np.diff(q, axis=0) != 0).any(axis=1)]))
    again = np.delete(~repeated(recording.mag_nT), new)  # a whole row that is repeated is told by the magnetometer
    rows = np.diff(new)
    pace = int(np.median(rows)) if len(rows) else 0
    share = float(min(again.sum(), (rows[rows <= pace + 1] - 1).sum())) / n
    if share <= policy.little or np.mean(np.abs(rows - pace) > 1) > policy.little:
        return as_it_is
    known = _known(new, pace)
    course = attitude_course(recording.time_s[known], q[known])
    going_on = replace(recording, att_q=attitude_at(course, recording.time_s))
    return ContinuousAttitude(going_on, share, np.arange(n) > known[-1])


def _known(new: NDArray[np.intp], pace: int) -> NDArray[np.intp]:
    """Rows (m,) with known attitude: new values, and rests except for their last interval."""
    rests = np.flatnonzero(np.diff(new) > pace + 1)
    return np.unique(np.concatenate([new, *(np.arange(new[i], new[i + 1] - pace + 1) for i in rests)]))
