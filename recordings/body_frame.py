"""The axes of a log turned to the recording's body frame: x forward, y left, z up (FLU)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.columns import ACCEL, ATTITUDE, GYRO, mag_names, numbers
from recordings.reading import Reading, turned_axes
from scenarios.arrays import Array

Named = Mapping[str, NDArray[Any]]
DOWN = (1.0, -1.0, -1.0)
"""Signs of x, y, z from forward, right, down to forward, left, up."""


def turned(named: Named, reading: Reading) -> dict[str, NDArray[Any]]:
    """Return the columns in FLU: the magnetometers' axes as `axes` says, then all vectors from `frame`.

    m_k = sign_k m_log,axis(k);  frame "frd": y and z of field, rate and specific force change sign, and the attitude
    FRD to NED becomes FLU to ENU.
    """
    found = dict(named)
    sensors = [mag_names(k) for k in numbers("mag", tuple(named)) or (None,)]
    if reading.axes is not None:
        order = turned_axes(str(reading.axes))
        for names in sensors:
            log = [named[name] for name in names]
            found |= {name: sign * log[axis] for name, (axis, sign) in zip(names, order, strict=True)}
    return found | (_upward(found, sensors) if reading.frame == "frd" else {})


def _upward(named: Named, sensors: Sequence[tuple[str, ...]]) -> dict[str, NDArray[Any]]:
    """Return the vectors and the attitude of a log in FRD and NED, in FLU and ENU."""
    signs = [part for names in (*sensors, GYRO, ACCEL) for part in zip(names, DOWN, strict=True)]
    found = {name: sign * named[name] for name, sign in signs if name in named}
    if not all(name in named for name in ATTITUDE):
        return found
    enu = enu_from_ned(np.column_stack([named[name] for name in ATTITUDE]))
    return found | dict(zip(ATTITUDE, enu.T, strict=True))


def flu_from_frd(vectors: Array) -> Array:
    """Return vectors (n, 3) of a body frame forward, right, down in forward, left, up."""
    return np.asarray(vectors * np.array(DOWN))


def enu_from_ned(q: Array) -> Array:
    """Return quaternions (n, 4), FRD to NED, as FLU to ENU: p q (0, 1, 0, 0) with p = (0, 1, 1, 0) / sqrt 2."""
    w, x, y, z = q.T
    return np.column_stack([-w - z, -x - y, y - x, z - w]) * math.sqrt(0.5)
