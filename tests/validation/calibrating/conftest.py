"""A recording for calibrators of every kind."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Reference
from recordings import Recording

OFFSET_NT = (100.0, -200.0, 300.0)


@pytest.fixture(scope="session")
def reference() -> Reference:
    """A field of 50 uT, by its vector."""
    return Reference.of_vector((0.0, 30_000.0, -40_000.0))


@pytest.fixture(scope="session")
def recording() -> Recording:
    """A sensor with OFFSET_NT and noise of 2 nT, turned every way."""
    rng = np.random.default_rng(0)
    field_nT = Rotation.random(200, rng=rng).apply([0.0, 30_000.0, -40_000.0])
    return Recording(np.arange(200.0), field_nT + rng.normal(OFFSET_NT, 2.0, (200, 3)))
