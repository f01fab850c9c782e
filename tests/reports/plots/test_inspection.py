"""What the pictures of an inspection show, read back from their lines, marks and bars."""

from __future__ import annotations

from typing import Any

import allantools
import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from reports.plots.inspection import (
    draw_allan,
    draw_coverage,
    draw_low_digits,
    draw_residual,
    draw_spectrum,
    draw_strength,
)
from reports.plots.style import time_scale
from tests.validation.inspection.recordings import FIELD_ENU_NT, moved, noise, rounded, sensor_data
from validation.inspection.sensor_data import SensorData
from validation.signals.sphere import cells, directions

SAMPLES, RATE_HZ, STEP_NT, TONE_HZ = 4000, 40.0, 15.0, 13.0
MOTION = moved(SAMPLES, rate_hz=RATE_HZ)
GAP = slice(2000, 2200)


@pytest.fixture(scope="module")
def seen() -> SensorData:
    """A log with a tone on x, a gap, and a converter of 15 nT."""
    tone = 8.0 * np.sin(2 * np.pi * TONE_HZ * MOTION.time_s)[:, None] * [1.0, 0.0, 0.0]
    mag_nT = rounded(MOTION.body(FIELD_ENU_NT) + noise(SAMPLES, 5.0) + tone, STEP_NT)
    keep = np.delete(np.arange(SAMPLES), GAP)
    return sensor_data(MOTION.time_s[keep], mag_nT[keep], q=MOTION.q[keep])


def lines_of(figure: Figure, label: str) -> Any:
    return [line for axis in figure.axes for line in axis.lines if line.get_label() == label]


def test_coverage_fills_the_cells_that_were_entered(seen: SensorData) -> None:
    corrected = seen.corrected_nT
    assert corrected is not None
    entered = set(cells().index(directions(corrected)).tolist())
    upper = {k for k, (_, _, bottom, top) in enumerate(cells().edges()) if bottom + top > 0}
    axes = draw_coverage(seen).axes
    for axis, half in zip(axes, (upper, set(range(cells().total)) - upper), strict=True):
        filled, empty = [c for c in axis.collections if isinstance(c, PolyCollection)]
        assert len(filled.get_paths()) == len(entered & half)
        assert len(filled.get_paths()) + len(empty.get_paths()) == len(half)


def test_strength_over_time_with_the_gap_shaded_and_no_line_across_it(seen: SensorData) -> None:
    figure = draw_strength(seen)
    (shade,) = figure.axes[0].patches
    low, high = MOTION.time_s[GAP.start - 1], MOTION.time_s[GAP.stop]
    assert (shade.get_x(), shade.get_x() + shade.get_width()) == pytest.approx((low, high))
    for axis in figure.axes:
        for line in axis.lines:
            x = np.asarray(line.get_xdata())
            assert not (x.min() < low - 1 and x.max() > high + 1)
    assert np.median(np.asarray(lines_of(figure, "as measured")[0].get_ydata())) == pytest.approx(
        np.linalg.norm(FIELD_ENU_NT), rel=0.01
    )


def test_the_residual_is_drawn_as_it_is(seen: SensorData) -> None:
    assert seen.residual is not None
    (line,) = lines_of(draw_residual(seen), "x")
    assert np.max(np.asarray(line.get_ydata())) <= seen.residual.values[:, 0].max()


def test_the_spectrum_marks_the_tone_and_the_mains(seen: SensorData) -> None:
    """50 Hz appear at 10 in samples of 40 Hz, 60 Hz at 20."""
    axis = draw_spectrum(seen).axes[0]
    marked = sorted(float(line.get_xdata()[0]) for line in axis.lines if len(line.get_xdata()) == 2)
    assert any(abs(frequency - TONE_HZ) < 0.02 for frequency in marked)
    assert any(abs(frequency - 10.0) < 0.05 for frequency in marked)
    assert {text.get_text() for text in axis.texts} >= {f"{TONE_HZ:.4g}", " 50 Hz "}


def test_the_allan_deviation_is_that_of_allantools() -> None:
    still = sensor_data(np.arange(SAMPLES) / RATE_HZ, noise(SAMPLES, 5.0) + 2e4)
    assert still.residual is not None
    figure = draw_allan(still)
    (line,) = lines_of(figure, "x")
    tau_s, drawn = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    theirs = allantools.oadev(still.residual.values[:, 0], rate=RATE_HZ, data_type="freq", taus=tau_s)[1]
    np.testing.assert_allclose(drawn, theirs, rtol=1e-6)
    white = figure.axes[0].lines[1]
    np.testing.assert_allclose(white.get_ydata(), 5 / np.sqrt(tau_s * RATE_HZ), rtol=0.06)


def test_low_digits_are_counted(seen: SensorData) -> None:
    """In motion every digit of the converter's last four bits comes about as often."""
    for axis in draw_low_digits(seen).axes:
        heights = [bar.get_height() for bar in axis.patches]
        assert len(heights) == 16
        assert sum(heights) == len(seen.series)
        assert min(heights) > 0.7 * len(seen.series) / 16
        assert f"a code {STEP_NT:.4g} nT" in axis.get_xlabel()


@pytest.mark.parametrize(("length_s", "unit"), [(100, "s"), (1000, "min"), (20_000, "h")])
def test_time_axes_have_a_unit_that_suits(length_s: float, unit: str) -> None:
    scale, name = time_scale(np.array([5.0, 5.0 + length_s]))
    assert name == unit
    assert scale == {"s": 1.0, "min": 60.0, "h": 3600.0}[unit]
    assert time_scale(np.zeros(0)) == (1.0, "s")
