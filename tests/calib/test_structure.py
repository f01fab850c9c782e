"""The reason of a doubtful fit names its cause: an uneven room, a characteristic, or directions that are missing."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from calib import Reference, get
from recordings import Recording
from tests.calib.flickering import flicker

F_NT = 48_000.0
SOFT = np.array([[1.05, 0.02, -0.01], [0.02, 0.96, 0.015], [-0.01, 0.015, 1.01]])
HARD_NT = np.array([12_000.0, -8_000.0, 25_000.0])
STRENGTH = pytest.mark.parametrize("name", ["ellipsoid", "twostep", "ml_newton", "ml_geometric"])


@cache
def field_nT(seed: int, n: int = 4000) -> np.ndarray:
    """The field (n, 3) in a body that is turned at random over the whole sphere, 0.1 rad a sample in the mean."""
    rng = np.random.default_rng(seed)
    steps = gaussian_filter1d(rng.normal(size=(n, 3)), 20, axis=0)
    turn = Rotation.identity()
    directions = np.empty((n, 3))
    for k, step in enumerate(0.06 * steps / steps.std()):
        turn = turn * Rotation.from_rotvec(step)
        directions[k] = turn.inv().apply([0.0, 0.44, -0.898])
    return F_NT * directions / np.linalg.norm(directions, axis=1)[:, None]


@cache
def flickering_nT(seed: int, n: int) -> np.ndarray:
    """Flicker noise (n, 3) of a seed, the same for every method."""
    return 5.0 * flicker(n, np.random.default_rng(seed))


def slow(n: int, seed: int, width: float) -> np.ndarray:
    """Smooth noise (n, 3) of variance one."""
    values = gaussian_filter1d(np.random.default_rng([seed, 9]).normal(size=(n, 3)), width, axis=0)
    return np.asarray(values / values.std())


def measured(h_nT, seed, extra_nT=0.0):
    noise_nT = np.random.default_rng([seed, 1]).normal(0.0, 150.0, h_nT.shape)
    return Recording(0.1 * np.arange(len(h_nT)), h_nT @ SOFT.T + HARD_NT + noise_nT + extra_nT)


def cubic(h_nT, part=0.03):
    """What a characteristic of the axes adds: 3 % of the field at the end of the range."""
    return part * F_NT * (h_nT @ SOFT.T / F_NT) ** 3


def distances(fit):
    return (fit.offset_nT - HARD_NT) / np.sqrt(np.diag(fit.offset_covariance_nT2))


@STRENGTH
def test_half_a_sphere_with_a_characteristic_is_doubted_or_claims_enough(name):
    for seed in range(4):
        h_nT = field_nT(seed)
        h_nT = h_nT[h_nT[:, 0] > -0.33 * F_NT]
        fit = get(name).fit(measured(h_nT, seed, cubic(h_nT)), Reference(F_NT))
        assert "characteristic" in fit.status.reason
        assert np.abs(distances(fit)).max() < 2.5
        assert fit.status.kind != "ok" or np.linalg.norm(fit.offset_nT - HARD_NT) < 0.015 * F_NT


@STRENGTH
def test_a_whole_sphere_with_a_characteristic_is_no_missing_motion(name):
    for seed in range(3):
        h_nT = field_nT(seed)
        fit = get(name).fit(measured(h_nT, seed, cubic(h_nT)), Reference(F_NT))
        assert "characteristic" in fit.status.reason
        assert "further" not in fit.status.reason
        assert np.abs(distances(fit)).max() < 3.0
        assert np.sqrt(np.trace(fit.offset_covariance_nT2)) < 0.005 * F_NT


@pytest.mark.parametrize("share", [0.005, 0.02])
@STRENGTH
def test_an_uneven_room_is_named(name, share):
    for seed in range(3):
        h_nT = field_nT(seed)
        h_nT = h_nT * (1.0 + share * slow(len(h_nT), seed, 60.0)[:, :1])
        fit = get(name).fit(measured(h_nT, seed), Reference(F_NT))
        assert "uneven room" in fit.status.reason
        assert "further" not in fit.status.reason
        assert np.abs(distances(fit)).max() < 2.5


def test_drift_of_the_axes_is_named():
    for seed in range(3):
        h_nT = field_nT(seed)
        fit = get("ellipsoid").fit(measured(h_nT, seed, 150.0 * slow(len(h_nT), seed, 200.0)), Reference(F_NT))
        assert "drift" in fit.status.reason


@pytest.mark.parametrize("least", [-1.1, -0.5, 0.0, 0.3])
@STRENGTH
def test_white_and_flicker_noise_are_no_structure(name, least):
    for seed in range(3):
        h_nT = field_nT(seed)
        h_nT = h_nT[h_nT[:, 0] > least * F_NT]
        assert "not noise" not in get(name).fit(measured(h_nT, seed), Reference(F_NT)).status.reason
        flickering = measured(h_nT, seed, flickering_nT(seed, len(h_nT)))
        assert "not noise" not in get(name).fit(flickering, Reference(F_NT)).status.reason


def test_missing_directions_still_ask_for_motion():
    """Drift on a small part of the sphere: more directions would help, and the reason asks for motion."""
    h_nT = field_nT(0)
    few = h_nT[(h_nT[:, 2] < -0.8 * F_NT)]
    fit = get("ellipsoid").fit(measured(few, 0, 60.0 * slow(len(few), 0, 30.0)), Reference(F_NT))
    assert fit.status.kind == "unobservable"
    assert "roll and pitch further" in fit.status.reason


def test_an_uneven_room_is_named_on_half_a_sphere():
    h_nT = field_nT(0)
    h_nT = h_nT * (1.0 + 0.015 * slow(len(h_nT), 0, 60.0)[:, :1])
    status = get("ellipsoid").fit(measured(h_nT[h_nT[:, 0] > -0.33 * F_NT], 0), Reference(F_NT)).status
    assert status.kind == "unobservable"
    assert "uneven room" in status.reason


@pytest.mark.parametrize("gain", [1.0, 0.0684])
def test_the_cause_does_not_depend_on_the_unit(gain):
    h_nT = field_nT(1)
    h_nT = h_nT[h_nT[:, 0] > -0.33 * F_NT]
    recording = measured(h_nT, 1, cubic(h_nT))
    fit = get("ellipsoid").fit(replace(recording, mag_nT=gain * recording.mag_nT), Reference(F_NT))
    assert "characteristic" in fit.status.reason


@pytest.mark.parametrize("n", [10, 16, 40])
def test_few_poses_are_answered_with_wide_intervals(n):
    inside = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        u = rng.normal(size=(n, 3))
        h_nT = F_NT * u / np.linalg.norm(u, axis=1)[:, None]
        fit = get("ellipsoid").fit(
            Recording(np.arange(n) * 10.0, h_nT @ SOFT.T + HARD_NT + rng.normal(0, 15, (n, 3))), Reference(F_NT)
        )
        if fit.covariance is not None:
            inside.append(np.abs(distances(fit)) < 1.96)
    assert len(inside) > 30
    assert 0.88 < np.mean(inside) <= 1.0
