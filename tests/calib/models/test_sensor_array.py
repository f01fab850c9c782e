"""Arrays of magnetometers: the model against the simulator's, the objective, exactness, claimed spread, statuses."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, Status, from_json, get, to_json
from calib.families.gradiometer import ArrayEstimate, polished
from calib.methods.ide_gradiometer import IdeGradiometer
from calib.methods.least_squares_gradiometer import LeastSquaresGradiometer
from calib.methods.two_step_gradiometer import TwoStepGradiometer
from calib.models.array_spread import sample_residuals
from calib.models.sensor_array import (
    array_objective,
    corrected,
    free_parameters,
    invariants,
    maps,
    parameters_of,
    residual_size,
    residuals,
    tensor,
)
from recordings import Recording
from scenarios.errors import InputError
from sim.effects.papers import ding2021_axes, ding2021_turn
from tests.calib.expected import OTHER_SEARCHES

STRENGTH_NT = 52_000.0
REFERENCE = Reference(STRENGTH_NT)
METHODS = ("ide_gradiometer", "de_gradiometer", "ga_gradiometer", "least_squares_gradiometer", "two_step_gradiometer")


def draw(seed, n=200, noise_nT=0.0, k=4, spread_rad=None):
    """A recording of k sensors, and its parameters (k, 12): offset (nT), scale, psi, phi, theta, alpha, beta, gamma."""
    rng = np.random.default_rng(seed)
    turn = (
        Rotation.random(n, rng=rng)
        if spread_rad is None
        else Rotation.from_rotvec(rng.uniform(-spread_rad, spread_rad, (n, 3)))
    )
    field = turn.apply([0.0, 0.6 * STRENGTH_NT, -0.8 * STRENGTH_NT])
    truth = np.column_stack((rng.uniform(-200, 200, (k, 3)), rng.uniform(0.9, 1.1, (k, 3)), rng.uniform(-2, 2, (k, 6))))
    truth[0, 9:] = 0.0
    S = [np.diag(row[3:6]) @ ding2021_axes(*row[6:9]) @ ding2021_turn(tuple(row[9:])).T for row in truth]
    array = np.array([field @ S[i].T + truth[i, :3] for i in range(k)])
    array += rng.normal(0.0, noise_nT, array.shape) if noise_nT else 0.0
    return Recording(np.arange(n, dtype=float), array[0], array_mag_nT=array), truth, field


def vector(truth):
    """The parameter vector of calib.models.sensor_array."""
    return np.column_stack((truth[:, :3] / STRENGTH_NT, truth[:, 3:6], np.radians(truth[:, 6:]))).ravel()


def found(fit, k=4):
    return np.array(list(fit.parameters.values())[: 12 * k]).reshape(k, 12)


def test_model_is_the_simulators():
    recording, truth, field = draw(0)
    np.testing.assert_allclose(
        STRENGTH_NT * corrected(vector(truth), recording.array_mag_nT / STRENGTH_NT),
        np.tile(field, (4, 1, 1)),
        atol=1e-7,
    )


def test_parameters_come_back_out_of_matrices():
    _, truth, _ = draw(1)
    p = vector(truth)
    matrix, _ = maps(p, 4)
    back = [parameters_of(p[12 * i : 12 * i + 3], matrix[i]) for i in range(4)]
    np.testing.assert_allclose(np.concatenate(back), p, atol=1e-13)


def test_short_objective_is_the_long_one():
    recording, truth, _ = draw(2, noise_nT=5.0)
    task = array_objective(recording.array_mag_nT, STRENGTH_NT, 0.7, 1.3)
    p = vector(truth) + 1e-3 * np.random.default_rng(0).normal(size=48)
    short = residuals(p, task, np.empty(residual_size(task)))
    h = corrected(p, task.field)
    total = (((h**2).sum(axis=2) - 1) ** 2 / 4).mean(axis=1).sum()
    pairs = sum(((h[i] - h[j]) ** 2).sum(axis=1).mean() for i in range(4) for j in range(i))
    expected = total + 0.7 / 4 * pairs + 1.3 * (tensor(h, 1.0) ** 2).sum(axis=1).mean()
    np.testing.assert_allclose(short, expected, rtol=1e-10)
    np.testing.assert_allclose((sample_residuals(task, p) ** 2).sum(axis=1).mean(), expected, rtol=1e-10)


def test_invariants_are_those_of_the_eigenvalues():
    rows = np.random.default_rng(3).normal(size=(50, 5))
    full = np.array([[[a, b, c], [b, d, e], [c, e, -a - d]] for a, b, c, d, e in rows])
    l3, l2, l1 = np.linalg.eigvalsh(full).T
    expected = np.column_stack((l1 * l2 + l2 * l3 + l1 * l3, l1 * l2 * l3, np.sqrt(-(l2**2) - l1 * l3)))
    np.testing.assert_allclose(invariants(rows), expected, atol=1e-6)


def test_tensor_of_a_uniform_gradient():
    G = np.array([[3.0, 1.0, -2.0], [1.0, -4.0, 0.5], [-2.0, 0.5, 1.0]])
    place = 0.2 * np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    field = (place @ G.T)[:, None, :] + [100.0, 200.0, 300.0]
    np.testing.assert_allclose(tensor(field, 0.4), [[3.0, 1.0, -2.0, -4.0, 0.5]])


@pytest.mark.parametrize("method", [IdeGradiometer(polish=False), LeastSquaresGradiometer(), TwoStepGradiometer()])
def test_all_48_parameters_without_noise(method):
    recording, truth, field = draw(4)
    fit = method.fit(recording, REFERENCE)
    assert fit.status == Status("ok")
    error = np.abs(found(fit) - truth)
    assert error[:, :3].max() < 1e-5
    assert error[:, 3:].max() < 1e-8
    np.testing.assert_allclose(fit.apply_array(recording), np.tile(field, (4, 1, 1)), atol=1e-4)
    np.testing.assert_allclose(fit.apply(recording), field, atol=1e-4)


def test_evolution_ends_in_the_least_squares_minimum():
    recording, _, _ = draw(5, noise_nT=5.0)
    evolved = IdeGradiometer(polish=False).fit(recording, REFERENCE)
    squares = LeastSquaresGradiometer(start="two_step").fit(recording, REFERENCE)
    std = np.sqrt(np.diag(squares.covariance))
    free = free_parameters(4)
    assert np.abs((found(evolved) - found(squares)).ravel()[free] / std).max() < 1e-3
    assert evolved.history[0] > 100 * evolved.history[-1]


def test_claimed_spread_is_the_spread():
    scores = []
    for seed in range(24):
        recording, truth, _ = draw(100 + seed, n=100, noise_nT=4.0)
        fit = LeastSquaresGradiometer().fit(recording, REFERENCE)
        scores.append((found(fit) - truth).ravel()[free_parameters(4)] / np.sqrt(np.diag(fit.covariance)))
        assert 3.3 < fit.parameters["noise_std_nT"] < 4.7
    assert 0.9 < np.sqrt(np.mean(np.square(scores))) < 1.1


@pytest.mark.parametrize("k", [2, 3])
def test_other_numbers_of_sensors(k):
    recording, truth, _ = draw(6, k=k)
    fit = LeastSquaresGradiometer().fit(recording, REFERENCE)
    assert fit.status == Status("ok")
    np.testing.assert_allclose(found(fit, k)[:, :3], truth[:, :3], atol=1e-4)


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=[pytest.mark.slow] * (one in OTHER_SEARCHES)) for one in METHODS]
)
def test_statuses(name):
    recording, _, _ = draw(7, noise_nT=5.0)
    ten = replace(
        recording,
        time_s=recording.time_s[:10],
        mag_nT=recording.mag_nT[:10],
        array_mag_nT=recording.array_mag_nT[:, :10],
    )
    assert get(name).fit(ten, REFERENCE).status.kind == "not_applicable"
    one = get(name).fit(recording.sensor(0), REFERENCE).status
    assert (one.kind, "mag1_x_nT" in one.reason) == ("not_applicable", True)
    lone = get(name).fit(replace(recording, array_mag_nT=recording.array_mag_nT[:1]), REFERENCE).status
    assert (lone.kind, "one sensor" in lone.reason) == ("not_applicable", True)
    little = get(name).fit(draw(8, noise_nT=5.0, spread_rad=0.02)[0], REFERENCE).status
    assert little.kind == "unobservable", little


def test_unfinished_search_is_not_called_converged():
    recording, _, _ = draw(9)
    status = IdeGradiometer(iterations=50, polish=False).fit(recording, REFERENCE).status
    assert status.kind == "not_converged"


def test_least_squares_from_the_edge_of_the_search_space():
    recording, truth, _ = draw(10)
    low, high = IdeGradiometer().bounds(4)
    task = array_objective(recording.array_mag_nT, STRENGTH_NT)
    corner = np.where(np.random.default_rng(0).random(48) < 0.5, low, high)
    np.testing.assert_allclose(polished(task, ArrayEstimate(corner)).parameters, vector(truth), atol=1e-9)


def test_one_sensor_of_an_array():
    recording, truth, _ = draw(11, noise_nT=1.0)
    fit = LeastSquaresGradiometer().fit(recording, REFERENCE)
    third = fit.of_sensor(2)
    np.testing.assert_array_equal(third.offset_nT, fit.array_offset_nT[2])
    np.testing.assert_allclose(third.apply(recording.sensor(2)), fit.apply_array(recording)[2])
    assert third.parameters["offset_x_nT"] == fit.parameters["offset_x_nT@3"]
    assert third.offset_covariance_nT2.shape == (3, 3)
    error = third.offset_nT - truth[2, :3]
    assert error @ np.linalg.solve(third.offset_covariance_nT2, error) < 25.0
    assert fit.of_sensor(0).parameters["gamma_deg"] == 0.0


def test_array_in_json():
    fit = LeastSquaresGradiometer().fit(draw(12, noise_nT=1.0)[0], REFERENCE)
    other = from_json(to_json(fit))
    np.testing.assert_array_equal(other.array_matrix, fit.array_matrix)
    with pytest.raises(InputError, match="array_offset_nT: missing beside array_matrix"):
        from_json(json.dumps(json.loads(to_json(fit)) | {"array_offset_nT": None}))


def test_no_array_to_apply_to():
    recording, _, _ = draw(13)
    with pytest.raises(InputError, match="no array"):
        Calibration(name="x", status=Status("ok")).apply_array(recording)
