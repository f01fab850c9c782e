"""Linked directions against finite differences, drawn noise, and starts against the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.models.linked import LinkedEstimate, LinkedSamples, mean_rates, steps, tangents
from calib.models.linked_noise import likeliest_ratio, unlikeliness
from calib.models.linked_start import axes_of_gyro, turned_alike
from calib.numerics.damped import minimised

ROOT = np.array([[1.1, 0.05, -0.02], [0.01, 0.95, 0.03], [0.0, -0.04, 1.02]])
CENTRE = np.array([0.1, -0.2, 0.05])
BIAS_RAD_S = np.array([0.02, -0.01, 0.03])
FULL = np.eye(9).reshape(9, 3, 3)


def link(n: int, noise: float, gyro_rad_s: float, seed: int = 0) -> tuple[LinkedSamples, LinkedEstimate]:
    """A tumbling body at 10 Hz whose directions diffuse, what was measured of it, and the truth."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(n) / 10.0
    rate = 0.5 * np.column_stack([np.sin(0.31 * time_s), np.cos(0.23 * time_s), np.sin(0.17 * time_s + 1)])[:-1]
    step_s = np.diff(time_s)
    u = np.empty((n, 3))
    u[0] = [0.6, 0.0, -0.8]
    for i in range(n - 1):
        u[i + 1] = Rotation.from_rotvec(-step_s[i] * (rate[i] + gyro_rad_s * rng.normal(size=3))).apply(u[i])
    x = u @ ROOT.T + CENTRE + noise * rng.normal(size=(n, 3))
    return LinkedSamples(x, rate + BIAS_RAD_S, step_s, FULL, gyro_rad_s / noise), LinkedEstimate(
        CENTRE, ROOT, BIAS_RAD_S, u
    )


def test_slope_and_square_are_those_of_the_cost():
    """Parameters moved and all directions found anew: d cost / dp = 2 slope, d slope / dp = square near the best."""
    known, truth = link(60, 1e-4, 1e-3)
    here = known.settled(truth)
    normal = known.normal(here)
    for k, unit in enumerate(np.eye(known.count)):
        ahead, behind = (known.moved(here, sign * 1e-5 * unit) for sign in (1, -1))
        costs = (known.normal(ahead).cost - known.normal(behind).cost) / 2e-5
        slopes = (known.normal(ahead).slope - known.normal(behind).slope) / 2e-5
        assert costs == pytest.approx(2 * normal.slope[k], rel=0.02, abs=0.02 * np.abs(normal.slope).max())
        np.testing.assert_allclose(slopes, normal.square[k], rtol=0.02, atol=0.01 * normal.square[k, k])


def test_minimum_is_the_truth_where_nothing_is_noisy():
    known, _ = link(400, 1e-9, 1e-9)
    shifted = LinkedEstimate.of(known.x, CENTRE + 0.05, 1.1 * ROOT)
    found = minimised(known, known.settled(shifted), 60, 1e-6).point.estimate
    np.testing.assert_allclose(found.centre, CENTRE, atol=1e-6)
    np.testing.assert_allclose(found.root, ROOT, atol=1e-6)
    np.testing.assert_allclose(found.bias_rad_s, BIAS_RAD_S, atol=1e-6)


@pytest.mark.parametrize("factor", [0.05, 30.0])
def test_ratio_of_the_noises_is_found(factor):
    """From one that is far off; 1500 links tell it to some 3 %."""
    known, truth = link(1500, 3e-4, 2e-3)
    found = known.with_ratio(factor * known.ratio)
    for _ in range(4):
        found = found.with_ratio(likeliest_ratio(found, found.settled(truth)))
    assert found.ratio == pytest.approx(known.ratio, rel=0.12)


def test_likelihood_is_that_of_a_dense_gaussian():
    """-2 log likelihood of the measurements, covariance formed whole, differs between ratios by the same."""
    known, truth = link(12, 1e-3, 0.05)
    ratios = (0.5 * known.ratio, 2.0 * known.ratio)

    def dense(ratio):
        here = known.with_ratio(ratio)
        rows = here.linear(truth)
        n, k = len(known.x), known.count
        M = np.einsum("ab,nbj->naj", ROOT, tangents(truth.directions))
        J = np.concatenate([np.tile(np.eye(3), (n, 1, 1)), np.einsum("pab,nb->nap", FULL, truth.directions)], axis=2)
        J = np.concatenate([J, np.zeros((n, 3, 3))], axis=2).reshape(3 * n, k)
        residual = (CENTRE + truth.directions @ ROOT.T - known.x).ravel()
        seen = np.zeros((3 * n, 2 * n))
        for i in range(n):
            seen[3 * i : 3 * i + 3, 2 * i : 2 * i + 2] = M[i]
        link_rows = np.zeros((2 * (n - 1), 2 * n))
        drift = rows.B.reshape(2 * (n - 1), k + 1)
        for i in range(n - 1):
            link_rows[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = -rows.turn[i]
            link_rows[2 * i : 2 * i + 2, 2 * i + 2 : 2 * i + 4] = np.eye(2)
        weight = np.concatenate([np.ones(3 * n), 1.0 / np.repeat(rows.std, 2)])
        whole = weight[:, None] * np.block([[seen, J], [link_rows, -drift[:, :-1]]])
        left = weight * np.concatenate([residual, -drift[:, -1]])
        best = np.linalg.lstsq(whole, -left, rcond=None)[0]
        cost = np.sum((left + whole @ best) ** 2)
        return here.free * np.log(cost) + np.linalg.slogdet(whole.T @ whole)[1] - 2 * np.log(weight).sum()

    ours = [unlikeliness(known.with_ratio(ratio), known.linear(truth)) for ratio in ratios]
    assert ours[1] - ours[0] == pytest.approx(dense(ratios[1]) - dense(ratios[0]), rel=1e-4)


def test_gaps_and_times_that_stand_still_cut_the_chain():
    time_s = np.array([0.0, 0.1, 0.2, 0.2, 0.3, 1.0, 1.1, 1.2, 1.4])
    np.testing.assert_allclose(steps(time_s), [0.1, 0.1, 0.0, 0.1, 0.0, 0.1, 0.1, 0.2])


def test_a_cut_chain_says_nothing_across():
    known, truth = link(200, 1e-4, 1e-3)
    cut = replace(known, step_s=np.where(np.arange(199) == 99, 0.0, known.step_s))
    halves = [replace(known, x=known.x[:100], rate_rad_s=known.rate_rad_s[:99], step_s=known.step_s[:99])]
    halves.append(replace(known, x=known.x[100:], rate_rad_s=known.rate_rad_s[100:], step_s=known.step_s[100:]))
    parts = [replace(truth, directions=truth.directions[:100]), replace(truth, directions=truth.directions[100:])]
    apart = sum(half.linear(part).square for half, part in zip(halves, parts, strict=True))
    np.testing.assert_allclose(cut.linear(truth).square, apart, rtol=1e-6, atol=1e-6 * np.abs(apart).max())
    assert cut.links == known.links - 1


def test_start_along_the_gyro_is_near():
    known, _ = link(600, 1e-4, 1e-3)
    symmetric = 0.5 * (ROOT + ROOT.T)
    seen = replace(known, x=(known.x - CENTRE) @ np.linalg.inv(ROOT).T @ symmetric + CENTRE)
    unbiased = replace(seen, rate_rad_s=known.rate_rad_s - BIAS_RAD_S)
    centre, root = turned_alike(unbiased)
    np.testing.assert_allclose(centre, CENTRE, atol=0.01)
    np.testing.assert_allclose(root, symmetric, atol=0.02)


def test_axes_of_a_gyro_in_another_frame_are_seen():
    known, truth = link(600, 1e-4, 1e-3)
    turn = Rotation.from_rotvec([0.4, -2.0, 1.1])
    askew = replace(known, rate_rad_s=turn.inv().apply(known.rate_rad_s))
    np.testing.assert_allclose(axes_of_gyro(askew, truth.directions), turn.as_matrix(), atol=0.02)


def test_the_mean_rate_of_a_step_is_that_of_a_smooth_motion() -> None:
    """Turns to and fro in two seconds at 10 Hz: a fortieth of a line's error; a line about gaps and odd steps."""
    time_s = np.arange(200) / 10.0
    time_s[100:] += 0.03
    whole_turn, w = 0.17, np.array([3.0, 2.5, 3.5])
    rate = whole_turn * np.sin(np.outer(time_s, w))
    turned = -whole_turn * np.diff(np.cos(np.outer(time_s, w)), axis=0) / w / np.diff(time_s)[:, None]
    step_s = steps(time_s)
    line, found = (rate[1:] + rate[:-1]) / 2, mean_rates(rate, step_s)
    apart = np.r_[1:97, 102:198]
    assert np.abs(found - turned)[apart].max() < 0.03 * np.abs(line - turned)[apart].max()
    np.testing.assert_array_equal(found[[0, 98, 99, 100, -1]], line[[0, 98, 99, 100, -1]])


def test_the_mean_rate_leaves_constant_rates_and_the_sum_of_the_noise() -> None:
    rate = np.random.default_rng(0).normal(size=(500, 3))
    found = mean_rates(rate, np.full(499, 0.1))
    np.testing.assert_allclose(found.sum(axis=0), rate.sum(axis=0), atol=5.0)
    np.testing.assert_allclose(mean_rates(np.ones((9, 3)), np.full(8, 0.1)), 1.0, rtol=1e-15)
