"""Applying, saving and reading calibrations; the reference's checks."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from calib import Calibration, Reference, Status, from_json, to_json
from calib.numerics.rates import body_rate
from scenarios.errors import InputError

EDDY_S = np.array([[0.10, 0.02, 0.0], [0.01, 0.16, 0.03], [0.0, -0.02, 0.05]])
GOOD = {"status": "ok", "offset_nT": [1, 2, 3], "matrix": np.eye(3).tolist()}


def truth(standard, eddy_s):
    return Calibration(
        name="truth",
        status=Status("ok"),
        offset_nT=standard.HARD_NT,
        matrix=np.linalg.inv(standard.SOFT),
        eddy_s=eddy_s,
    )


def true_field_nT(standard, recording):
    return standard.attitude("full", recording.time_s).inv().apply(standard.FIELD_ENU_NT)


def test_static_apply_inverts_the_model(standard):
    recording = standard.recording("full", None)
    np.testing.assert_allclose(truth(standard, None).apply(recording), true_field_nT(standard, recording), atol=1e-8)


@pytest.mark.parametrize(("missing", "atol_nT"), [((), 1e-3), (("gyro_rad_s",), 0.1), (("gyro_rad_s", "att_q"), 5.0)])
def test_eddy_apply_with_gyro_attitude_or_neither(missing, atol_nT, standard):
    recording = standard.recording("full", None, eddy_s=EDDY_S)
    recording = replace(recording, **dict.fromkeys(missing))
    error_nT = (truth(standard, EDDY_S).apply(recording) - true_field_nT(standard, recording))[10:-10]
    assert np.abs(error_nT).max() < atol_nT
    static_nT = (truth(standard, None).apply(recording) - true_field_nT(standard, recording))[10:-10]
    assert np.abs(static_nT).max() > 100


def test_rate_from_attitude_does_not_care_for_the_quaternion_sign(standard):
    recording = standard.recording("full", None)
    sign = np.where(np.arange(len(recording)) % 3 == 0, -1.0, 1.0)[:, None]
    flipped = replace(recording, gyro_rad_s=None, att_q=recording.att_q * sign)
    np.testing.assert_allclose(body_rate(flipped)[1:-1], recording.gyro_rad_s[1:-1], atol=2e-4)


def test_json_has_the_shared_keys_and_keeps_every_bit():
    covariance = np.array([[2.0, 0.1], [0.1, 3.0]])
    one = Calibration(
        name="x",
        status=Status("unobservable", "why"),
        offset_nT=np.array([0.1, 1 / 3, 2]),
        matrix=np.eye(3) / 3,
        eddy_s=EDDY_S,
        parameters={"a": 1 / 7, "b": 2.0},
        covariance=covariance,
        covariance_names=("a", "b"),
        history=(3.0, 0.5),
        wall_s=0.25,
    )
    keys = set(json.loads(to_json(one)))
    assert {"status", "reason", "offset_nT", "matrix", "eddy_s", "parameters", "covariance", "wall_s"} <= keys
    other = from_json(to_json(one))
    assert (other.status, other.parameters, other.covariance_names) == (one.status, one.parameters, ("a", "b"))
    for key in ("offset_nT", "matrix", "eddy_s", "covariance"):
        np.testing.assert_array_equal(getattr(other, key), getattr(one, key))


def test_external_result_needs_little():
    result = from_json(json.dumps({"offset_nT": [1, 2, 3], "matrix": np.eye(3).tolist()}), name="mine")
    assert (result.name, result.status.kind, result.offset_nT.tolist()) == ("mine", "ok", [1, 2, 3])
    sure = from_json(json.dumps(GOOD | {"covariance": np.eye(3).tolist()}))
    np.testing.assert_array_equal(sure.offset_covariance_nT2, np.eye(3))
    failed = from_json('{"status": "not_converged", "reason": "gave up", "offset_nT": null}')
    assert (failed.status.reason, failed.offset_nT.tolist()) == ("gave up", [0, 0, 0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"offset_nT": [1, 2]}, r"offset_nT: expected 3 numbers"),
        ({"offset_nT": [1, 2, "3"]}, r"offset_nT: expected a finite number, found '3'"),
        ({"offset_nT": [1, 2, True]}, r"found True"),
        ({"offset_nT": None}, r"offset_nT: missing"),
        ({"matrix": [[1, 0], [0, 1]]}, r"matrix: expected 3 x 3"),
        ({"matrix": [[1, 0, 0], [0, 1], [0]]}, r"matrix: expected 3 x 3"),
        ({"status": "fine"}, r"'fine' is none of ok, not_converged"),
        ({"reason": 3}, r"reason: expected text"),
        ({"offset": [1, 2, 3]}, r"unknown keys offset .*known are"),
        ({"parameters": {"a": "b"}}, r"parameters.a"),
        ({"covariance": [[1, 2], [0, 1]], "covariance_names": ["a", "b"]}, r"symmetric"),
        ({"covariance": [[1]], "covariance_names": ["a", "b"]}, r"2 x 2"),
        ({"covariance": np.eye(9).tolist()}, r"covariance_names: missing"),
        ({"array_offset_nT": 3.0}, r"array_offset_nT: expected a list"),
        ({"history": 3}, r"history: expected a list"),
        ({"offset_nT": [1, 2, 10**400]}, r"offset_nT: expected a finite number, found inf"),
        ({"wall_s": 10**4000}, r"wall_s: expected a finite number"),
        ({"wall_s": 1e999}, r"Infinity is not a number"),
    ],
)
def test_bad_result_is_told_in_one_line(change, message):
    with pytest.raises(InputError, match=message) as caught:
        from_json(json.dumps(GOOD | change), where="out.json")
    assert str(caught.value).startswith("out.json")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "[1]", "{", "3", "9" * 5000])
def test_not_an_object(text):
    with pytest.raises(InputError, match="JSON"):
        from_json(text)


def test_nesting_without_end():
    with pytest.raises(InputError, match="nested too deep"):
        from_json('{"history": ' + "[" * 100_000)


@pytest.mark.parametrize(
    ("strength", "vector"),
    [
        (0.0, None),
        (-1.0, None),
        (np.nan, None),
        (5.0, (3.0, 4.0, 1.0)),
        (5.0, (3.0, np.inf, 0.0)),
        (5.0, (3.0, 4.0)),
    ],
)
def test_reference_is_checked(strength, vector):
    with pytest.raises(InputError, match="reference"):
        Reference(strength, vector)


def test_reference_of_vector():
    assert Reference.of_vector((3.0, 4.0, 12.0)).strength_nT == 13.0
