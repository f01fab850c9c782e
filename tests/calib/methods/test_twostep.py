"""TWOSTEP: the standard case, its claimed error, and the pieces it is made of."""

from __future__ import annotations

import numpy as np
import pytest

from calib import Reference
from calib.methods.twostep import Centred, TwoStep, _expected_gradient, centre_gradient, centre_of, first_step
from calib.models.ellipsoid import Standardised
from calib.models.quadric import design, shape_matrix
from recordings import read_recording

SEEDS = range(40)


def fits(standard, motion):
    clean = standard.recording(motion, None)
    return [TwoStep().fit(standard.noisy(clean, seed), standard.REFERENCE) for seed in SEEDS]


def worst_sigma(result, truth_nT):
    variance, axes = np.linalg.eigh(result.offset_covariance_nT2)
    return np.abs(axes.T @ (result.offset_nT - truth_nT) / np.sqrt(variance)).max()


@pytest.mark.parametrize(("motion", "limit_nT", "bound_nT"), [("full", 0.62, 0.5592), ("pitch", 9.5, 7.589)])
def test_hard_iron_is_near_the_bound_and_claimed_so(motion, limit_nT, bound_nT, standard):
    results = fits(standard, motion)
    assert {r.status.kind for r in results} == {"ok"}
    errors = [np.linalg.norm(r.offset_nT - standard.HARD_NT) for r in results]
    assert np.sqrt(np.mean(np.square(errors))) <= limit_nT
    claimed_nT = np.sqrt(np.mean([np.trace(r.offset_covariance_nT2) for r in results]))
    assert 0.97 * bound_nT < claimed_nT < 1.2 * bound_nT
    assert max(worst_sigma(r, standard.HARD_NT) for r in results) < 4.5


def test_level_survey_is_never_falsely_ok(standard):
    clean = standard.recording("auv", None)
    for seed in range(12):
        result = TwoStep().fit(standard.noisy(clean, seed), standard.REFERENCE)
        assert result.status.kind != "ok" or worst_sigma(result, standard.HARD_NT) < 4
        assert result.status.reason


def points(standard, motion="pitch", seed=1):
    return Standardised.of(standard.recording(motion, seed).mag_nT).x


def test_centred_cost_is_the_cost_of_all_samples(standard):
    x = points(standard)
    theta, rows = first_step(x), design(x)
    weight = 1 / (4 * np.sum(((x - centre_of(theta)) @ shape_matrix(theta)) ** 2, axis=1))
    centred = Centred.of(x, theta, 1e-4)
    value = rows @ theta - theta[6:] @ centre_of(theta) - 1 - 1e-4
    assert centred.cost(theta) == pytest.approx(weight @ value**2, rel=1e-8)  # by its rounding
    step = 1e-5 * np.random.default_rng(0).normal(size=9)
    slope = (centred.cost(theta + step) - centred.cost(theta - step)) / 2
    row = rows + centre_gradient(theta)
    assert 2 * (weight * value) @ row @ step == pytest.approx(slope, rel=1e-4)


def test_the_centre_solves_the_shape_and_its_row_is_the_design():
    rng = np.random.default_rng(0)
    for _ in range(20):
        theta = rng.normal(size=9)
        b = np.linalg.solve(shape_matrix(theta), -theta[6:])
        np.testing.assert_allclose(centre_of(theta), b, rtol=1e-9)
        np.testing.assert_allclose(centre_gradient(theta), -design(b[None])[0], rtol=1e-9)
    with pytest.raises(np.linalg.LinAlgError):
        centre_of(np.ones(9))


def test_first_step_is_exact_without_noise(standard):
    x = Standardised.of(standard.recording("full", None).mag_nT).x
    theta = first_step(x)
    d = x - centre_of(theta)
    np.testing.assert_allclose(np.einsum("ni,ij,nj->n", d, shape_matrix(theta), d), 1.0, atol=1e-10)


def test_bias_by_noise_is_claimed(standard):
    """At five times the noise the bias is most of the error: the claimed bias is that of the mean over 20 seeds."""
    clean = standard.recording("pitch", None)
    results = [TwoStep().fit(standard.noisy(clean, seed, 50.0), standard.REFERENCE) for seed in range(20)]
    errors_nT = np.array([r.offset_nT[2] - standard.HARD_NT[2] for r in results])
    claimed_nT = np.sqrt(np.mean([r.offset_covariance_nT2[2, 2] for r in results]))
    assert abs(errors_nT.mean()) > 2 * errors_nT.std()
    assert claimed_nT == pytest.approx(np.sqrt(np.mean(errors_nT**2)), rel=0.2)


def test_expected_gradient_of_noise_against_samples(standard):
    """sum E[w v dz/dtheta] by antithetic noise, within five standard errors."""
    x = Standardised.of(standard.recording("pitch", None, n=300).mag_nT).x
    theta, std, rng, sums = first_step(x), 0.003, np.random.default_rng(0), []
    shape, centre = shape_matrix(theta), centre_of(theta)
    for noise in std * rng.normal(size=(2000, *x.shape)):
        for sign in (1, -1):
            rows, steep = design(x + sign * noise), (x + sign * noise - centre) @ shape
            v = rows @ theta - theta[6:] @ centre - 1 - std**2 * np.trace(shape)
            sums.append((v / (4 * np.sum(steep**2, axis=1))) @ (rows + centre_gradient(theta)) / std**2)
    pairs = np.array(sums).reshape(-1, 2, 9).mean(axis=1)
    expected, error = _expected_gradient(theta, x), pairs.std(axis=0) / np.sqrt(len(pairs))
    assert (np.abs(pairs.mean(axis=0) - expected) < 5 * error + 2e-3 * np.abs(expected).max()).all()


def test_one_round_too_few_is_not_converged(standard):
    result = TwoStep(iterations=1, rounds=1).fit(standard.recording("pitch", 0), standard.REFERENCE)
    assert result.status.kind == "not_converged"
    assert "standard deviations" in result.status.reason


def test_rounds_that_run_out_are_not_converged_though_each_ends_with_a_short_step(standard):
    """Weights and the mean of the noise still move the estimate: its last step is short, its last round is not."""
    recording = standard.recording("full", 1)
    early = TwoStep(rounds=2).fit(recording, standard.REFERENCE)
    assert early.history[-1] < TwoStep.tolerance
    assert early.status.kind == "not_converged"
    assert "at most 2 rounds" in early.status.reason
    late = TwoStep(rounds=3).fit(recording, standard.REFERENCE)
    assert late.status.kind == "ok"
    np.testing.assert_allclose(early.offset_nT, late.offset_nT, atol=0.1)


def test_cave_compasses(realdata):
    files = sorted((realdata / "cave-compass").glob("*.parquet"))
    assert len(files) == 7
    for file in files:
        recording = read_recording(file)
        strength_nT = float(np.median(np.linalg.norm(recording.mag_nT, axis=1)))
        corrected_nT = np.linalg.norm(TwoStep().fit(recording, Reference(strength_nT)).apply(recording), axis=1)
        assert corrected_nT.std() / corrected_nT.mean() < 0.0015


def test_steps_go_on_until_one_is_short_and_no_longer(standard):
    """Of each round only the last step is below the tolerance, and rounds end when one moves by less."""
    x = points(standard)
    rough, usual, fine = (TwoStep(rounds=20, tolerance=t).estimate(x) for t in (1e9, 1e-3, 1e-8))
    assert len(rough.history) == 1
    assert len(usual.history) < len(fine.history) < 20 * 30
    for estimate, tolerance in ((usual, 1e-3), (fine, 1e-8)):
        assert estimate.move < tolerance
        assert estimate.history[-1] < tolerance
        assert estimate.history[0] > tolerance
    assert TwoStep(rounds=6).estimate(x).history == usual.history
    assert usual.centred.length(usual.theta, usual.theta - fine.theta) < 2e-3


def test_each_round_ends_with_its_first_short_step(standard):
    x = points(standard)
    theta = first_step(x)
    _, lengths = TwoStep()._second_step(Centred.of(x, theta, 0.0), theta)
    assert lengths[-1] < TwoStep.tolerance
    assert all(length >= TwoStep.tolerance for length in lengths[:-1])
    one = TwoStep(iterations=len(lengths) - 1)._second_step(Centred.of(x, theta, 0.0), theta)
    assert one[1][-1] >= TwoStep.tolerance
    assert len(one[1]) == len(lengths) - 1
