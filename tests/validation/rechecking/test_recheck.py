"""Old calibrations against new logs: verdict, size of the change, error rates, and motions that do not tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, Status, get
from calib.input_terms import InputTerm
from recordings import Recording
from recordings.applied import AppliedCalibration
from recordings.recording import Origin
from scenarios.errors import InputError
from validation.rechecking.heading import dip_of
from validation.rechecking.recheck import recheck
from validation.rechecking.summary import headline, rows, summary

FIELD_ENU_NT = (0.0, 20_000.0, -45_000.0)
STRENGTH = Reference(float(np.hypot(20_000.0, 45_000.0)))
VECTOR = Reference.of_vector(FIELD_ENU_NT)
SOFT = np.array([[1.05, 0.02, 0.0], [0.02, 0.97, -0.01], [0.0, -0.01, 1.01]])
OFFSET_NT = np.array([500.0, -300.0, 200.0])
EXACT = Calibration(name="old", status=Status("ok"), offset_nT=OFFSET_NT, matrix=np.linalg.inv(SOFT))


def log(
    seed: int,
    offset_nT: object = OFFSET_NT,
    soft: object = SOFT,
    *,
    n: int = 600,
    noise_nT: float = 50.0,
    tilt_deg: float = 70.0,
    motor_nT_A: object = None,
    colour: float = 0.0,
) -> Recording:
    """A swinging turn: the measured field, its attitude, gravity, and a motor's current where one acts.

    colour : share of the noise's variance that wanders, with a time constant of 30 samples
    """
    rng = np.random.default_rng(seed)
    t = 0.1 * np.arange(n)
    a, b = np.radians(tilt_deg) * np.sin(2 * np.pi * t / rng.uniform(11, 17) + rng.uniform(0, 6, 2)[:, None])
    turn = Rotation.from_euler("ZYX", np.column_stack([2 * np.pi * t / 20, a, 2 * b]))
    current_A = rng.uniform(0, 1) + 10.0 * np.abs(np.sin(2 * np.pi * t / 7.3))
    drive, decay = np.sqrt(1 - np.exp(-2 / 30)) * rng.standard_normal((n - 1, 3)), np.exp(-1 / 30)
    slow = np.concatenate([np.zeros((1, 3)), lfilter([1.0], [1.0, -decay], drive, axis=0)])
    noise = np.sqrt(1 - colour) * rng.standard_normal((n, 3)) + np.sqrt(colour) * slow
    mag = turn.inv().apply(FIELD_ENU_NT) @ np.asarray(soft).T + np.asarray(offset_nT) + noise_nT * noise
    if motor_nT_A is not None:
        mag += np.outer(current_A, np.asarray(motor_nT_A))
    up = turn.inv().apply([0.0, 0.0, 9.81])
    att_q = turn.as_quat(scalar_first=True)
    currents = None if motor_nT_A is None else current_A[:, None]
    return Recording(t, mag, accel_m_s2=up, att_q=att_q, current_A=currents)


def part(found: object, what: str) -> object:
    (one,) = [one for one in found.parts if one.what == what]  # type: ignore[attr-defined]
    return one


def test_an_unchanged_instrument_is_valid_and_says_what_would_have_shown() -> None:
    found = recheck(EXACT, log(0), STRENGTH)
    assert found.verdict == "valid"
    assert found.excluded_deg < 0.2
    assert 0 < found.found_nT < 100
    assert "would have shown" in headline(found)


def test_933_nT_of_stale_iron_are_changed_by_that_much() -> None:
    """A 933 nT to the right, A the old matrix, turn a heading by up to 962 / 20,000 rad, with tilts of 3 deg by 2.8."""
    moved = np.array([0.0, -933.0, 0.0])
    found = recheck(EXACT, log(1, OFFSET_NT + moved), STRENGTH)
    offset = part(found, "offset")
    assert found.verdict == "changed"
    assert "offset" in {one.what for one in found.changes}
    assert np.abs(offset.value - moved).max() < 4 * offset.std.max() < 60  # type: ignore[attr-defined]
    value, low, high = found.heading_deg
    assert low < value < high
    assert value == pytest.approx(np.degrees(962 / 20_000), abs=0.1)
    assert "not within the tolerance" in headline(found)


def test_soft_iron_is_told_from_an_offset_and_from_a_scale() -> None:
    grown = SOFT @ np.diag([1.02, 1.0, 1.0])
    found = recheck(EXACT, log(2, soft=grown), STRENGTH)
    assert found.verdict == "changed"
    assert {one.what for one in found.changes} >= {"soft iron"}
    assert not part(found, "offset").significant  # type: ignore[attr-defined]
    scaled = recheck(EXACT, log(3, soft=1.03 * SOFT), STRENGTH)
    assert scaled.verdict == "valid"  # a common scale turns no heading
    assert part(scaled, "scale").value[0] == pytest.approx(3.0, abs=0.1)  # type: ignore[attr-defined]


def test_a_motor_s_field_is_told_by_its_current() -> None:
    k = np.array([30.0, -20.0, 10.0])
    found = recheck(EXACT, log(4, motor_nT_A=k), STRENGTH)
    motors = part(found, "motor currents")
    assert found.verdict == "changed"
    assert motors.unit == "nT/A"  # type: ignore[attr-defined]
    assert np.abs(motors.value - k).max() < 4 * motors.std.max() < 20  # type: ignore[attr-defined]
    quiet = recheck(EXACT, log(4, motor_nT_A=0 * k), STRENGTH)
    assert quiet.verdict == "valid"


def test_an_old_motor_term_is_taken_off_or_told_as_unchecked() -> None:
    """The old term of (30, -20, 10) nT/A holds, has grown by a half, or meets a log without currents."""
    k = np.array([30.0, -20.0, 10.0])
    old = replace(EXACT, inputs=(InputTerm("current_sum_A", k),))
    assert recheck(old, log(4, motor_nT_A=k), STRENGTH).verdict == "valid"
    grown = recheck(old, log(4, motor_nT_A=1.5 * k), STRENGTH)
    motors = part(grown, "motor currents")
    assert grown.verdict == "changed"
    assert np.abs(motors.value - EXACT.matrix @ k / 2).max() < 4 * motors.std.max() < 20  # type: ignore[attr-defined]
    blind = recheck(old, log(0), STRENGTH)
    assert any("current_sum_A" in note and "could not be checked" in note for note in blind.notes)


def test_a_level_turn_cannot_tell_and_says_what_motion_would() -> None:
    found = recheck(EXACT, log(5, tilt_deg=1.0), STRENGTH)
    assert found.verdict == "cannot tell"
    assert "roll and pitch further" in headline(found)


def test_a_level_turn_tells_that_something_has_changed() -> None:
    found = recheck(EXACT, log(6, OFFSET_NT + np.array([1000.0, 0.0, 0.0]), tilt_deg=1.0), STRENGTH)
    assert found.verdict == "changed"
    assert [one.what for one in found.changes if one.what != "scale"] == ["offset or soft iron"]


def test_too_few_samples_cannot_tell() -> None:
    assert recheck(EXACT, log(0).taken(slice(0, 20)), STRENGTH).verdict == "cannot tell"


def test_the_old_calibration_s_own_uncertainty_counts() -> None:
    claimed = replace(
        EXACT, covariance=np.eye(3) * 600.0**2, covariance_names=("offset_x_nT", "offset_y_nT", "offset_z_nT")
    )
    assert recheck(claimed, log(0), STRENGTH).verdict == "cannot tell"


def test_with_attitude_a_turned_sensor_is_changed_unless_an_autopilot_made_the_attitude() -> None:
    """The strength cannot see a turn; an autopilot's heading would hide it.

    3 deg about the body's z turn the heading by 3 deg, and the more by what a tilt of 3 deg adds of the vertical field.
    """
    old = get("vector_least_squares").fit(log(7), VECTOR)
    turned = SOFT @ Rotation.from_euler("Z", 3.0, degrees=True).as_matrix()
    found = recheck(old, log(8, soft=turned), VECTOR)
    assert (found.knowledge, found.verdict) == ("vector", "changed")
    assert found.heading_deg[0] == pytest.approx(3.0 * (1 + np.tan(np.radians(3.0)) * 45 / 20), abs=0.1)
    native = replace(log(8, soft=turned), origin=Origin(applied=AppliedCalibration("px4", 0)))
    assert recheck(old, native, VECTOR).knowledge == "strength"


def test_without_a_known_field_a_scale_is_unseen_and_the_rest_is_judged() -> None:
    assert recheck(EXACT, log(0), None).verdict == "valid"
    assert recheck(EXACT, log(1, OFFSET_NT + np.array([0.0, -933.0, 0.0])), None).verdict == "changed"


def test_valid_is_rarely_said_of_a_change_of_the_tolerance() -> None:
    """Of 40 changed instruments at most 3: with a chance of 1 % each more are found once in 1000 runs."""
    rng, wrong = np.random.default_rng(0), 0
    for seed in range(40):
        psi = rng.uniform(0, 2 * np.pi)
        moved = np.tan(np.radians(1.0)) * 20_000.0 * np.array([np.cos(psi), np.sin(psi), 0.0])
        new = log(100 + seed, OFFSET_NT + moved, n=300, noise_nT=rng.uniform(20, 300), colour=rng.uniform(0, 0.5))
        wrong += recheck(EXACT, new, STRENGTH).verdict == "valid"
    assert wrong <= 3


def test_a_change_is_rarely_seen_where_there_is_none() -> None:
    wrong = [recheck(EXACT, log(200 + s, n=300, noise_nT=100.0), STRENGTH).verdict == "changed" for s in range(40)]
    assert sum(wrong) <= 3


def test_an_offset_of_the_stated_size_is_found() -> None:
    """Of 40 changes of the size that 95 of 100 logs would show at least 33 are: fewer once in 300 runs."""
    size_nT = max(recheck(EXACT, log(300 + s, n=300, noise_nT=200.0), STRENGTH).found_nT for s in range(3))
    shown = 0
    for seed in range(40):
        axis = np.eye(3)[seed % 3] * (-1) ** seed
        found = recheck(EXACT, log(400 + seed, OFFSET_NT + size_nT * axis, n=300, noise_nT=200.0), STRENGTH)
        shown += part(found, "offset").significant  # type: ignore[attr-defined]
    assert shown >= 33


def test_the_dip_is_the_field_s_or_the_accelerometer_s() -> None:
    seen = replace(log(0), mag_nT=EXACT.apply(log(0)))
    for reference in (VECTOR, STRENGTH):
        assert np.degrees(dip_of(seen, reference)[0]) == pytest.approx(np.degrees(np.arctan2(45, 20)), abs=0.5)
    assert dip_of(replace(seen, accel_m_s2=None), STRENGTH)[1] == "assumed: 60 deg"


def test_words_rows_and_json_agree() -> None:
    found = recheck(EXACT, log(1, OFFSET_NT + np.array([0.0, -933.0, 0.0])), STRENGTH)
    told = summary(found)
    assert told["verdict"] == "changed"
    assert told["changes"][0]["what"] == "offset"
    assert told["changes"][0]["low"][1] < -933 < told["changes"][0]["high"][1]
    assert [row[0] for row in rows(found)] == [one.what for one in found.parts]


def test_a_tolerance_is_positive() -> None:
    with pytest.raises(InputError, match="tolerance"):
        recheck(EXACT, log(0), STRENGTH, 0.0)
