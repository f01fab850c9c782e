"""A sensor at rest: what counts as one, and that its drivers are found about a constant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import at_rest
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.arrays import Array
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import COSTLY, STRENGTH_NT, recording, without_attitude

GAIN = np.array([3e4, -1e4, 2e4])


def _bench(n: int = 3000, gain: np.ndarray = GAIN) -> Recording:  # type: ignore[type-arg]
    """A sensor on a bench beside a coil that is switched now and then."""
    rng = np.random.default_rng(0)
    on = np.repeat(rng.integers(0, 2, n // 50), 50).astype(float)
    mag = np.array([20_000.0, -5_000.0, 43_000.0]) + on[:, None] * gain + 30.0 * rng.normal(size=(n, 3))
    return Recording(time_s=np.arange(n) / 10, mag_nT=mag, current_A=on[:, None], motor_numbers=(1,))


def test_a_coil_as_strong_as_the_field_is_named_with_its_gain() -> None:
    found = diagnose(_bench(), ModelSpec(), strength_nT=48_000.0, fitted_base=True, without=COSTLY)
    assert found.problem.still
    assert [one.name for one in found.named] == ["motor_current"]
    assert np.array(found.named[0].effect.gain_nT_A) == pytest.approx(GAIN, abs=5.0)  # type: ignore[attr-defined]
    assert found.named[0].spread["gain_nT_A"] == pytest.approx(30.0 / np.sqrt(3000 / 4), rel=0.2)


def test_rest_is_told_from_motion() -> None:
    moving = without_attitude(recording())
    assert not at_rest(moving, STRENGTH_NT, STANDARD)
    assert not at_rest(recording(), STRENGTH_NT, STANDARD)
    assert at_rest(_bench(), STRENGTH_NT, STANDARD)
    quiet = replace(_bench(gain=np.zeros(3)), current_A=None, motor_numbers=())
    assert at_rest(quiet, STRENGTH_NT, STANDARD)
    turning = np.full((len(quiet), 3), 0.0) + np.sin(np.arange(len(quiet)))[:, None]
    assert not at_rest(replace(quiet, gyro_rad_s=turning), STRENGTH_NT, STANDARD)


def test_a_sensor_that_turns_is_not_at_rest_because_its_pitch_and_roll_were_logged() -> None:
    """A glider's log: angles as columns, which the field goes with."""
    given = recording()
    assert given.att_q is not None
    w, x, y, z = given.att_q.T
    angles = {"pitch": np.arcsin(2 * (w * y - x * z)), "roll": np.arctan2(2 * (w * x + y * z), 1 - 2 * (x**2 + y**2))}
    columns = {"up": np.cos(angles["pitch"]) * np.cos(angles["roll"]), "ahead": given.mag_nT[:, 0], **angles}
    turning = replace(without_attitude(given), channels=columns, current_A=None, temperature_degC=None)
    assert not at_rest(turning, STRENGTH_NT, STANDARD)


def test_two_coils_on_or_off_are_no_motion_though_iron_fits_their_four_fields() -> None:
    rng = np.random.default_rng(5)
    on = np.column_stack([np.repeat(rng.integers(0, 2, 60), 50) for _ in range(2)]).astype(float)
    moved = on @ np.array([[1e4, 0.0, 2e4], [5e3, 1.5e4, 0.0]])
    mag = np.array([2e4, 1e4, -4e4]) + moved + 100.0 * rng.normal(size=moved.shape)
    coils = Recording(time_s=np.arange(3000) / 10, mag_nT=mag, channels={"first": on[:, 0], "second": on[:, 1]})
    found = diagnose(coils, ModelSpec(), strength_nT=45_000.0, fitted_base=True, without=COSTLY)
    assert found.problem.still
    assert found.verdict != "none"
    assert "first" in found.sentence
    assert "second" in found.sentence


@pytest.mark.parametrize(("spread", "rests"), [(0.04, True), (0.06, False)])
def test_a_field_that_stays_within_a_small_angle_is_one_at_rest(spread: float, rests: bool) -> None:
    wave = np.sqrt(2) * np.sin(np.arange(3000) / 7.0)
    mag_nT = np.array([0.0, 0.0, 5e4]) + spread * 5e4 * wave[:, None] * [1.0, 0.0, 0.0]
    assert at_rest(Recording(time_s=np.arange(3000) / 10, mag_nT=mag_nT), 5e4, STANDARD) is rests


@pytest.mark.parametrize(("rate_rad_s", "turns"), [(0.015, False), (0.025, True)])
def test_a_gyro_tells_a_turn(rate_rad_s: float, turns: bool) -> None:
    gyro = rate_rad_s * np.sign(np.sin(np.arange(3000) / 50.0))[:, None] * np.ones(3)
    given = Recording(time_s=np.arange(3000) / 10, mag_nT=np.full((3000, 3), 3e4), gyro_rad_s=gyro)
    assert at_rest(given, 5e4, STANDARD) is not turns


def wave(period: float) -> Array:
    """A square wave (4096,) of one, that no other of these follows."""
    return np.sign(np.sin(np.arange(4096) * 2 * np.pi / period + 1e-3))


def told_by_channels(mag_nT: Array, drivers: list[Array], left: float) -> Recording:
    """Drivers of a field as channels that explain all of it but a part, in which each follows something else."""
    other = [np.sqrt(2) * np.sin(np.arange(4096) / (7.3 + k)) for k in range(len(drivers))]
    pairs = zip(drivers, other, strict=True)
    seen = [np.sqrt(1 - left) * x / x.std() + np.sqrt(left) * y for x, y in pairs]
    channels = {f"pump_{k}": x for k, x in enumerate(seen)}
    return Recording(time_s=np.arange(4096) / 10, mag_nT=mag_nT, channels=channels)


@pytest.mark.parametrize(
    ("left", "second", "moved"), [(0.4, 0.05, True), (0.6, 0.05, False), (0.3, 0.08, True), (0.3, 0.12, False)]
)
def test_channels_that_explain_half_move_a_field_on_a_line(left: float, second: float, moved: bool) -> None:
    """Half of it, where its second axis is a tenth of the first; iron fits any four fields."""
    mag_nT = 1e4 * np.column_stack([wave(64), second * wave(32), 0 * wave(32)])
    assert at_rest(told_by_channels(mag_nT, [wave(64)], left), 5e4, STANDARD) is moved


@pytest.mark.parametrize(
    ("left", "off", "moved"), [(0.3, 0.035, False), (0.45, 0.065, True), (0.02, 0.02, True), (0.05, 0.02, False)]
)
def test_a_field_that_keeps_its_strength_turns_unless_channels_leave_little(
    left: float, off: float, moved: bool
) -> None:
    """Iron makes the strength hold to 5 %, or leaves a fifth of what the channels do."""
    angle = np.arange(4096) / 31.7
    round_nT = 5e4 * (1 + off * wave(16))[:, None] * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    given = told_by_channels(round_nT, [np.cos(angle), np.sin(angle)], left)
    assert at_rest(given, 5e4, STANDARD) is moved


def test_a_current_that_hardly_changes_and_a_magnet_look_the_same_in_a_part_of_a_rest() -> None:
    """Beside a sensor at rest every iron is one constant, as is a steady current: all are listed."""
    rng, n = np.random.default_rng(1), 3000
    on = (np.arange(n) >= 900) & (np.arange(n) < 1500)
    mag = np.array([20_000.0, -5_000.0, 43_000.0]) + 2.0 * rng.normal(size=(n, 3)) + np.outer(on, [3.0, -4.0, 3.5])
    current_A = 6.0 + 0.05 * rng.normal(size=(n, 1))
    given = Recording(time_s=np.arange(n) / 10, mag_nT=mag, current_A=current_A, motor_numbers=(1,))
    found = diagnose(given, ModelSpec(), strength_nT=48_000.0, fitted_base=True)
    (cause,) = found.named
    assert found.verdict == "class"
    assert {"motor_current", "hard_iron", "sensor_offset"} <= {cause.name, *cause.alternatives}
    assert cause.effect.active_s == pytest.approx((90.0, 150.0), abs=0.5)
