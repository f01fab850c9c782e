"""How a sample's noise moves a fit, against the fit of a recording in which it is moved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib import get
from calib.methods.gyro_ml import GyroMl
from calib.methods.ml_geometric import MaximumLikelihoodGeometric
from calib.models.response import of_strength, of_vector

BUMP_NT = np.array([0.3, -0.2, 0.1])


def bumped(recording):
    """For 40 s every measurement is moved alike."""
    moved_nT = np.zeros_like(recording.mag_nT)
    moved_nT[1000:1400] = BUMP_NT
    return replace(recording, mag_nT=recording.mag_nT + moved_nT), moved_nT


def change(method, recording, reference, names):
    """Of the parameters named, when the recording is bumped."""
    before, after = (method.fit(one, reference) for one in (recording, bumped(recording)[0]))
    return before, np.array([after.parameters[name] - before.parameters[name] for name in names])


@pytest.mark.parametrize("motion", ["full", "pitch"])
def test_strength(motion, standard):
    recording = standard.recording(motion, 1)
    method = MaximumLikelihoodGeometric(tolerance=1e-7)
    fit = method.fit(recording, standard.REFERENCE)
    response = of_strength(fit, fit.apply(recording), standard.REFERENCE.strength_nT)
    found = change(method, recording, standard.REFERENCE, response.names)[1]
    expected = np.einsum("npc,nc->p", response.K, bumped(recording)[1])
    np.testing.assert_allclose(expected, found, atol=0.02 * np.abs(found).max(), rtol=0.05)


def test_scale_alone(standard):
    recording = standard.recording("full", 1, soft=1.07 * np.eye(3))
    fit = get("sphere").fit(recording, standard.REFERENCE)
    response = of_strength(fit, fit.apply(recording), standard.REFERENCE.strength_nT)
    found = change(get("sphere"), recording, standard.REFERENCE, response.names)[1]
    expected = np.einsum("npc,nc->p", response.K, bumped(recording)[1])
    np.testing.assert_allclose(expected, found, rtol=0.02)


def test_vector(standard):
    recording = standard.recording("pitch", 1)
    response = of_vector(standard.attitude("pitch", recording.time_s).inv().apply(standard.FIELD_ENU_NT))
    found = change(get("vector_least_squares"), recording, standard.REFERENCE, response.names)[1]
    np.testing.assert_allclose(np.einsum("npc,nc->p", response.K, bumped(recording)[1]), found, rtol=1e-6)


def test_linked(standard):
    """The gyro's noise held: the ratio that is fitted would move the estimate a little too."""
    recording = standard.recording("pitch", 1)
    noise_rad_s = np.random.default_rng(0).normal(0, 1e-3, recording.gyro_rad_s.shape)
    recording = replace(recording, gyro_rad_s=recording.gyro_rad_s + noise_rad_s)
    method = GyroMl(gyro_std_rad_s=1e-3, tolerance=1e-5)
    strength_nT = standard.REFERENCE.strength_nT
    link = method._link(recording, strength_nT)
    response = method._response(method._rounds(link, method._first(link)), strength_nT)
    moved = change(method, recording, standard.REFERENCE, response.names)[1]
    expected = np.einsum("npc,nc->p", response.K, bumped(recording)[1])
    np.testing.assert_allclose(expected[:3], moved[:3], rtol=0.01)
    np.testing.assert_allclose(expected[3:12], moved[3:12], rtol=0.05, atol=0.02 * np.abs(moved[3:12]).max())
