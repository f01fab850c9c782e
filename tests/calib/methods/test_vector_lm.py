"""Levenberg-Marquardt on a linear model is least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from calib import get
from calib.methods.vector_least_squares import VectorLeastSquares
from calib.methods.vector_lm import VectorLmCalibrator

EDDY_S = np.array([[0.1, 0.32, 0.22], [0.13, 0.16, 0.61], [0.16, 0.17, 0.02]])


def test_same_as_least_squares(standard):
    recording = standard.recording("pitch", 1, eddy_s=EDDY_S)
    one = get("vector_lm").fit(recording, standard.REFERENCE)
    other = VectorLeastSquares(eddy=True).fit(recording, standard.REFERENCE)
    assert one.status.kind == "ok"
    np.testing.assert_allclose(one.offset_nT, other.offset_nT, atol=1e-4)
    np.testing.assert_allclose(one.eddy_s, other.eddy_s, atol=1e-8)
    order = [one.covariance_names.index(name) for name in other.covariance_names]
    claimed, expected = one.covariance[np.ix_(order, order)], other.covariance
    std = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(claimed / np.outer(std, std), expected / np.outer(std, std), atol=1e-5)
    assert one.parameters["evaluations"] < 10


def test_constant_rate_about_one_axis_cannot_tell_the_eddy_term(standard):
    time_s = np.arange(400) / 10.0
    recording = replace(standard.recording("full", None, n=400), gyro_rad_s=np.zeros((400, 3)), time_s=time_s)
    fit = get("vector_lm").fit(recording, standard.REFERENCE)
    assert fit.status.kind == "unobservable"
    assert "eddy" in fit.status.reason


def test_too_few_evaluations_are_told(standard):
    fit = VectorLmCalibrator(max_evaluations=1).fit(standard.recording("full", 1), standard.REFERENCE)
    assert fit.status.kind == "not_converged"
    assert "max_evaluations" in fit.status.reason
