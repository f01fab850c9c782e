"""Noise of neighbours where nearly every row repeats the one before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.validation.diagnosis.synthetic import FIELD_ENU_NT, STRENGTH_NT, recording
from validation.diagnosis.problem.pose import pose


def test_a_leg_at_rest_without_noise_poses_a_problem() -> None:
    """The simulator's vehicle at rest: the same values for all but the rounding of a few."""
    turning = recording(400, noise_nT=1e-3)
    assert turning.att_q is not None
    mag_nT = np.tile(turning.mag_nT[:1], (400, 1))
    mag_nT[200, 2] += 1e-11
    resting = replace(turning, mag_nT=mag_nT, att_q=np.tile(turning.att_q[:1], (400, 1)))
    posed = pose(resting, FIELD_ENU_NT, STRENGTH_NT, ())
    assert (posed.sigma_nT > 0).all()
    assert np.isfinite(posed.turn).all()
