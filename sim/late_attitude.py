"""An attitude that is logged late: each row holds the attitude of a time before."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from scenarios.arrays import Array


@dataclass
class LateAttitude:
    """Attitude a constant delay ago, block by block: ``q(t - delay)``, along the shortest way between two samples.

    Before the first sample the vehicle is taken to have rested.
    """

    delay_s: float
    _time_s: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    _q: Array = field(default_factory=lambda: np.zeros((0, 4)), repr=False)

    def of(self, time_s: Array, q: Array) -> Array:
        """Attitude (n, 4) logged at times (n,), for true unit quaternions (w, x, y, z) (n, 4) at these times."""
        if not self.delay_s:
            return q
        known_s, known_q = np.concatenate([self._time_s, time_s]), np.concatenate([self._q, q])
        self._keep(known_s, known_q)
        if len(known_s) == 1:
            return q
        between = Slerp(known_s, Rotation.from_quat(known_q[:, [1, 2, 3, 0]]))
        late = between(np.maximum(time_s - self.delay_s, known_s[0])).as_quat()[:, [3, 0, 1, 2]]
        return np.asarray(late * np.where((late * q).sum(axis=1, keepdims=True) < 0, -1.0, 1.0))

    def _keep(self, time_s: Array, q: Array) -> None:
        """Keep what a later block may need: the samples of the last delay, and one before."""
        first = max(0, int(np.searchsorted(time_s, time_s[-1] - self.delay_s, side="right")) - 1)
        self._time_s, self._q = time_s[first:], q[first:]
