"""What every registered calibrator must hold."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import CALIBRATORS, Calibration, Reference, from_json, get, to_json
from scenarios.errors import InputError
from tests.calib.expected import OTHER_SEARCHES, SECONDS_A_FIT, expected

ALL = pytest.mark.parametrize("name", list(CALIBRATORS))
ONE_OF_THE_SEARCHES = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in OTHER_SEARCHES)) for name in CALIBRATORS]
)
QUICK = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SECONDS_A_FIT)) for name in CALIBRATORS]
)
"""All, those that take seconds a fit in the nightly run."""
TURN = Rotation.from_euler("ZYX", [0.7, -0.4, 1.9])


def with_all(recording, name, standard):
    """The recording with what the method needs beside attitude and gyro."""
    if "accel" in CALIBRATORS[name].needs:
        recording = standard.with_accelerometer(recording)
    if "array" in CALIBRATORS[name].needs:
        recording = standard.with_array(recording)
    if "input" in CALIBRATORS[name].needs:
        recording = standard.with_currents(recording)
    if "scalar" in CALIBRATORS[name].needs:
        with np.errstate(over="ignore"):
            recording = replace(recording, channels={"scalar_nT": np.linalg.norm(recording.mag_nT, axis=1)})
    return recording


def fit(name, standard, recording, reference=None, seed=0):
    recording = with_all(recording, name, standard)
    return get(name).fit(recording, reference or standard.REFERENCE, np.random.default_rng(seed))


@cache
def usual(name, standard):
    """A recording that every method can use, and what the method made of it."""
    recording = standard.recording("full", 1, n=1200, soft=soft_iron(name, standard))
    return recording, fit(name, standard, recording)


def soft_iron(name, standard):
    """The soft iron that the method's own model can hold."""
    return 1.07 * np.eye(3) if expected(name).scale_alone else standard.SOFT


def comparable(name, matrix):
    """The matrix, or what is left of it when the frame of the corrected field is the sensor's own."""
    return matrix.T @ matrix if CALIBRATORS[name].triangular else matrix


def no_silent_nan(result):
    values = (result.offset_nT, result.matrix, result.eddy_s, result.covariance, list(result.parameters.values()))
    return all(np.isfinite(v).all() for v in values if v is not None)


@QUICK
@pytest.mark.parametrize("motion", ["full", "pitch", "auv"])
def test_noise_free_recording_is_recovered_or_declined(name, motion, standard):
    soft, limits = soft_iron(name, standard), expected(name)
    result = fit(name, standard, standard.recording(motion, None, soft=soft))
    if motion in limits.recovers:
        assert result.status.kind == "ok", result.status
    if result.status.kind != "ok" or not limits.corrects:
        assert result.status.reason or not limits.corrects
        return
    np.testing.assert_allclose(result.offset_nT, standard.HARD_NT, atol=limits.offset_nT)
    found, truth = comparable(name, result.matrix), comparable(name, np.linalg.inv(soft))
    np.testing.assert_allclose(found, truth, atol=limits.matrix)


@QUICK
def test_what_it_says_that_it_estimates_is_estimated(name, standard):
    """The bound that its scores are held against is that of its own parameters."""
    assert (usual(name, standard)[1].eddy_s is not None) == bool(getattr(CALIBRATORS[name], "eddy", False))


@QUICK
def test_turning_the_sensor_turns_the_result(name, standard):
    recording, one = usual(name, standard)
    other = fit(name, standard, standard.turned(recording, TURN))
    if "ok" not in (one.status.kind, other.status.kind) and not expected(name).recovers:
        return
    q = TURN.as_matrix()
    np.testing.assert_allclose(other.offset_nT, q @ one.offset_nT, atol=expected(name).turned_nT)
    before = q @ comparable(name, one.matrix) @ q.T
    np.testing.assert_allclose(comparable(name, other.matrix), before, atol=expected(name).turned_matrix)


@QUICK
def test_unit_does_not_matter(name, standard):
    if not expected(name).unit_free:
        return
    recording, one = usual(name, standard)
    in_uT = Reference.of_vector(tuple(np.array(standard.FIELD_ENU_NT) / 1000))
    other = fit(name, standard, replace(recording, mag_nT=recording.mag_nT / 1000), in_uT)
    assert other.status.kind == one.status.kind
    np.testing.assert_allclose(1000 * other.offset_nT, one.offset_nT, atol=expected(name).turned_nT)
    np.testing.assert_allclose(other.matrix, one.matrix, atol=expected(name).turned_matrix)


@QUICK
def test_order_of_samples_does_not_matter(name, standard):
    if CALIBRATORS[name].sequential:
        return
    recording, one = usual(name, standard)
    order = np.random.default_rng(0).permutation(len(recording))
    shuffled = replace(
        recording, mag_nT=recording.mag_nT[order], gyro_rad_s=recording.gyro_rad_s[order], att_q=recording.att_q[order]
    )
    other = fit(name, standard, shuffled)
    np.testing.assert_allclose(other.offset_nT, one.offset_nT, atol=expected(name).turned_nT)
    np.testing.assert_allclose(other.matrix, one.matrix, atol=expected(name).turned_matrix)


@QUICK
def test_a_log_without_wild_values_is_fitted_as_if_none_were_looked_for(name, standard):
    recording, one = usual(name, standard)
    plain = replace(get(name), robust=False)
    other = plain.fit(with_all(recording, name, standard), standard.REFERENCE, np.random.default_rng(0))
    assert to_json(replace(other, wall_s=0.0)) == to_json(replace(one, wall_s=0.0))


@ONE_OF_THE_SEARCHES
def test_same_seed_same_bytes_and_the_recording_is_never_modified(name, standard):
    recording, one = usual(name, standard)
    before = {f.name: np.copy(v) for f in fields(recording) if isinstance(v := getattr(recording, f.name), np.ndarray)}
    other = fit(name, standard, recording)
    assert to_json(replace(other, wall_s=0.0)) == to_json(replace(one, wall_s=0.0))
    for key, value in before.items():
        np.testing.assert_array_equal(getattr(recording, key), value)
        assert getattr(recording, key).flags.writeable


@ONE_OF_THE_SEARCHES
def test_save_and_load(name, standard):
    result = usual(name, standard)[1]
    assert to_json(from_json(to_json(result))) == to_json(result)


@ALL
def test_too_few_samples(name, standard):
    recording = standard.recording("full", 0, n=CALIBRATORS[name].min_samples - 1)
    status = fit(name, standard, recording).status
    assert status.kind == "not_applicable"
    assert "record longer" in status.reason


LEVEL = [(None, 3600), (7, 600), (None, 36_000), (7, 36_000)]
"""Seeds and samples of level turns: the first two by day, of `gyro_accel_ml` the first, since `gyro_ml` tries as it."""


def daily_turns(name):
    """How many of LEVEL a calibrator takes by day."""
    return 0 if name in OTHER_SEARCHES else 1 if name == "gyro_accel_ml" else 2


@pytest.mark.parametrize(
    ("name", "seed", "n"),
    [
        pytest.param(name, *case, marks=[pytest.mark.slow] * (k >= daily_turns(name)))
        for name in CALIBRATORS
        for k, case in enumerate(LEVEL)
    ],
)
def test_level_turns_say_nothing_of_the_vertical(name, seed, n, standard):
    least = 1200 if "array" in CALIBRATORS[name].needs else 0  # fewer poses leave more of an array open
    result = fit(name, standard, standard.level_turns(max(n, least), seed))
    if CALIBRATORS[name].own_judgement:  # made for level turns, or for none: the vertical has no claim
        assert "offset_z_nT" not in result.covariance_names
        return
    assert result.status.kind == "unobservable"
    assert "body z" in result.status.reason
    assert "roll and pitch" in result.status.reason
    assert no_silent_nan(result)


@ALL
def test_constant_field(name, standard):
    recording = standard.recording("full", 0)
    still = replace(recording, mag_nT=np.tile(recording.mag_nT[:1], (len(recording), 1)))
    status = fit(name, standard, still).status
    assert status.kind == "unobservable"
    assert "does not change" in status.reason


@ALL
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_values_that_are_not_finite(name, value, standard):
    recording = standard.recording("full", 0)
    mag_nT = recording.mag_nT.copy()
    mag_nT[17, 1] = value
    result = fit(name, standard, replace(recording, mag_nT=mag_nT))
    assert result.status.kind == "not_applicable"
    assert "mag_nT has 1 value" in result.status.reason
    assert no_silent_nan(result)


@ALL
def test_what_is_missing_is_named(name, standard):
    bare = replace(standard.recording("full", 0), att_q=None, gyro_rad_s=None)
    no_vector = Reference(standard.REFERENCE.strength_nT)
    if "attitude" in CALIBRATORS[name].needs:
        status = fit(name, standard, bare).status
        assert (status.kind, "att_qw" in status.reason) == ("not_applicable", True)
    if "field_vector" in CALIBRATORS[name].needs:
        status = fit(name, standard, standard.recording("full", 0), no_vector).status
        assert (status.kind, "field vector" in status.reason) == ("not_applicable", True)
    if "array" in CALIBRATORS[name].needs:
        status = get(name).fit(bare, no_vector).status
        assert (status.kind, "mag1_x_nT" in status.reason) == ("not_applicable", True)
    if "input" in CALIBRATORS[name].needs:
        status = get(name).fit(standard.recording("full", 0), standard.REFERENCE).status
        assert (status.kind, "current_1_A" in status.reason) == ("not_applicable", True)
    if not CALIBRATORS[name].needs:
        assert isinstance(fit(name, standard, bare, no_vector), Calibration)


@ONE_OF_THE_SEARCHES
def test_every_claimed_deviation_has_its_parameter(name, standard):
    result = usual(name, standard)[1]
    assert set(result.covariance_names) <= set(result.parameters)
    if result.covariance is not None:
        assert result.covariance.shape == (len(result.covariance_names),) * 2
        assert np.linalg.eigvalsh(result.covariance).min() > -1e-9 * np.trace(result.covariance)


@ALL
def test_name_and_summary(name):
    assert get(name).name == name
    assert 0 < len(get(name).summary) < 120


def test_unknown_name_lists_the_others():
    with pytest.raises(InputError, match=", ".join(CALIBRATORS)):
        get("elipsoid")
