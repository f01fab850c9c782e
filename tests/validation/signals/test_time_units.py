"""Time stamps of a known motion, in seconds and in finer units."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.arrays import Array
from tests.validation.inspection.recordings import FIELD_ENU_NT, moved, noise
from validation.signals.time_units import Finer, finer_unit

MOTION = moved(3000)
MAG_NT = MOTION.body(FIELD_ENU_NT) + noise(3000, 20.0)
IN_A_SECOND = {"ms": 1e3, "us": 1e6, "ns": 1e9}


def _found(factor: float, gyro: Array | None = None, q: Array | None = None) -> Finer | None:
    return finer_unit(factor * MOTION.time_s, MAG_NT, gyro, q)


@pytest.mark.parametrize("unit", IN_A_SECOND)
def test_a_gyro_is_sure_of_the_unit_and_the_fields_rate_alone_doubts(unit: str) -> None:
    factor = IN_A_SECOND[unit]
    sure = (_found(factor, MOTION.rate_rad_s, MOTION.q), _found(factor, MOTION.rate_rad_s))
    doubts = (_found(factor), _found(factor, q=MOTION.q))
    assert [one and (one.unit, one.sure) for one in (*sure, *doubts)] == [(unit, True)] * 2 + [(unit, False)] * 2


@pytest.mark.parametrize("gyro", [None, MOTION.rate_rad_s])
def test_seconds_are_seconds(gyro: Array | None) -> None:
    assert _found(1.0, gyro, MOTION.q) is None
    seldom = moved(3000, rate_hz=0.5)
    assert (
        finer_unit(seldom.time_s, seldom.body(FIELD_ENU_NT), gyro if gyro is None else seldom.rate_rad_s, None) is None
    )


def test_a_slow_turn_in_more_than_a_sample_a_second_is_slow() -> None:
    time_s = np.arange(6000) / 2
    mag_nT = 30_000.0 * np.column_stack([np.cos(5e-4 * time_s), np.sin(5e-4 * time_s), np.ones(6000)])
    assert finer_unit(time_s, mag_nT, None, None) is None
    assert _found(1e3, 30 * MOTION.rate_rad_s, MOTION.q) is None


def test_a_sensor_at_rest_tells_nothing() -> None:
    """A station that has a value a minute."""
    assert finer_unit(60.0 * np.arange(3000), FIELD_ENU_NT + noise(3000, 100.0), None, None) is None


def test_what_to_do_names_the_column_and_the_unit() -> None:
    assert Finer("ms", 2e-4, True).words("t").endswith("in ms: --map time_s=t,unit=ms.")
    assert "if the time stamps are in us, say so by --map time_s=t,unit=us" in Finer("us", 2e-7, False).words("t")
