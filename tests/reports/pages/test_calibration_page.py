"""The page of calibrations: the answer first, figures with intervals, what a failed fit cannot say as dashes."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, get
from recordings import Recording
from recordings.recording import Origin
from reports.pages.calibration import calibration_page
from reports.presentation.calibration import PresentedCalibrations, PresentedFit, interval
from tests.reports.page import read
from validation.assessment.assessment import assess
from validation.screening.screening import screen

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


@pytest.fixture(scope="module")
def fits() -> dict[str, Calibration]:
    return {name: get(name).fit(LOG, F_NT) for name in ("ellipsoid", "vector_least_squares")}


@pytest.fixture(scope="module")
def found(fits: dict[str, Calibration]) -> PresentedCalibrations:
    """Presented with the answer to a tolerance of half a degree."""
    assessment = assess(fits, screen(LOG, F_NT), F_NT, 0.5)
    return PresentedCalibrations.of("log.csv", fits, LOG, F_NT, assessment, ("Stuck: z.",))


def test_the_answer_comes_first_then_figures_with_intervals(
    fits: dict[str, Calibration], found: PresentedCalibrations
) -> None:
    page = read(calibration_page(found, fits, LOG, F_NT, ("calibration.json: all figures",)))
    order = ["Heading within", "Stuck: z.", "held-out legs", "A heading error below 0.5°: yes", "iron"]
    places = [page.index(text) for text in order]
    assert places == sorted(places)
    assert "3 rows skipped" in page
    assert "calibration.json: all figures" in page
    assert re.search(r"<td[^>]*>turn</td>", page)
    assert "repeat the command" in page
    exported = calibration_page(found, fits, LOG, F_NT, ("calibration.json", "ardupilot.param"))
    assert "what was written" in exported
    assert "repeat the command" not in exported


def test_the_tiles_hold_the_figures_of_the_recommended_calibration(found: PresentedCalibrations) -> None:
    """Of a full tumble: the strength with a hard iron deviates by some 1,700 nT, by the noise of 30 nT after."""
    tiles = {label: value for value, _, label in found.tiles}
    before, after = (
        float(text.replace(",", ""))
        for text in tiles["strength's rms deviation, before and on held-out legs"].split(" → ")
    )
    assert before == pytest.approx(np.linalg.norm([1200, 800, 2500]) / 3**0.5, rel=0.1)
    assert after == pytest.approx(30.0, rel=0.1)
    assert tiles["quality"] == "good"


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


def test_the_page_holds_where_no_calibration_can_be_used(fits: dict[str, Calibration]) -> None:
    failed = {"vector_least_squares": fits["vector_least_squares"]}
    none = PresentedCalibrations.of("log.csv", failed, LOG, F_NT, assess(failed, screen(LOG, F_NT), F_NT))
    page = calibration_page(none, failed, LOG, F_NT)
    assert "No calibration can be used" in page
    assert "Strength before and after" not in page


def test_an_interval_without_ends_is_a_value_alone() -> None:
    assert interval({"value": 2.0, "low": None, "high": None}) == "2°"
    assert interval(None) == "–"
