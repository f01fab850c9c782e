"""Level circles, on which the field hardly varies along the vertical, with an attitude that errs slowly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from diagnosis.workflow import diagnose
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, recording
from tests.nightly import first_daily

MODEL = ModelSpec.model_validate({"field": {"enu_nT": FIELD_ENU_NT.tolist()}})
N = 9000


@pytest.mark.parametrize("seed", first_daily([0, 1, 2]))
def test_what_hardly_shows_is_no_name_beside_errors_of_the_attitude(seed: int) -> None:
    """Columns that the iron takes up but for these errors make up for them: a turn by 34 degrees gained 300 nats."""
    rng, t = np.random.default_rng(seed), np.arange(N) / 5
    error_rad = lfilter([np.sqrt(1 - 0.997**2)], [1, -0.997], np.radians(0.02) * rng.normal(size=(N, 3)), axis=0)
    tilt = np.radians(0.01) * np.sin(0.3 * t)
    turn = Rotation.from_euler("ZYX", np.column_stack([np.radians(t), tilt, -tilt]))
    mag_nT = turn.inv().apply(FIELD_ENU_NT) + 10.0 * rng.normal(size=(N, 3))
    att_q = (Rotation.from_rotvec(error_rad) * turn).as_quat()[:, [3, 0, 1, 2]]
    given = replace(recording(N), time_s=t, mag_nT=mag_nT, att_q=att_q)
    found = diagnose(given, MODEL, fitted_base=True)
    assert not [one.name for one in found.named if not one.effect.stochastic]
    assert found.gap.before_sigma > 1.1
