"""Maximum likelihood by distances: bound, interval, bias by curvature, spikes, unknown strength, poor motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib import Reference
from calib.methods.ml_geometric import MaximumLikelihoodGeometric
from recordings import Recording
from tests.nightly import first_daily

BOUND_NT = {"full": 0.5592, "pitch": 7.589}
"""The standard case: strength known, nine parameters."""


def fits(standard, motion, seeds, **settings):
    clean, method = standard.recording(motion, None), MaximumLikelihoodGeometric(**settings)
    return [method.fit(standard.noisy(clean, seed), standard.REFERENCE) for seed in seeds]


def rms_and_cover(results, truth_nT):
    """Rms length of the offset's error, and how many of its components a 95 % interval holds."""
    errors = np.array([r.offset_nT - truth_nT for r in results])
    std = np.array([np.sqrt(np.diag(r.offset_covariance_nT2)) for r in results])
    return np.sqrt(np.mean(np.sum(errors**2, axis=1))), np.mean(np.abs(errors) < 1.96 * std)


@pytest.mark.parametrize("motion", first_daily(["pitch", "full"]))
def test_hard_iron_reaches_the_bound_and_is_claimed_so(motion, standard):
    results = fits(standard, motion, range(120))
    assert {r.status.kind for r in results} == {"ok"}
    rms_nT, cover = rms_and_cover(results, standard.HARD_NT)
    assert rms_nT <= 1.15 * BOUND_NT[motion]
    assert 0.92 < cover < 0.98
    claimed_nT = np.sqrt(np.mean([np.trace(r.offset_covariance_nT2) for r in results]))
    assert claimed_nT == pytest.approx(BOUND_NT[motion], rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("motion", "ratio"), [("full", 1.05), ("pitch", 1.15)])
def test_a_thousand_runs_reach_the_bound_and_are_covered(motion, ratio, standard):
    rms_nT, cover = rms_and_cover(fits(standard, motion, range(1000)), standard.HARD_NT)
    assert rms_nT <= ratio * BOUND_NT[motion]
    assert 0.93 < cover < 0.97


def test_curvature_of_the_ellipsoid_does_not_shrink_it(standard):
    """Noise of 4 % of the field: distances alone put S too large by sigma^2 / F^2, here seven standard deviations."""
    rng = np.random.default_rng(0)
    unit = rng.normal(size=(20_000, 3))
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    mag_nT = 50_000 * unit + rng.normal(0, 2000, unit.shape)
    fit = MaximumLikelihoodGeometric().fit(Recording(np.arange(20_000.0), mag_nT), Reference(50_000))
    scale = np.mean([fit.parameters[name] for name in ("S_xx", "S_yy", "S_zz")])
    std = 2000 / 50_000 / np.sqrt(20_000)
    assert abs(scale - 1) < 3 * std
    assert 5 * std < (2000 / 50_000) ** 2


def test_spikes_do_not_move_a_robust_fit(standard):
    recording = standard.recording("full", 3)
    hit = np.random.default_rng(0).permutation(len(recording))[:100]
    mag_nT = recording.mag_nT.copy()
    mag_nT[hit] += [0.0, 4000.0, 0.0]
    spiked = replace(recording, mag_nT=mag_nT)
    plain = MaximumLikelihoodGeometric(robust=False).fit(spiked, standard.REFERENCE)
    robust = MaximumLikelihoodGeometric(huber=1.345, robust=False).fit(spiked, standard.REFERENCE)
    assert np.linalg.norm(plain.offset_nT - standard.HARD_NT) > 20
    assert np.linalg.norm(robust.offset_nT - standard.HARD_NT) < 2.5
    assert robust.parameters["noise_std_nT"] == pytest.approx(standard.NOISE_STD_NT, rel=0.1)


def test_robust_interval_covers_where_nothing_is_wrong(standard):
    rms_nT, cover = rms_and_cover(fits(standard, "full", range(60), huber=1.345), standard.HARD_NT)
    assert rms_nT < 1.2 * BOUND_NT["full"]
    assert 0.89 < cover < 0.99


def test_unknown_strength_leaves_the_offset_and_is_found_in_the_scale_of_the_matrix(standard):
    recording = standard.recording("full", 5)
    known = MaximumLikelihoodGeometric().fit(recording, standard.REFERENCE)
    free = MaximumLikelihoodGeometric(strength_known=False).fit(recording, Reference(1000.0))
    assert free.status.kind == "ok"
    np.testing.assert_allclose(free.offset_nT, known.offset_nT, atol=1e-6)
    assert np.linalg.det(free.matrix) == pytest.approx(1.0, abs=1e-12)
    truth_nT = standard.REFERENCE.strength_nT * np.linalg.det(standard.SOFT) ** (1 / 3)
    assert free.parameters["strength_nT"] == pytest.approx(truth_nT, rel=1e-4)
    np.testing.assert_allclose(np.linalg.norm(free.apply(recording), axis=1).mean(), truth_nT, rtol=1e-4)
    scale = np.concatenate((np.zeros(3), np.linalg.inv(free.matrix)[np.triu_indices(3)]))
    across = np.linalg.eigh(free.covariance[3:, 3:])
    assert across[0][0] == pytest.approx(0.0, abs=1e-9 * across[0][-1])
    assert scale[3:] @ across[1][:, 0] != 0.0


@pytest.mark.parametrize("tilt_deg", [0.2, 1.0, 3.0])
def test_small_tilts_are_unobservable_in_words_and_never_a_failure(tilt_deg, standard):
    time_s = np.arange(3600) / 10.0
    roll, pitch = (np.radians(tilt_deg) * np.sin(2 * np.pi * time_s / period) for period in (31.0, 47.0))
    yaw = 0.1 * time_s
    level, up = 0.6, 0.8
    unit = np.column_stack([level * np.cos(yaw) + up * pitch, level * np.sin(yaw) + up * roll, np.full(3600, up)])
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    for seed in range(2):
        noise_nT = np.random.default_rng(seed).normal(0, 10, unit.shape)
        mag_nT = 40_000 * unit @ standard.SOFT + standard.HARD_NT + noise_nT
        fit = MaximumLikelihoodGeometric().fit(Recording(time_s, mag_nT), Reference(40_000))
        assert fit.status.kind == "unobservable", fit.status
        assert "body z" in fit.status.reason
        assert np.isfinite(fit.offset_nT).all()
