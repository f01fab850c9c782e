"""Figures of other programs on logs whose figures follow from their construction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, Status
from recordings import Recording
from validation.known_figures import FIGURES, known_figures
from validation.known_figures.figures import KnownFigure
from validation.known_figures.magfit import lattice
from validation.known_figures.regions import REGIONS, middles, region_counts, region_of

STRENGTH_NT = 50_000.0
EXACT = Calibration(name="exact", status=Status("ok"), offset_nT=np.array([3000.0, 0.0, 4000.0]), matrix=np.eye(3))


def sphere(n: int = 5000) -> np.ndarray:
    """Directions spread evenly over the sphere, by the golden angle."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (3 - np.sqrt(5)) * k
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z])


def figures(directions: np.ndarray, radius_nT: object = STRENGTH_NT) -> dict[str, KnownFigure]:
    mag = np.asarray(radius_nT).reshape(-1, 1) * directions + EXACT.offset_nT
    recording = Recording(np.arange(len(mag), dtype=float), mag)
    found = known_figures(EXACT, recording, Reference(STRENGTH_NT))
    return {f"{one.program} {one.name.split(',')[0]}": one for one in found}


def test_a_perfect_log_passes_everything() -> None:
    found = figures(sphere())
    assert len(found) == len(FIGURES)
    assert all(one.passes in (True, None) for one in found.values())
    assert found["ArduPilot fitness"].value == pytest.approx(0.0, abs=1e-6)
    assert found["ArduPilot largest offset"].value == pytest.approx(40.0)
    assert found["Betaflight centre over radius"].value == pytest.approx(0.1)
    assert found["Betaflight coverage"].value == 100.0
    assert found["MotionCal gaps"].value < 1.0


def test_strengths_that_differ_by_two_per_cent_up_and_down_have_figures_by_hand() -> None:
    """+-1000 nT of 50,000: 10 mG; 2 %; 50 sqrt(mean (1.02^2 - 1)^2, (0.98^2 - 1)^2) = 2.0 %."""
    radius = STRENGTH_NT + 1000.0 * (-1.0) ** np.arange(5000)
    found = figures(sphere(), radius)
    assert found["ArduPilot fitness"].value == pytest.approx(10.0)
    assert found["ArduPilot fitness"].passes
    assert found["Betaflight residual of a sphere"].value == pytest.approx(2.0, rel=1e-3)
    assert found["MotionCal fit error"].value == pytest.approx(50 * np.sqrt((0.0404**2 + 0.0396**2) / 2), rel=1e-6)
    assert found["NXP fit error"].passes
    beyond = figures(sphere(), STRENGTH_NT + 2.0 * (radius - STRENGTH_NT))
    assert beyond["ArduPilot fitness"].passes is False
    assert beyond["Betaflight residual of a sphere"].passes is False
    odd = figures(sphere(), STRENGTH_NT + 2500.0 * (-1.0) ** (np.arange(5000) // 8))  # a sample of eight is held
    assert odd["MotionCal variance"].value == pytest.approx(5.0, rel=1e-2)
    assert odd["MotionCal variance"].passes is False


def test_half_a_sphere_has_half_the_regions_as_gaps() -> None:
    half = sphere()
    found = figures(half[half[:, 2] > 0])
    assert found["MotionCal gaps"].value == pytest.approx(50.0, abs=1.0)
    assert found["MotionCal gaps"].passes is False
    assert found["Betaflight coverage"].passes is False


def test_a_field_off_its_centre_wobbles_by_a_third() -> None:
    """d = 18 % of the radius forward: a region along u lies u . d further out, and the mean of u u^T d is d / 3."""
    moved = STRENGTH_NT * (sphere() + np.array([0.18, 0.0, 0.0]))
    found = figures(moved, 1.0)
    assert found["MotionCal wobble"].value == pytest.approx(6.0, abs=1.0)
    assert found["MotionCal wobble"].passes is False


def test_the_regions_are_equal_and_their_middles_in_them() -> None:
    counts = region_counts(sphere(100_000))
    assert len(counts) == REGIONS
    assert np.abs(counts / 1000.0 - 1).max() < 0.05
    inside = region_of(middles()) == np.arange(REGIONS)
    assert inside[:84].all()
    assert inside[99]
    np.testing.assert_array_equal((region_of(middles())[84:99] - np.arange(84, 99)) % 15, 8)  # MotionCal's own slip


def test_magfit_weighs_every_bin_alike() -> None:
    """Half of the samples in one bin with an error of 1000 nT, the others elsewhere with none: 10 mG / sqrt(2)."""
    bins = lattice()
    wanted = np.concatenate([np.repeat(bins[:1], 90, axis=0), np.repeat(bins[40:41], 10, axis=0)])
    turns = [Rotation.align_vectors([one], [[0.0, 0.0, 1.0]])[0].inv() for one in wanted]  # R^T F = the bin's middle
    att_q = Rotation.concatenate([one.inv() for one in turns]).inv().as_quat(scalar_first=True)
    off = np.where(np.arange(100) < 90, 1000.0, 0.0)[:, None] * wanted
    recording = Recording(np.arange(100.0), STRENGTH_NT * wanted + off + EXACT.offset_nT, att_q=att_q)
    found = known_figures(EXACT, recording, Reference.of_vector((0.0, 0.0, STRENGTH_NT)))
    error, coverage = (one for one in found if one.program == "MAGFit")
    assert error.value == pytest.approx(10.0 / np.sqrt(2.0), rel=1e-6)
    assert coverage.value == pytest.approx(2.5)
    assert coverage.passes is False


def test_without_attitude_magfit_says_what_it_needs() -> None:
    error = figures(sphere())["MAGFit error against the world model"]
    assert (error.value, error.passes) == (None, None)
    assert error.row() == ["MAGFit", "error against the world model", "needs attitude and field vector", "-", "-"]


def test_without_an_estimate_there_are_no_figures() -> None:
    failed = replace(EXACT, status=Status("not_applicable", "too short"))
    recording = Recording(np.arange(10.0), np.ones((10, 3)))
    assert known_figures(failed, recording, Reference(STRENGTH_NT)) == ()
