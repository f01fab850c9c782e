"""Calibrators on recordings of arrays: sensor by sensor, or the whole array once."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from calib import Reference
from calib.methods.least_squares_gradiometer import LeastSquaresGradiometer
from calib.methods.sphere import SphereCalibrator
from recordings import Recording
from validation.calibrating.fitting import fit_all
from validation.calibrating.selection import select_calibrators

REFERENCE = Reference(50_000.0)


def recording():
    rng = np.random.default_rng(0)
    field = Rotation.random(100, rng=rng).apply([0.0, 30_000.0, -40_000.0])
    array = field + rng.uniform(-100, 100, (4, 1, 3)) + rng.normal(0.0, 2.0, (4, 100, 3))
    return Recording(np.arange(100.0), array[0], array_mag_nT=array)


def test_each_sensor_by_itself_and_its_part_of_the_whole():
    measured = recording()
    results = fit_all(measured, REFERENCE, select_calibrators(["sphere", "least_squares_gradiometer"]))
    keys = [f"{name}@{k}" for name in ("sphere", "least_squares_gradiometer") for k in (1, 2, 3, 4)]
    assert list(results) == keys
    alone = SphereCalibrator().fit(measured.sensor(2), REFERENCE)
    np.testing.assert_array_equal(results["sphere@3"].offset_nT, alone.offset_nT)
    whole = LeastSquaresGradiometer().fit(measured, REFERENCE)
    for k in range(4):
        part = results[f"least_squares_gradiometer@{k + 1}"]
        np.testing.assert_array_equal(part.offset_nT, whole.array_offset_nT[k])
        assert part.array_matrix is None


def test_single_sensor_is_no_array():
    results = fit_all(recording().sensor(0), REFERENCE, select_calibrators(["least_squares_gradiometer"]))
    assert results["least_squares_gradiometer"].status.kind == "not_applicable"
