"""The page of calibrations: the answer first, figures with intervals, what a failed fit cannot say as dashes."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, get
from recordings import Recording
from recordings.recording import Origin
from reports.pages.calibration import calibration_page
from reports.presentation.calibration import PresentedCalibrations, PresentedFit, interval

F_NT = Reference(48_000.0)
RNG = np.random.default_rng(2)
PHASE = np.where(np.arange(600) < 300, "turn", "cruise")
NOISE_NT = RNG.normal(0, 30, (600, 3))
FIELD_NT = Rotation.random(600, random_state=1).apply([0, 0, 48_000.0])
LOG = Recording(
    np.arange(600) * 0.1,
    FIELD_NT + np.array([1200, -800, 2500]) + NOISE_NT,
    phase=PHASE,
    origin=Origin(notes=("3 rows skipped",)),
)
LEG = "40 s of level turn"
ASSESSED: dict[str, Any] = {
    "use": "the offset",
    "quality": "good",
    "trust": "high",
    "calibrations": {
        "ellipsoid": {
            "heading_error_deg": {"value": 1.234, "low": 0.9, "high": 1.7},
            "strength_rms": {"before": 2100.0, "after_held_out": 31.4},
            "coverage": 0.83,
        }
    },
    "tolerance": {
        "answer": "undecidable",
        "causes": {"iron": 1.0, "field_model": None},
        "next_leg": LEG,
    },
}


@pytest.fixture(scope="module")
def fits() -> dict[str, Calibration]:
    return {name: get(name).fit(LOG, F_NT) for name in ("ellipsoid", "vector_least_squares")}


def presented(fits: dict[str, Calibration], assessed: dict[str, Any] = ASSESSED) -> PresentedCalibrations:
    headline = "heading within 1.2 deg [0.9, 1.7] on a level survey"
    return PresentedCalibrations.of("log.csv", fits, LOG, F_NT, assessed, "ellipsoid", headline, ("stuck: z",))


def test_the_answer_comes_first_then_figures_with_intervals(fits: dict[str, Calibration]) -> None:
    page = calibration_page(presented(fits), fits, LOG, F_NT, ("calibration.json: all figures",))
    order = ["heading within 1.2 deg", "stuck: z", "1.2° [0.9, 1.7]", "2,100 → 31.4", "good", "Undecidable"]
    places = [page.index(text) for text in order]
    assert places == sorted(places)
    assert "3 rows skipped" in page
    assert "calibration.json: all figures" in page
    assert re.search(r"<td[^>]*>turn</td>", page)


def test_the_offset_stands_with_half_of_its_interval(fits: dict[str, Calibration]) -> None:
    """The claimed standard deviation of the fit, times 1.96, read back from the text."""
    found = PresentedFit.of("ellipsoid", fits["ellipsoid"], {})
    value, half = (float(text.replace(",", "")) for text in found.offset[0].split(" ± "))
    assert value == pytest.approx(fits["ellipsoid"].offset_nT[0], abs=0.1)
    covariance = fits["ellipsoid"].offset_covariance_nT2
    assert covariance is not None
    assert half == pytest.approx(1.96 * covariance[0, 0] ** 0.5, rel=0.06)


def test_without_an_estimate_there_are_dashes(fits: dict[str, Calibration]) -> None:
    assert fits["vector_least_squares"].status.kind == "not_applicable"
    found = PresentedFit.of("vector_least_squares", fits["vector_least_squares"], {})
    assert found.offset == ("–", "–", "–")
    assert (found.heading, found.matrix) == ("–", ())


def test_the_page_holds_without_an_assessment(fits: dict[str, Calibration]) -> None:
    bare = replace(presented(fits, {}), best=None)
    assert "Is the heading error below" not in calibration_page(bare, fits, LOG, F_NT)


def test_an_interval_without_ends_is_a_value_alone() -> None:
    assert interval({"value": 2.0, "low": None, "high": None}) == "2°"
    assert interval(None) == "–"
