"""Newton on the norm residual: derivatives, standard case, degenerate minimum, alignment, measured compasses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Reference
from calib.methods.ml_newton import MaximumLikelihoodNewton, _wrong_minimum, two_step_start
from calib.methods.twostep import TwoStep
from calib.models.ellipsoid import Ellipsoid, Standardised, norm_coordinates, symmetric
from calib.models.norm import noise_sums, norm_cost, norm_derivatives
from recordings import read_recording
from scenarios.errors import InputError
from tests.nightly import first_daily

TURN = Rotation.from_euler("ZYX", [0.05, -0.03, 0.08]).as_matrix()


def fit(recording, reference, **settings):
    return MaximumLikelihoodNewton(**settings).fit(recording, reference)


def worst_sigma(result, truth_nT):
    variance, axes = np.linalg.eigh(result.offset_covariance_nT2)
    return np.abs(axes.T @ (result.offset_nT - truth_nT) / np.sqrt(variance)).max()


def spread(recording):
    """std / mean of |h_cal|, whatever the strength: only its ratio counts, so the median of |m| stands for F."""
    strength_nT = float(np.median(np.linalg.norm(recording.mag_nT, axis=1)))
    result = fit(recording, Reference(strength_nT))
    norm_nT = np.linalg.norm(result.apply(recording), axis=1)
    return result.status.kind, float(norm_nT.std() / norm_nT.mean())


def random_point(seed=0, n=50):
    rng = np.random.default_rng(seed)
    x, half = rng.normal(size=(n, 3)), 0.2 * rng.normal(size=(3, 3))
    return norm_coordinates(np.eye(3) + half + half.T, rng.normal(size=3) * 0.3), x


def test_gradient_and_hessian_against_differences():
    p, x = random_point()
    f, gradient, hessian = norm_derivatives(p, x)
    steps = 1e-5 * np.eye(9)
    assert f == pytest.approx(norm_cost(p, x), rel=1e-12)
    slopes = [(norm_cost(p + s, x) - norm_cost(p - s, x)) / 2e-5 for s in steps]
    np.testing.assert_allclose(gradient, slopes, rtol=1e-6, atol=1e-6)
    bends = [(norm_derivatives(p + s, x)[1] - norm_derivatives(p - s, x)[1]) / 2e-5 for s in steps]
    np.testing.assert_allclose(hessian, bends, rtol=1e-5, atol=1e-5)


def test_expected_gradient_of_noise_against_samples():
    """E[r q] at the truth by antithetic noise, within five standard errors."""
    p, x = random_point()
    T = symmetric(p[:6])
    y = x @ T - p[6:]
    x = np.ascontiguousarray((y / np.linalg.norm(y, axis=1)[:, None] + p[6:]) @ np.linalg.inv(T))
    std, rng, sums = 0.01, np.random.default_rng(1), []
    for _ in range(3000):
        noise = std * rng.normal(size=x.shape)
        sums.append(sum(norm_derivatives(p, x + sign * noise)[1] for sign in (1, -1)) / 4 / std**2)
    expected, error = noise_sums(p, x)[2], np.std(sums, axis=0) / np.sqrt(len(sums))
    assert (np.abs(np.mean(sums, axis=0) - expected) < 5 * error + 2e-3 * np.abs(expected).max()).all()


@pytest.mark.parametrize(("motion", "limit_nT", "bound_nT"), [("full", 0.62, 0.5592), ("pitch", 9.5, 7.589)])
def test_hard_iron_is_near_the_bound_and_claimed_so(motion, limit_nT, bound_nT, standard):
    clean = standard.recording(motion, None)
    results = [fit(standard.noisy(clean, seed), standard.REFERENCE) for seed in range(40)]
    assert {r.status.kind for r in results} == {"ok"}
    errors = [np.linalg.norm(r.offset_nT - standard.HARD_NT) for r in results]
    assert np.sqrt(np.mean(np.square(errors))) <= limit_nT
    claimed_nT = np.sqrt(np.mean([np.trace(r.offset_covariance_nT2) for r in results]))
    assert 0.97 * bound_nT < claimed_nT < 1.2 * bound_nT
    assert max(worst_sigma(r, standard.HARD_NT) for r in results) < 4.5


def test_bias_by_noise_is_claimed(standard):
    """At five times the noise the bias is most of the error, and the claimed deviation holds it."""
    clean = standard.recording("pitch", None)
    results = [fit(standard.noisy(clean, seed, 50.0), standard.REFERENCE) for seed in range(20)]
    errors_nT = np.array([r.offset_nT[2] - standard.HARD_NT[2] for r in results])
    claimed_nT = np.sqrt(np.mean([r.offset_covariance_nT2[2, 2] for r in results]))
    assert abs(errors_nT.mean()) > 2 * errors_nT.std()
    assert claimed_nT == pytest.approx(np.sqrt(np.mean(errors_nT**2)), rel=0.2)


def test_level_survey_is_never_falsely_ok(standard):
    clean = standard.recording("auv", None)
    for seed in range(10):
        result = fit(standard.noisy(clean, seed), standard.REFERENCE)
        assert result.status.kind != "ok" or worst_sigma(result, standard.HARD_NT) < 4
        assert result.status.reason


@pytest.mark.parametrize("case", first_daily([("pitch", 60), ("pitch", 200), ("full", 200)]))
def test_degenerate_minimum_is_never_taken_for_a_calibration(case, standard):
    """A motion, and from many random starts: the same answer as from the two-step start, or a failure that says so."""
    motion, starts = case
    recording = standard.recording(motion, 3, n=720)
    best, rng, reached = fit(recording, standard.REFERENCE), np.random.default_rng(0), 0
    for _ in range(starts):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        matrix = (axes * np.exp(rng.uniform(-3, 3, 3))) @ axes.T
        offset_nT = rng.normal(size=3) * 10 ** rng.uniform(3, 6)
        result = fit(
            recording, standard.REFERENCE, start_offset_nT=tuple(offset_nT), start_matrix=tuple(map(tuple, matrix))
        )
        if result.status.kind == "ok":
            np.testing.assert_allclose(result.offset_nT, best.offset_nT, atol=0.1)
            reached += 1
        else:
            assert "T = 0" in result.status.reason or "local minimum" in result.status.reason
    assert starts / 10 < reached < starts


def test_newton_ends_quadratically_from_a_rough_start(standard):
    result = fit(
        standard.recording("full", 0),
        standard.REFERENCE,
        start_offset_nT=(0.0, 0.0, 0.0),
        start_matrix=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    )
    assert result.status.kind == "ok"
    assert len(result.history) <= 8
    assert result.history[-1] < result.history[-2] ** 1.5


def test_alignment_finds_the_turn_that_the_norm_cannot(standard):
    """S = P V with a true turn V: the aligned matrix is S^-1, the one from the norm alone is symmetric."""
    recording = standard.recording("full", 2, soft=standard.SOFT @ TURN)
    aligned, bare = fit(recording, standard.REFERENCE), fit(recording, Reference(standard.REFERENCE.strength_nT))
    np.testing.assert_allclose(aligned.matrix, np.linalg.inv(standard.SOFT @ TURN), atol=1e-4)
    np.testing.assert_allclose(bare.matrix, np.linalg.inv(standard.SOFT), atol=1e-4)
    np.testing.assert_array_equal(aligned.offset_nT, bare.offset_nT)
    blind = replace(recording, att_q=None)
    np.testing.assert_array_equal(fit(blind, standard.REFERENCE).matrix, bare.matrix)
    np.testing.assert_array_equal(fit(recording, standard.REFERENCE, align=False).matrix, bare.matrix)


@pytest.mark.parametrize("noise_std", [0.0, 1e-8, 1e-5])
@pytest.mark.parametrize(("excess", "refused"), [(0.0, False), (0.8, False), (1.2, True), (4.0, True), (1e3, True)])
def test_a_residual_above_the_noise_by_more_than_rounding_is_a_local_minimum(noise_std, excess, refused):
    """A sphere whose radius is off by d leaves d at every point: 3 noises and 1e-7 are borne, no more."""
    h = np.random.default_rng(0).normal(size=(500, 3))
    x = h / np.linalg.norm(h, axis=1)[:, None]
    off = 3.0 * noise_std + excess * 1e-7
    wrong = _wrong_minimum(
        norm_coordinates((1.0 + off) * np.eye(3), np.zeros(3)), Standardised(x, h[0], 1.0), noise_std
    )
    assert (wrong is not None) is refused
    assert wrong is None or "local minimum" in wrong.reason


@pytest.mark.parametrize("share", [0.0, 3e-8, 3e-7, 3e-6])
def test_noise_about_the_size_of_rounding_is_no_local_minimum(share, standard):
    clean = standard.recording("full", None)
    noise_nT = share * Standardised.of(clean.mag_nT).scale_nT
    result = fit(standard.noisy(clean, 1, noise_nT), standard.REFERENCE)
    assert result.status.kind == "ok"
    assert result.parameters["noise_std_nT"] == pytest.approx(noise_nT, rel=0.05, abs=1e-8)


def test_half_a_start_is_refused():
    with pytest.raises(InputError, match="give both"):
        MaximumLikelihoodNewton(start_offset_nT=(0.0, 0.0, 0.0))


def test_standardised_points_are_centred_with_unit_extent(standard):
    x = Standardised.of(standard.recording("pitch", 0).mag_nT).x
    np.testing.assert_allclose(x.mean(axis=0), 0.0, atol=1e-12)
    assert np.mean(np.sum(x**2, axis=1)) == pytest.approx(1.0)


def test_cave_compasses(realdata):
    """24 static poses each: below 0.15 %, from 11 to 40 % raw."""
    files = sorted((realdata / "cave-compass").glob("*.parquet"))
    assert len(files) == 7
    for file in files:
        recording = read_recording(file)
        raw_nT = np.linalg.norm(recording.mag_nT, axis=1)
        assert 0.11 < raw_nT.std() / raw_nT.mean() < 0.40
        kind, share = spread(recording)
        assert (kind, share < 0.0015) == ("ok", True)


def test_glider(realdata):
    """Five dives, every sample kept: below 0.4 %, from 4 % raw, though masses move in the hull."""
    recording = read_recording(realdata / "glider" / "five_dives.parquet")
    raw_nT = np.linalg.norm(recording.mag_nT, axis=1)
    assert raw_nT.std() / raw_nT.mean() > 0.04
    kind, share = spread(recording)
    assert (kind, share < 0.004) == ("ok", True)


@pytest.mark.parametrize("motion", ["full", "pitch"])
def test_without_the_two_step_s_ellipsoid_the_specific_fit_starts(motion, standard, monkeypatch):
    recording = standard.recording(motion, 4)
    usual = fit(recording, standard.REFERENCE)
    monkeypatch.setattr(TwoStep, "estimate", lambda self, x: None)
    x = Standardised.of(recording.mag_nT).x
    start, noise_std = two_step_start(x)
    started = Ellipsoid.of_norm(start)
    scale_nT = Standardised.of(recording.mag_nT).scale_nT
    assert noise_std * scale_nT == pytest.approx(standard.NOISE_STD_NT, rel=0.1)
    offset_nT = recording.mag_nT.mean(axis=0) + scale_nT * started.centre
    np.testing.assert_allclose(offset_nT, standard.HARD_NT, atol=100.0)
    other = fit(recording, standard.REFERENCE)
    assert other.status.kind == usual.status.kind == "ok"
    np.testing.assert_allclose(other.offset_nT, usual.offset_nT, atol=1e-3)
