"""Recordings in memory: what they may be made of, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from recordings.memory import raw_columns_of
from scenarios.errors import InputError

TIME_S = np.arange(60.0)
FIELD_NT = 50_000 * np.array([[np.cos(t), np.sin(t), 0.3 * np.cos(2 * t)] for t in TIME_S])


def columns(**more: Any) -> dict[str, Any]:
    """A dict of columns that is a recording."""
    return {"time_s": TIME_S, **{f"mag_{a}_nT": FIELD_NT[:, i] for i, a in enumerate("xyz")}, **more}


def test_what_is_masked_is_not_measured() -> None:
    charge = np.ma.masked_greater(TIME_S, 40.0)
    assert np.isnan(raw_columns_of(columns(charge=charge)).named["charge"][41:]).all()


@pytest.mark.parametrize(
    ("data", "time_s", "where"),
    [
        (columns(note=[object()] * 60), None, "note"),
        (columns(note=np.array([1, object()] * 30, dtype=object)), None, "note"),
        (FIELD_NT, [[1], [2, 3]], "time_s"),
        (columns(), TIME_S, "time_s"),
    ],
)
def test_what_cannot_be_read_is_one_error(data: Any, time_s: Any, where: str) -> None:
    with pytest.raises(InputError, match=where):
        raw_columns_of(data, time_s=time_s)
