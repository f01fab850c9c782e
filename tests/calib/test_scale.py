"""The unit of the measurements and the axes of the sensor do not decide the status of a fit."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import CALIBRATORS, Reference, get
from calib.methods.ml_geometric import MaximumLikelihoodGeometric
from calib.methods.sphere import SphereCalibrator
from calib.scale import field_factor, sphere_radius
from recordings import Recording
from tests.calib.expected import SECONDS_A_FIT, SLOW_WITHOUT_ANSWER, expected
from tests.calib.test_contract import fit, soft_iron, with_all

SCALED = [name for name, cls in CALIBRATORS.items() if "scalar" not in cls.needs]
"""All that calibrate the vector sensor."""
NOT_NANOTESLA = {"tesla": 1e-9, "microtesla": 1e-3, "gauss": 1e-5, "counts": 0.06842, "fine counts": 37.0}
"""Units a nT."""
CASES = ("full", "pitch", "auv", "tilts", "few")
TURNS = (Rotation.from_euler("ZYX", [0.7, -0.4, 1.9]), Rotation.from_matrix([[0, 1, 0], [0, 0, 1], [1, 0, 0]]))


def marks(name, i, j=None):
    """Two cases of each calibrator in each run, one of the slow, in turn, each with a unit; all in the nightly run."""
    turn = (0,) if name in SLOW_WITHOUT_ANSWER else (0, 2)
    taken = (SCALED.index(name) + i) % len(CASES) in turn and j in (None, i)
    return [] if taken and name not in SECONDS_A_FIT else [pytest.mark.slow]


UNITS = [
    pytest.param(name, kind, unit, marks=marks(name, i, j))
    for name in SCALED
    for i, kind in enumerate(CASES)
    for j, unit in enumerate(NOT_NANOTESLA)
]
AXES = [
    pytest.param(name, kind, TURNS[i % 2], marks=marks(name, i), id=f"{name}-{kind}")
    for name in SCALED
    for i, kind in enumerate(CASES)
]


@cache
def case(kind, name, standard):
    """A recording with noise: whole, pitch alone, a diving vehicle, a tilt of 20 degrees, and few samples."""
    soft = soft_iron(name, standard)
    if kind == "tilts":
        clean = tilted(standard, soft)
    else:
        n, motion = (100, "full") if kind == "few" else (1200, kind)
        clean = standard.recording(motion, 1, n=n, soft=soft, noise_std_nT=60.0)
    noise_rad_s = np.random.default_rng(2).normal(0.0, 1e-3, clean.mag_nT.shape)
    return replace(clean, gyro_rad_s=clean.gyro_rad_s + noise_rad_s)


def tilted(standard, soft):
    """Slow yaw with tilts of 20 degrees, in noise of 150 nT."""
    time_s = np.arange(600) / 10.0
    tilt_rad = np.radians(20.0) * np.column_stack((np.sin(0.7 * time_s), np.cos(time_s)))
    turn = Rotation.from_euler("ZYX", np.column_stack((0.3 * time_s, tilt_rad)))
    mag_nT = turn.inv().apply(standard.FIELD_ENU_NT) @ soft.T + standard.HARD_NT
    rate = (turn[:-1].inv() * turn[1:]).as_rotvec() / 0.1
    whole = replace(standard.recording("full", None, n=600), mag_nT=mag_nT, att_q=turn.as_quat(scalar_first=True))
    return standard.noisy(replace(whole, gyro_rad_s=np.concatenate((rate, rate[-1:]))), 5, 150.0)


@cache
def in_nanotesla(name, kind, standard):
    return fit(name, standard, case(kind, name, standard))


@pytest.mark.parametrize(("name", "kind", "unit"), UNITS)
def test_the_unit_of_the_measurements_does_not_matter(name, kind, unit, standard):
    recording = with_all(case(kind, name, standard), name, standard)
    one, gain = in_nanotesla(name, kind, standard), NOT_NANOTESLA[unit]
    array_nT = None if recording.array_mag_nT is None else recording.array_mag_nT * gain
    other = get(name).fit(replace(recording, mag_nT=recording.mag_nT * gain, array_mag_nT=array_nT), standard.REFERENCE)
    assert other.status.kind == one.status.kind, (one.status, other.status)
    if one.status.kind != "ok" or not expected(name).corrects:
        return
    # a method with a prior or a search in units of F has a start that depends on the size that is found
    offset, matrix = max(expected(name).turned_nT, 0.1), max(expected(name).turned_matrix, 1e-6)
    np.testing.assert_allclose(other.offset_nT / gain, one.offset_nT, atol=offset)
    np.testing.assert_allclose(other.matrix * gain, one.matrix, atol=matrix)
    rows = [i for i, key in enumerate(one.covariance_names) if key.startswith("offset")]
    std, before = (np.sqrt(np.diag(result.covariance)[rows]) for result in (other, one))
    np.testing.assert_allclose(std / gain, before, rtol=0.02)


@pytest.mark.parametrize(("name", "kind", "turn"), AXES)
def test_the_axes_do_not_matter(name, kind, turn, standard):
    if CALIBRATORS[name].one_axis:
        return
    recording, one = case(kind, name, standard), in_nanotesla(name, kind, standard)
    other = fit(name, standard, standard.turned(recording, turn))
    assert other.status.kind == one.status.kind, (one.status, other.status)


def test_a_sphere_in_counts_has_the_gain_for_a_matrix(standard):
    recording = standard.recording("full", 1, soft=1.07 * np.eye(3))
    counts = replace(recording, mag_nT=0.06842 * recording.mag_nT)
    found = SphereCalibrator().fit(counts, standard.REFERENCE)
    assert found.status.kind == "ok"
    np.testing.assert_allclose(found.matrix, np.eye(3) / (1.07 * 0.06842), atol=1e-3 / 0.06842)


@pytest.mark.parametrize("strength_nT", [1.0, 25_000.0, 1e6])
def test_the_strength_does_not_decide(strength_nT, standard):
    """The field's strength sets the scale of the result and nothing else."""
    for kind in CASES:
        recording = case(kind, "ellipsoid", standard)
        kinds = {get("ellipsoid").fit(recording, Reference(f)).status.kind for f in (strength_nT, 37_000.0)}
        assert len(kinds) == 1


def test_an_unknown_strength_is_found_in_the_unit_of_the_measurements(standard):
    recording = standard.recording("full", 1)
    method = MaximumLikelihoodGeometric(strength_known=False)
    one = method.fit(recording, standard.REFERENCE)
    other = method.fit(replace(recording, mag_nT=recording.mag_nT * 1e-3), standard.REFERENCE)
    np.testing.assert_allclose(other.matrix, one.matrix, rtol=1e-9, atol=1e-9)
    assert other.parameters["strength_nT"] == pytest.approx(1e-3 * one.parameters["strength_nT"], rel=1e-9)
    assert other.parameters["noise_std_nT"] == pytest.approx(1e-3 * one.parameters["noise_std_nT"], rel=1e-6)


def test_the_radius_is_that_of_the_sphere_and_of_a_circle():
    directions = np.random.default_rng(0).normal(size=(500, 3))
    sphere = 7.0 * directions / np.linalg.norm(directions, axis=1)[:, None] + [100.0, -20.0, 3.0]
    assert sphere_radius(sphere) == pytest.approx(7.0)
    angle = np.linspace(0.0, 2.0, 50)
    circle = np.column_stack((3.0 * np.cos(angle), 3.0 * np.sin(angle), np.full(50, 2.0)))
    assert sphere_radius(circle) == pytest.approx(3.0)


def test_of_a_sensor_that_hardly_turns_lengths_are_told_in_its_own_unit() -> None:
    """In nT, 400 rms about a mean of 48,000: the sphere through such a cluster has any radius."""
    cluster_nT = np.array([21_500.0, -1000.0, -43_000.0]) + np.random.default_rng(3).normal(0, 400, (450, 3))
    recording = Recording(np.arange(450) / 15, cluster_nT)
    assert field_factor(recording, Reference(48_272.0), vector=False, one_axis=False) == 1.0
    told = re.search(r"to within (\d+) nT", get("sphere").fit(recording, Reference(48_272.0)).status.reason)
    assert told is not None
    assert 300 < float(told[1]) < 500
