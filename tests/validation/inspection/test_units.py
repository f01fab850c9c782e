"""Units told by the strength of field and gravity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.arrays import Array
from tests.validation.inspection.recordings import FIELD_ENU_NT, GRAVITY_M_S2, log_of, moved, noise, one
from validation.inspection.finding import Finding
from validation.inspection.log import series_of
from validation.inspection.sensor_data import derive
from validation.inspection.units import unit_findings

MOTION = moved(600)
MAG_NT = MOTION.body(FIELD_ENU_NT) + noise(600, 5.0)
STRENGTH_NT = float(np.linalg.norm(FIELD_ENU_NT))


def findings(mag: Array, **columns: Array) -> list[Finding]:
    log = replace(log_of(MOTION.time_s, mag, **columns), sources={"mag_x_nT": "bx"})
    raw = series_of(log, None)
    return unit_findings(log, derive(raw, None), raw)


@pytest.mark.parametrize(("unit", "size_nT"), [("uT", 1e3), ("G", 1e5), ("mG", 1e2)])
def test_a_field_in_another_unit_gets_the_option_that_says_so(unit: str, size_nT: float) -> None:
    """mG and uT overlap: a field of 50 uT has 500 mG, one of the two is no Earth's field."""
    found = one(findings(MAG_NT / size_nT), "strength")
    assert found.level == "warning"
    assert f"--map mag_x_nT=bx,unit={unit} --map mag_y_nT=mag_y_nT,unit={unit}" in found.text
    assert found.value == pytest.approx(STRENGTH_NT / size_nT, rel=1e-3)


def test_the_earths_field_is_named() -> None:
    found = one(findings(MAG_NT), "strength")
    assert found.level == "ok"
    assert found.value == pytest.approx(STRENGTH_NT, rel=1e-3)


def test_raw_counts_get_a_scale_that_makes_50_000_nT() -> None:
    """570,000 are no field of a magnetometer in nT, nor one of the Earth in another unit."""
    found = one(findings(MAG_NT * 12), "strength")
    scale = float(found.text.split("scale=")[1].split()[0])
    assert scale * found.value == pytest.approx(50_000, rel=0.01)


def test_a_strong_magnet_is_no_wrong_unit() -> None:
    found = one(findings(MAG_NT * 4), "strength")
    assert found.level == "warning"
    assert "a strong magnet or iron nearby" in found.text


@pytest.mark.parametrize(("unit", "gravity"), [("m/s^2", GRAVITY_M_S2), ("g", 1.0), ("mg", 1000.0)])
def test_gravity_tells_the_accelerometers_unit(unit: str, gravity: float) -> None:
    accel = MOTION.body(np.array([0.0, 0.0, gravity]))
    found = one(findings(MAG_NT, accel=accel), "gravity")
    assert found.value == pytest.approx(gravity)
    if unit == "m/s^2":
        assert found.level == "ok"
    else:
        assert f"unit={unit}" in found.text


def test_no_unit_makes_gravity_of_three() -> None:
    found = one(findings(MAG_NT, accel=MOTION.body(np.array([0.0, 0.0, 3.0]))), "gravity")
    assert found.level == "warning"
    assert "not gravity's 9.8" in found.text


def test_nothing_is_said_of_no_rows() -> None:
    log = log_of(np.full(5, np.nan), np.zeros((5, 3)))
    raw = series_of(log, None)
    assert unit_findings(log, derive(raw, None), raw) == []
