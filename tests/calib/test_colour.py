"""A covariance grows with what is left in the residuals, and does not where they are white."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from calib import get
from calib.colour import inflation
from sim.dataset import Recording


def test_white_residuals_are_left_alone() -> None:
    factors = [inflation(np.random.default_rng(seed).standard_normal((3600, 3))) for seed in range(200)]
    assert np.mean(np.array(factors) > 1.0) < 0.02


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
