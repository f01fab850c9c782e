"""The standard case: hard iron against the Cramer-Rao bound, and claimed deviations against errors."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from calib import Reference, get
from calib.methods.sphere import SphereCalibrator
from calib.methods.vector_least_squares import VectorLeastSquares
from recordings import Recording

SEEDS = range(100)


@pytest.fixture(scope="module")
def runs(standard):
    """Lazily made results by (calibrator, motion): 100 seeds."""
    known: dict[tuple[str, str], list] = {}

    def of(name, motion):
        if (name, motion) not in known:
            clean = standard.recording(motion, None)
            known[name, motion] = [get(name).fit(standard.noisy(clean, seed), standard.REFERENCE) for seed in SEEDS]
        return known[name, motion]

    return of


def offset_rms_nT(results, truth_nT):
    """Root mean square of the offset error's length."""
    return np.sqrt(np.mean([np.sum((r.offset_nT - truth_nT) ** 2) for r in results]))


@pytest.mark.parametrize(
    ("name", "motion", "limit_nT"),
    [
        ("ellipsoid", "full", 0.62),
        ("ellipsoid", "pitch", 9.5),
        ("vector_least_squares", "full", 0.32),
        ("vector_least_squares", "pitch", 1.2),
        ("vector_least_squares", "auv", 10.5),
    ],
)
def test_hard_iron_is_near_the_bound(name, motion, limit_nT, runs, standard):
    results = runs(name, motion)
    assert {r.status.kind for r in results} == {"ok"}
    assert offset_rms_nT(results, standard.HARD_NT) <= limit_nT


@pytest.mark.parametrize(
    ("name", "motion", "bound_nT"),
    [
        ("ellipsoid", "full", 0.5592),
        ("ellipsoid", "pitch", 7.589),
        ("ellipsoid", "auv", 423.6),
        ("vector_least_squares", "full", 0.2938),
        ("vector_least_squares", "pitch", 1.1052),
        ("vector_least_squares", "auv", 9.799),
    ],
)
def test_claimed_deviation_is_the_bound_and_covers_the_error(name, motion, bound_nT, runs, standard):
    results = runs(name, motion)
    claimed_nT = np.sqrt(np.mean([np.trace(r.offset_covariance_nT2) for r in results]))
    assert claimed_nT == pytest.approx(bound_nT, rel=0.03)
    errors = [r.offset_nT - standard.HARD_NT for r in results]
    normalised = [e @ np.linalg.solve(r.offset_covariance_nT2, e) / 3 for e, r in zip(errors, results, strict=True)]
    # chi-square with 300 degrees of freedom over 300: five sigma are 0.41
    assert np.mean(normalised) == pytest.approx(1.0, abs=0.41)


@pytest.mark.parametrize("name", ["sphere", "ellipsoid"])
def test_level_survey_never_claims_what_it_cannot_know(name, runs, standard):
    for result in runs(name, "auv"):
        if result.status.kind == "ok":
            variance, axes = np.linalg.eigh(result.offset_covariance_nT2)
            error_sigma = np.abs(axes.T @ (result.offset_nT - standard.HARD_NT)) / np.sqrt(variance)
            assert error_sigma.max() < 4
        else:
            assert result.status.kind == "unobservable"
            assert "roll and pitch" in result.status.reason


def test_ellipsoid_is_unbiased_where_the_plain_algebraic_fit_is_not(runs, standard):
    errors = np.array([r.offset_nT - standard.HARD_NT for r in runs("ellipsoid", "auv")])
    assert np.abs(errors.mean(axis=0)[2]) < 5 * errors[:, 2].std() / np.sqrt(len(errors))


def test_sphere_says_how_wrong_soft_iron_makes_it(runs, standard):
    for motion in ("full", "pitch"):
        for result in runs("sphere", motion)[:10]:
            assert result.status.kind == "unobservable"
            assert "not on a sphere" in result.status.reason
            assert "cannot rule out soft iron" in result.status.reason
            error_nT = np.linalg.norm(result.offset_nT - standard.HARD_NT)
            assert np.sqrt(np.trace(result.offset_covariance_nT2)) == pytest.approx(error_nT, rel=0.2)


@pytest.mark.parametrize(("stretch", "caveat"), [(0.0, False), (0.01, True)])
def test_a_sphere_that_is_ok_names_the_soft_iron_that_it_cannot_rule_out(stretch, caveat, standard):
    """Within 6 degrees of level: soft iron of 1 % moves the centre by as much as the caveat says."""
    rng = np.random.default_rng(0)
    heading, height = rng.uniform(0, 2 * np.pi, 2000), rng.uniform(-0.1, 0.1, 2000)
    level = np.sqrt(1 - height**2)
    unit = np.column_stack([level * np.cos(heading), level * np.sin(heading), height])
    soft = np.eye(3) + stretch * np.array([[1.0, 0.5, 0.0], [0.5, -1.0, 0.3], [0.0, 0.3, 0.0]])
    mag_nT = 48_000 * unit @ soft + standard.HARD_NT + rng.normal(0, 5, (2000, 3))
    fit = SphereCalibrator().fit(Recording(np.arange(2000.0), mag_nT), Reference(48_000))
    assert fit.status.kind == "ok"
    assert ("cannot rule out soft iron" in fit.status.reason) == caveat
    if caveat:
        told_nT = float(re.search(r"about ([\d.]+) nT", fit.status.reason)[1])
        assert told_nT == pytest.approx(np.linalg.norm(fit.offset_nT - standard.HARD_NT), rel=0.1)


def test_eddy_currents_are_found_and_removed(standard):
    eddy_s = np.array([[0.10, 0.02, 0.0], [0.01, 0.16, 0.03], [0.0, -0.02, 0.05]])
    recording = standard.recording("full", 3, eddy_s=eddy_s)
    result = VectorLeastSquares(eddy=True).fit(recording, standard.REFERENCE)
    assert result.status.kind == "ok"
    std_s = np.sqrt(np.diag(result.covariance))[-9:].reshape(3, 3)
    assert np.abs((result.eddy_s - eddy_s) / std_s).max() < 5
    plain = VectorLeastSquares().fit(recording, standard.REFERENCE)
    assert result.parameters["noise_std_nT"] == pytest.approx(standard.NOISE_STD_NT, rel=0.05)
    assert plain.parameters["noise_std_nT"] > 20 * standard.NOISE_STD_NT


def test_constant_rate_turn_cannot_tell_eddy_currents_from_soft_iron(standard):
    recording = standard.recording("full", None)
    steady = recording.gyro_rad_s * 0 + [0.0, 0.0, 0.1]
    result = VectorLeastSquares(eddy=True).fit(replace(recording, gyro_rad_s=steady), standard.REFERENCE)
    assert result.status.kind == "unobservable"
    assert "constant rate" in result.status.reason
