"""The fit of iron: what of the samples are failures."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.iron_fit import _near
from diagnosis.problem.vector import robust_fit


@pytest.mark.parametrize(("share", "left_out"), [(0.15, True), (0.25, False)])
def test_far_samples_are_failures_unless_they_are_many(share: float, left_out: bool) -> None:
    """A fifth that is off is a gap, and bends the fit."""
    rng, n = np.random.default_rng(0), 1000
    far = np.arange(n) < share * n
    off = np.abs(rng.normal(size=n)) + 100.0 * far
    assert (_near(off, STANDARD) == 0).any() is np.bool_(left_out)
    either = 100.0 * far * np.where(np.arange(n) % 3, 1, -1)
    beta = robust_fit(np.ones((n, 1)), (rng.normal(size=n) + either)[:, None], STANDARD)
    assert (abs(float(beta[0, 0])) < 1.0) is left_out
