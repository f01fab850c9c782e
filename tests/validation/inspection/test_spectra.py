"""Noise, slow changes and tones of known size in what a base model leaves."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.arrays import Array
from tests.validation.inspection.recordings import FIELD_ENU_NT, moved, noise, one, sensor_data
from validation.inspection.finding import Finding
from validation.inspection.spectra import motion_edge_hz, noise_findings

SAMPLES, RATE_HZ, STD_NT = 9000, 40.0, 5.0
MOTION = moved(SAMPLES, rate_hz=RATE_HZ)
FIELD_NT = MOTION.body(FIELD_ENU_NT)


def findings(added_nT: Array | float = 0.0, *, attitude: bool = True) -> list[Finding]:
    columns = {"q": MOTION.q} if attitude else {}
    return noise_findings(sensor_data(MOTION.time_s, FIELD_NT + noise(SAMPLES, STD_NT) + added_nT, **columns))


def sine(frequency_hz: float, amplitude_nT: float) -> Array:
    """On the x axis alone."""
    return amplitude_nT * np.sin(2 * np.pi * frequency_hz * MOTION.time_s)[:, None] * [1.0, 0.0, 0.0]


def test_white_noise_alone() -> None:
    """Density sigma sqrt(2 / rate), nT a root hertz."""
    found = findings()
    white = one(found, "white")
    assert white.value == pytest.approx([STD_NT] * 3, rel=0.05)
    assert f"{STD_NT * np.sqrt(2 / RATE_HZ):.2g} nT/√Hz" in white.text.replace(" and ", ", ")
    left = one(found, "residual")
    assert left.value["base"] == "attitude"
    assert left.value["rms_nT"] == pytest.approx([STD_NT] * 3, rel=0.05)
    assert one(found, "slow").level == "ok"
    assert one(found, "tones").value == []


def test_without_attitude_the_strength_is_left() -> None:
    left = one(findings(attitude=False), "residual")
    assert left.value["base"] == "strength"
    assert left.value["rms_nT"] == pytest.approx([STD_NT], rel=0.05)


def test_a_tone_at_its_frequency_and_amplitude() -> None:
    (tone,) = one(findings(sine(7.3, 3.0)), "tones").value
    assert tone["frequency_hz"] == pytest.approx(7.3, abs=0.5 * RATE_HZ / SAMPLES)
    assert tone["amplitude_nT"] == pytest.approx([3.0, 0.0, 0.0], abs=0.3)
    assert tone["mains"] == []
    assert tone["motion"] is False


@pytest.mark.parametrize(("mains_hz", "name"), [(50.02, "50 Hz"), (60.02, "60 Hz"), (150.05, "3 x 50 Hz")])
def test_the_mains_are_named_by_their_alias(mains_hz: float, name: str) -> None:
    """At 40 Hz the 50 Hz appear at 10, the 60 Hz at 20, and 150 at 10."""
    found = one(findings(sine(mains_hz, 4.0)), "tones")
    assert any(name in tone["mains"] for tone in found.value)
    assert "would appear" in found.text


def test_tones_within_the_motion_are_said_to_be() -> None:
    """Up to the highest frequency at which the field itself is far above the noise."""
    edge_hz = motion_edge_hz(sensor_data(MOTION.time_s, FIELD_NT + noise(SAMPLES, STD_NT)))
    assert 1.0 < edge_hz < 10.0
    slow = one(findings(sine(0.5, 20.0)), "tones")
    assert all(tone["motion"] for tone in slow.value)
    assert "may belong to the motion" in slow.text
    both = one(findings(sine(0.5, 20.0) + sine(13.0, 4.0)), "tones")
    assert f"more below {edge_hz:.2g} Hz may belong to the motion" in both.text


def test_a_slow_change_is_told_from_noise() -> None:
    """A sine of 10 nT in 100 s: blocks of 5 s vary by sqrt(1 + 50 n / 25) as much, n samples a block."""
    found = one(findings(sine(0.01, 10.0)), "slow")
    five = next(blocks for blocks in found.value if blocks["length_s"] == 5.0)
    assert five["excess"][0] == pytest.approx(np.sqrt(1 + 50 * 5 * RATE_HZ / 25), rel=0.1)
    assert five["excess"][1] == pytest.approx(1, abs=0.5)
    assert "slow changes remain" in found.text


@pytest.mark.parametrize(("times", "told"), [(1.0, True), (2.7, True), (3.3, False)])
def test_what_varies_more_than_noise_alone_may_be_motion(times: float, told: bool) -> None:
    """Without attitude and ellipsoid: a field that varies so many times as much as its noise."""
    time_s = np.arange(3000) / 50.0
    slow_nT = STD_NT * np.sqrt(2 * (times**2 - 1)) * np.sin(2 * np.pi * 0.1 * time_s)
    found = noise_findings(sensor_data(time_s, noise(3000, STD_NT) + slow_nT[:, None] + 2e4))
    assert any(finding.name == "slow" for finding in found) == told


def test_where_the_mains_would_appear() -> None:
    assert one(findings(), "mains").value["50 Hz"] == pytest.approx(10.0, abs=0.01)
    time_s = np.arange(3000) / 50.0
    hidden = noise_findings(sensor_data(time_s, noise(3000, STD_NT) + 2e4))
    assert "50 Hz look like a slow change of the offset" in one(hidden, "mains").text


def test_noise_that_is_not_white_is_an_upper_bound() -> None:
    """Eight means of two neighbours in turn: a bell, of which every further difference takes more away."""
    time_s, smooth = np.arange(6000) / 50.0, noise(6008, 40.0)
    for _ in range(8):
        smooth = (smooth[1:] + smooth[:-1]) / 2
    found = one(noise_findings(sensor_data(time_s, smooth + 2e4)), "white")
    assert "at most" in found.text
    assert found.level == "note"


def test_noise_below_the_step_or_hidden_by_motion() -> None:
    time_s = np.arange(3000) / 50.0
    coarse = 100 * np.round((noise(3000, 1.0) + 20_000 + 8 * time_s[:, None]) / 100)
    assert "below the least significant bit" in one(noise_findings(sensor_data(time_s, coarse)), "white").text
    tumbling = 5e4 * noise(3000, 1.0)
    assert "moved too far" in one(noise_findings(sensor_data(time_s, tumbling)), "white").text


def test_too_few_rows_for_noise() -> None:
    assert noise_findings(sensor_data(np.arange(5.0), noise(5, 1.0) + 2e4)) == []


def test_noise_of_a_fast_turn_does_not_hold_the_motion() -> None:
    """At 4 Hz, every tenth row, neighbouring samples differ by a hundred times the noise."""
    few = MOTION.time_s[::10] / 4.0, (FIELD_NT + noise(SAMPLES, STD_NT))[::10]
    found = one(noise_findings(sensor_data(*few)), "white")
    assert found.value == pytest.approx([STD_NT] * len(found.value), rel=0.15)
