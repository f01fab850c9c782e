"""A covariance grows with what is left in the residuals, and does not where they are white."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from calib import get
from calib.numerics.colour import BLOCKS, inflation, white_ratios
from recordings import Recording


def test_white_residuals_are_left_alone() -> None:
    factors = [inflation(np.random.default_rng(seed).standard_normal((3600, 3))) for seed in range(200)]
    assert np.mean(np.array(factors) > 1.0) < 0.02


@pytest.mark.parametrize(("variance", "seen"), [(1.6, False), (1.9, True)])
def test_block_means_beyond_chance_count(variance: float, seen: bool) -> None:
    """Twenty blocks on three axes scatter by sqrt(2 / 60): four of that above 1 is 1.73.

    Rows in pairs of opposite sign but for the blocks' means, which are +-m: W = 200 m^2 / (1 + m^2).
    """
    m = np.sqrt(variance / (200 - variance))
    means = np.repeat(np.where(np.arange(20) % 2, m, -m), 200)
    residual = np.tile([1.0, -1.0], 2000) + means
    factor = inflation(np.column_stack([residual] * 3))
    assert factor == pytest.approx(variance if seen else 1.0, rel=1e-9)


def test_sums_over_blocks_tell_the_same_inflation() -> None:
    """As many samples a block as in 20, 50 and 200 blocks; the residual's mean is taken out before."""
    drift = 0.2 * np.sin(np.arange(4000) / 500)
    residual = np.random.default_rng(0).standard_normal((4000, 3)) + drift[:, None]
    residual -= residual.mean(axis=0)
    residual /= residual.std()
    sums = {n: residual.reshape(n, -1, 3).sum(axis=1) for n in BLOCKS}
    ratios = [white_ratios(total, np.full(n, 4000 / n)).mean() for n, total in sums.items()]
    assert max(ratios) > 2
    assert max(ratios) == pytest.approx(inflation(residual), rel=1e-6)


def test_coloured_residuals_count_as_many_fewer_samples() -> None:
    p = np.exp(-1.0 / 50.0)  # first-order, 50 samples: (1 + p) / (1 - p) = 100 times fewer independent ones
    coloured = lfilter([1.0], [1.0, -p], np.random.default_rng(0).standard_normal((40_000, 3)), axis=0)
    assert 0.3 * 100 < inflation(coloured) < 1.5 * 100


@pytest.mark.parametrize("name", ["ellipsoid", "twostep", "ml_newton"])
def test_drift_makes_a_weak_motion_unsure(name: str, standard) -> None:  # type: ignore[no-untyped-def]
    still: Recording = standard.recording("pitch", 0)
    drift_nT = np.outer(still.time_s / still.time_s[-1], [300.0, -200.0, 250.0])
    drifting = replace(still, mag_nT=still.mag_nT + drift_nT)
    calm, moved = (get(name).fit(recording, standard.REFERENCE) for recording in (still, drifting))
    assert calm.status.kind == "ok"
    assert calm.parameters["covariance_inflation"] == 1.0
    assert moved.parameters["covariance_inflation"] > 5.0
