"""Segments: cuts found and given, what they win, and applying and saving them."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from calib import Calibration, Status, from_json, to_json
from calib.methods.ellipsoid import EllipsoidCalibrator
from calib.methods.ellipsoid_segmented import EllipsoidSegmented
from calib.models.change_points import LinearisedRows, find_cuts
from calib.models.ellipsoid import norm_coordinates
from calib.models.norm import norm_derivatives
from calib.result import Segment
from scenarios.errors import InputError

DIRECTION = np.array([1.0, -0.5, 0.7])


def moving(standard, motion, shift_nT, seed=0):
    """A recording whose hard iron moves by shift_nT(time_s) along DIRECTION."""
    recording = standard.recording(motion, seed)
    return replace(recording, mag_nT=recording.mag_nT + shift_nT(recording.time_s)[:, None] * DIRECTION)


def jump(time_s):
    return np.where(time_s < 200.25, 0.0, 300.0)


def ramp(time_s):
    return 300.0 * time_s / 360.0


def component_rms_nT(result, recording, standard, motion):
    true_nT = standard.attitude(motion, recording.time_s).inv().apply(standard.FIELD_ENU_NT)
    return np.sqrt(np.mean(np.sum((result.apply(recording) - true_nT) ** 2, axis=1)))


@pytest.mark.parametrize("motion", ["full", "pitch"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_jump_is_cut_where_it_is(motion, seed, standard):
    recording = moving(standard, motion, jump, seed)
    result = EllipsoidSegmented().fit(recording, standard.REFERENCE)
    assert result.status.kind == "ok"
    assert len(result.segments) == 2
    assert result.segments[1].start_s == pytest.approx(200.3, abs=0.5)
    whole = EllipsoidCalibrator().fit(recording, standard.REFERENCE)
    error_nT = component_rms_nT(result, recording, standard, motion)
    assert error_nT < 20 < 180 < component_rms_nT(whole, recording, standard, motion)
    step_nT = result.segments[1].offset_nT - result.segments[0].offset_nT
    np.testing.assert_allclose(step_nT, 300 * DIRECTION, atol=6 if motion == "full" else 60)


def test_a_drift_is_followed_and_its_mean_offset_told(standard):
    recording = moving(standard, "full", ramp)
    result = EllipsoidSegmented().fit(recording, standard.REFERENCE)
    assert result.status.kind == "ok"
    assert 3 <= len(result.segments) <= 10
    whole = EllipsoidCalibrator().fit(recording, standard.REFERENCE)
    assert component_rms_nT(whole, recording, standard, "full") > 4 * component_rms_nT(
        result, recording, standard, "full"
    )
    np.testing.assert_allclose(result.offset_nT, standard.HARD_NT + 150 * DIRECTION, atol=10)
    assert len(result.segments) == result.parameters["segments"]


@pytest.mark.parametrize("motion", ["full", "pitch"])
def test_no_cut_without_drift(motion, standard):
    """On 20 seeds, one segment and hence the whole-record fit itself."""
    clean = standard.recording(motion, None)
    for seed in range(20):
        recording = standard.noisy(clean, seed)
        result = EllipsoidSegmented().fit(recording, standard.REFERENCE)
        assert len(result.segments) == 1
        whole = EllipsoidCalibrator().fit(recording, standard.REFERENCE)
        np.testing.assert_allclose(result.offset_nT, whole.offset_nT, rtol=1e-12)
        np.testing.assert_allclose(result.covariance, whole.covariance, rtol=1e-12)


def test_given_cuts_are_taken(standard):
    recording = moving(standard, "full", jump)
    result = EllipsoidSegmented(cuts_s=(100.0, 200.3)).fit(recording, standard.REFERENCE)
    assert [s.start_s for s in result.segments] == [0.0, 100.0, 200.3]
    np.testing.assert_allclose(result.segments[0].offset_nT, standard.HARD_NT, atol=8)
    np.testing.assert_allclose(result.segments[2].offset_nT, standard.HARD_NT + 300 * DIRECTION, atol=8)
    one = EllipsoidSegmented(cuts_s=()).fit(recording, standard.REFERENCE)
    assert len(one.segments) == 1


@pytest.mark.parametrize(
    ("cuts_s", "words"),
    [
        ((100.0, 101.0), "segment 2 of 3 (100 to 100.9 s, 10 samples)"),
        ((350.0,), "segment 2 of 2 (350 to 359.9 s, 100 samples)"),
    ],
)
def test_a_segment_that_is_too_thin_fails_with_its_name(cuts_s, words, standard):
    status = EllipsoidSegmented(cuts_s=cuts_s).fit(standard.recording("pitch", 0), standard.REFERENCE).status
    assert status.kind == "unobservable"
    assert words in status.reason
    assert "fewer cuts" in status.reason


def test_cuts_outside_the_record(standard):
    status = EllipsoidSegmented(cuts_s=(1e4,)).fit(standard.recording("full", 0), standard.REFERENCE).status
    assert status.kind == "not_applicable"
    assert "between 0 and 359.9 s" in status.reason


def test_rows_are_the_derivative_of_the_residual(standard):
    recording = standard.recording("full", None, n=400)
    strength_nT = standard.REFERENCE.strength_nT
    whole = Calibration(
        name="x",
        status=Status("ok"),
        offset_nT=standard.HARD_NT + 50.0,
        matrix=np.linalg.inv(standard.SOFT) * 1.01,
    )
    rows = LinearisedRows.of(recording.mag_nT, whole, strength_nT)
    middle_nT = recording.mag_nT.mean(axis=0)
    x = (recording.mag_nT - middle_nT) / strength_nT
    p = norm_coordinates(whole.matrix, whole.matrix @ (whole.offset_nT - middle_nT) / strength_nT)
    gain = np.linalg.norm((recording.mag_nT - whole.offset_nT) @ whole.matrix @ whole.matrix, axis=1) / np.linalg.norm(
        (recording.mag_nT - whole.offset_nT) @ whole.matrix, axis=1
    )
    np.testing.assert_allclose(-2 * (rows.r * gain) @ (rows.q * gain[:, None]), norm_derivatives(p, x)[1], rtol=1e-9)


def test_penalty_forbids_cuts(standard):
    recording = moving(standard, "full", ramp)
    whole = EllipsoidCalibrator().fit(recording, standard.REFERENCE)
    rows = LinearisedRows.of(recording.mag_nT, whole, standard.REFERENCE.strength_nT)
    counts = [len(find_cuts(rows, 40, penalty, 1e-3)) for penalty in (1.0, 30.0, 1e6)]
    assert counts[0] >= counts[1] > counts[2] == 0
    assert rows.noise_std() * standard.REFERENCE.strength_nT == pytest.approx(standard.NOISE_STD_NT, rel=0.1)


def segmented():
    parts = (
        Segment(0.0, np.array([1.0, 0.0, 0.0]), np.eye(3)),
        Segment(10.0, np.array([0.1, 2.0, 1 / 3]), 2 * np.eye(3)),
    )
    return Calibration(
        name="x",
        status=Status("ok"),
        offset_nT=np.array([0.5, 1.0, 0.0]),
        matrix=1.5 * np.eye(3),
        segments=parts,
    )


def test_apply_switches_by_time_and_static_does_not(standard):
    recording = standard.recording("full", 0, n=200)
    one = segmented()
    out = one.apply(replace(recording, time_s=recording.time_s - 5.0))
    first = recording.time_s - 5.0 < 10.0
    np.testing.assert_array_equal(out[first], recording.mag_nT[first] - [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(out[~first], 2 * (recording.mag_nT[~first] - [0.1, 2.0, 1 / 3]))
    np.testing.assert_array_equal(one.static().apply(recording), 1.5 * (recording.mag_nT - [0.5, 1.0, 0.0]))


def test_segments_survive_json():
    one = segmented()
    other = from_json(to_json(one))
    assert to_json(other) == to_json(one)
    assert [s.start_s for s in other.segments] == [0.0, 10.0]
    np.testing.assert_array_equal(other.segments[1].offset_nT, one.segments[1].offset_nT)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"segments": 3}, "expected a list of objects with start_s"),
        ({"segments": [{"start_s": 0.0}]}, r"segments\[0\]: .*missing or unknown"),
        (
            {"segments": [{"start_s": 0.0, "offset_nT": [1, 2], "matrix": [[1]]}]},
            r"segments\[0\]: offset_nT: expected 3",
        ),
    ],
)
def test_bad_segments_are_told_in_one_line(change, message):
    with pytest.raises(InputError, match=message):
        from_json(json.dumps(json.loads(to_json(segmented())) | change))


def test_segments_out_of_order_are_refused():
    data = json.loads(to_json(segmented()))
    data["segments"].reverse()
    with pytest.raises(InputError, match="must increase"):
        from_json(json.dumps(data))
