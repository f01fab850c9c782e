"""State of a sensor at given attitudes: a turntable without dynamics."""

from __future__ import annotations

import numpy as np

from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from sim.state import State


def state_at_attitudes(R_wb: Array, field_enu_nT: Array, interval_s: float = 1.0) -> State:
    """Return the state at attitudes R_wb (n, 3, 3), body to world, one per interval, in a uniform field (3,), nT."""
    n, still = len(R_wb), np.zeros((len(R_wb), 3))
    return State(
        interval_s * np.arange(n, dtype=float),
        interval_s,
        still,
        R_wb,
        still,
        field_enu_nT,
        np.einsum("nij,i->nj", R_wb, field_enu_nT),
        still,
        {TEMPERATURE: np.full(n, 20.0)},
    )
