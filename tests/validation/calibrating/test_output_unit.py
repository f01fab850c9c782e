"""Offset and matrix in another unit correct a measurement in that unit as the calibration corrects nT."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from calib import Calibration, Status
from recordings.reading import Reading
from scenarios.errors import InputError
from validation.calibrating.calibration_file import write_calibrations
from validation.calibrating.export import exported
from validation.calibrating.output_unit import output_unit

MATRIX = np.array([[0.95, 0.02, -0.01], [0.02, 1.05, 0.03], [-0.01, 0.03, 1.01]])
OFFSET_NT = np.array([12_000.0, -8_000.0, 25_000.0])
FIT = Calibration(name="ellipsoid", status=Status("ok"), offset_nT=OFFSET_NT, matrix=MATRIX)
MEASURED_NT = np.array([21_000.0, -9_000.0, -40_000.0])
FIELD_NT = MATRIX @ (MEASURED_NT - OFFSET_NT)
COUNTED = Reading(maps=("mag_x_nT=bx,scale=14.6", "mag_y_nT=by,scale=-14.6", "mag_z_nT=bz,scale=13.1"))


@pytest.mark.parametrize(
    ("text", "reading", "nT_of_measured", "nT_of_field"),
    [
        ("uT", Reading(), 1e3, 1e3),
        ("mG", Reading(), 1e2, 1e2),
        ("counts=14.6", Reading(), 14.6, 1.0),
        ("counts", COUNTED, [14.6, 14.6, 13.1], 1.0),
        ("log", COUNTED, [14.6, 14.6, 13.1], 1.0),
        ("log", Reading(mag=("bx", "by", "bz"), unit="uT"), 1e3, 1e3),
        ("log", Reading(maps=tuple(f"mag_{a}_nT=b{a},unit=mG" for a in "xyz")), 1e2, 1e2),
        ("counts", Reading(unit="count"), 1.0, 1.0),
    ],
)
def test_a_measurement_in_the_unit_gives_the_field(
    text: str, reading: Reading, nT_of_measured: float | list[float], nT_of_field: float
) -> None:
    unit = output_unit(text, reading)
    measured = MEASURED_NT / np.array(nT_of_measured)
    found = unit.matrix(FIT) @ (measured - unit.offset(FIT))
    np.testing.assert_allclose(nT_of_field * found, FIELD_NT, rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("log", "the log's unit is not stated"),
        ("counts", "the size of a count is not stated"),
        ("counts=0", "no size of a count"),
        ("counts=x", "no size of a count"),
        ("furlong", "no unit"),
        ("uT=3", "no unit"),
    ],
)
def test_what_is_not_known_is_asked_for(text: str, said: str) -> None:
    with pytest.raises(InputError, match=rf"--unit-out: .*{said}"):
        output_unit(text, Reading())


def test_the_c_header_and_a_file_are_in_counts(tmp_path: Path) -> None:
    unit = output_unit("counts=14.6", Reading())
    text = exported(FIT, "c", unit=unit)[1]
    assert "h = MAG_MATRIX (m - MAG_OFFSET_COUNTS), h in nT, m in counts" in text
    numbers = [float(v) for v in re.findall(r"(-?[0-9.]+(?:e[+-][0-9]+)?)f", text)]
    np.testing.assert_allclose(numbers, [*(OFFSET_NT / 14.6), *(14.6 * MATRIX).ravel()], rtol=1e-8)
    flat = Calibration(name="sphere", status=Status("unobservable", "flat"))
    write_calibrations({"ellipsoid": FIT, "sphere": flat}, tmp_path, unit=unit)
    table = json.loads((tmp_path / "calibration_in_counts.json").read_text())
    assert (table["unit"], table["field_unit"]) == ("counts", "nT")
    np.testing.assert_allclose(table["calibrations"]["ellipsoid"]["offset"], OFFSET_NT / 14.6)
    assert table["calibrations"]["sphere"] is None
