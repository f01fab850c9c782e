"""A screened recording: faulty rows left out, faults in the reason, and no ok where a fault stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib import Calibration, Status
from recordings import Recording
from scenarios.arrays import Array
from tests.validation.screening.tumbling import tumble
from validation.screening.fault import Fault, rows_text
from validation.screening.screening import ScreenedRecording, screen


def changed(recording: Recording, mag_nT: Array) -> Recording:
    return replace(recording, mag_nT=mag_nT)


def test_a_sound_recording_is_given_back_as_it_is() -> None:
    recording = tumble(1)
    found = screen(recording)
    assert found.faults == ()
    assert found.recording.mag_nT is recording.mag_nT


@pytest.mark.parametrize("seed", range(3))
def test_samples_at_full_scale_are_left_out(seed: int) -> None:
    recording = tumble(seed)
    cut = np.abs(recording.mag_nT).max(axis=1) > 50_000
    assert cut.any()
    found = screen(changed(recording, np.clip(recording.mag_nT, -50_000, 50_000)))
    (fault,) = found.faults
    assert fault.kind == "full_scale"
    assert fault.rows[cut].all()
    assert np.count_nonzero(fault.rows & ~cut) < 0.5 * np.count_nonzero(cut)
    np.testing.assert_array_equal(found.recording.mag_nT, recording.mag_nT[~fault.rows])
    near = recording.mag_nT[fault.rows]
    assert np.abs(near).max(axis=1).min() > 45_000


def test_the_rows_left_below_a_full_scale_have_noise_of_no_sign() -> None:
    """A level of 48,000 nT on x, of a sensor that is slow and noisy: 400 nT at 2 nT a row."""
    rng, means = np.random.default_rng(5), []
    for _ in range(16):
        true = 45_000 + 5_000 * np.sin(np.linspace(0, 60, 20_000))
        noise = rng.normal(0, 400, 20_000)
        others = rng.normal(0, 400, (20_000, 2))
        cut = np.minimum(true + noise, 48_000.0)
        kept = screen(Recording(np.arange(20_000) / 50, np.column_stack([cut, others]))).keep
        near = kept & (true > 46_500) & (true < 48_500)
        means.append(noise[near].mean() * np.sqrt(near.sum()) / 400 if near.sum() > 20 else 0.0)
    assert abs(np.mean(means)) * np.sqrt(16) < 3.5


def test_the_reason_names_the_fault_and_a_doubtful_fault_takes_the_ok_back() -> None:
    rows = np.zeros(600, np.bool_)
    rows[150:] = True
    left_out = Fault("stuck", "axis z is stuck at 25,013 nT", rows)
    stays = replace(left_out, remedy="none", doubtful=True, kind="alike", text="axes x and y measure the same")
    fit = Calibration(name="ellipsoid", status=Status("ok"))
    judged = ScreenedRecording(tumble(1), (left_out,), ~rows).judged(fit)
    assert judged.status == Status("ok", "rows 151 to 600 were left out: axis z is stuck at 25,013 nT")
    judged = ScreenedRecording(tumble(1), (left_out, stays), ~rows).judged(fit)
    assert judged.status.kind == "unobservable"
    assert judged.status.reason.endswith("; axes x and y measure the same")


def test_a_fault_of_one_sensor_of_an_array_is_told_of_that_sensor_only() -> None:
    first, second = tumble(1), tumble(2)
    array = np.stack([first.mag_nT, np.clip(second.mag_nT, -50_000, 50_000)])
    found = screen(replace(first, array_mag_nT=array))
    (fault,) = found.faults
    assert fault.sensor == 1
    assert found.recording.array_mag_nT is not None
    assert found.recording.array_mag_nT.shape == (2, len(found.recording), 3)
    fit = Calibration(name="sphere", status=Status("ok"))
    assert found.judged(fit, 0).status.reason == ""
    assert "sensor 2: saturated" in found.judged(fit, 1).status.reason


def test_rows_in_words() -> None:
    rows = np.zeros(20, np.bool_)
    rows[3] = True
    assert rows_text(rows) == "row 4"
    rows[7:10] = True
    assert rows_text(rows) == "rows 4 and 8 to 10"
    rows[::2] = True
    assert rows_text(rows) == "13 rows"
