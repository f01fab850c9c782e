"""The day's change, written by the test as an observatory's IAGA-2002 file, is taken off a simulated log."""

from __future__ import annotations

import datetime
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import magbench
from calib import Reference
from magbench.cli import main
from recordings import Origin, Recording, read_recording, write_recording
from recordings.assemble import recording_of
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.scenario import load
from sim.simulation import blocks, plan
from validation.calibrating.base_station import BaseStation, without_change

NOON = datetime.datetime(2024, 5, 1, 12, 0, tzinfo=datetime.UTC)
ENU_NT = np.array([-1940.0, 31916.0, -41285.0])
AMPLITUDE_ENU_NT, PERIOD_S, PHASE_DEG = np.array([60.0, 150.0, -200.0]), 1500.0, 40.0
NOISE_NT = 5.0
CHANGES = (
    "phases.1.duration_s=400",
    "phases.1.tilt_amplitude_deg=30",
    "sampling.rate_hz=5",
    "effects.eddy_current.matrix_s=[[0,0,0],[0,0,0],[0,0,0]]",
    "effects.current_ripple.amplitude_nT_A=[0,0,0]",
    "effects.motor_current.gain_nT_A=[0,0,0]",
    f"effects.diurnal_drift.amplitude_enu_nT={AMPLITUDE_ENU_NT.tolist()}",
    f"effects.diurnal_drift.period_s={PERIOD_S}",
    f"effects.diurnal_drift.phase_deg={PHASE_DEG}",
)


def course_enu_nT(time_s: Array) -> Array:
    """The change (n, 3), from the effect's equation."""
    phase = np.radians(PHASE_DEG)
    return np.outer(np.sin(2 * np.pi * time_s / PERIOD_S + phase) - np.sin(phase), AMPLITUDE_ENU_NT)


def iaga(path: Path, time_s: Array, step: str = "1-minute", missing: slice = slice(0)) -> Path:
    """A file of X, Y, Z and F at seconds since NOON, with 99999.00 in missing records."""
    heads = {"Format": "IAGA-2002", "Source of Data": "Test", "IAGA CODE": "TST", "Reported": "XYZF"}
    lines = [f" {key:<23}{value:<45}|" for key, value in (heads | {"Data Interval Type": step}).items()]
    lines.append(f"{'DATE       TIME         DOY     TSTX      TSTY      TSTZ      TSTF':<69}|")
    east, north, up = (ENU_NT + course_enu_nT(time_s)).T
    values = np.column_stack((north, east, -up, np.sqrt(north**2 + east**2 + up**2)))
    values[missing] = 99999.0
    for second, row in zip(time_s, values, strict=True):
        moment = NOON + datetime.timedelta(seconds=float(second))
        cells = "".join(f"{value:10.2f}" for value in row)
        lines.append(f"{moment:%Y-%m-%d %H:%M:%S}.000 {moment:%j}   {cells}")
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module")
def flight() -> Recording:
    """A quadrotor that yaws and sways while the field changes by some 200 nT."""
    scenario = load("quad-calibration", CHANGES)
    parts = list(blocks(plan(scenario)))
    return recording_of({key: np.concatenate([part[key] for part in parts]) for key in parts[0]})


@pytest.fixture
def station(tmp_path: Path) -> Path:
    return iaga(tmp_path / "tst20240501.min", np.arange(-1800.0, 3600.0, 60.0))


def at_noon(one: Recording, *, attitude: bool = True) -> Recording:
    own = one if attitude else replace(one, att_q=None)
    return replace(own, origin=Origin(start_s=NOON.timestamp()))


def rms_nT(found: magbench.CalibrationResult, one: Recording) -> float:
    """Of the strength, with the true change taken off the field that the calibration gives."""
    field_nT = found.apply(one)
    change = course_enu_nT(one.time_s)
    true = np.linalg.norm(ENU_NT + change, axis=1)
    return float(np.std(np.linalg.norm(field_nT, axis=1) - true))


@pytest.mark.parametrize("attitude", [False, True])
def test_the_days_change_is_taken_off(attitude: bool, flight: Recording, station: Path) -> None:
    log, strength_nT = at_noon(flight, attitude=attitude), float(np.linalg.norm(ENU_NT))
    plain, quiet = (magbench.calibrate(log, strength_nT, base=base) for base in (None, station))
    truth = magbench.calibrate(replace(log, mag_nT=flight.mag_nT - _true_change(flight)), strength_nT)
    off, left = (np.linalg.norm(one.offset_nT - truth.offset_nT) for one in (plain, quiet))
    assert off > 5.0 * left, (off, left)
    assert left < 2.0
    assert rms_nT(quiet, log) < 1.1 * NOISE_NT < 1.5 * NOISE_NT < rms_nT(plain, log)


def _true_change(flight: Recording) -> Array:
    """S R_wb^T dh, less its mean over the log as a station's."""
    from calib.numerics.rates import world_to_body

    assert flight.att_q is not None
    soft = np.eye(3) + np.array([[0.06, 0.02, -0.062], [0.02, 0.08, 0.07], [-0.02, 0.03, -0.05]])
    change = course_enu_nT(flight.time_s)
    return np.asarray(world_to_body(flight.att_q, change - change.mean(axis=0)) @ soft.T)


def test_a_time_zone_and_a_stated_start_agree(flight: Recording, station: Path) -> None:
    reference, read = Reference(float(np.linalg.norm(ENU_NT))), BaseStation.read(station)
    unknown = replace(flight, origin=Origin())
    stated = [without_change(unknown, reference, read, text) for text in ("2024-05-01T12:00", "2024-05-01T14:00+02:00")]
    told = without_change(at_noon(flight), reference, read)
    for one in stated:
        np.testing.assert_array_equal(one.recording.mag_nT, told.recording.mag_nT)
    with pytest.raises(InputError, match="--base-start"):
        without_change(unknown, reference, read)
    with pytest.raises(InputError, match="no date and time"):
        without_change(unknown, reference, read, "noon")


def test_counts_are_corrected_alike(flight: Recording, station: Path) -> None:
    reference, read = Reference(float(np.linalg.norm(ENU_NT))), BaseStation.read(station)
    log = at_noon(flight)
    in_nT = without_change(log, reference, read).recording.mag_nT
    in_counts = without_change(replace(log, mag_nT=log.mag_nT / 15.0), reference, read).recording.mag_nT
    np.testing.assert_allclose(15.0 * in_counts, in_nT, atol=0.01)


def test_a_record_that_does_not_cover_the_log_is_refused(flight: Recording, tmp_path: Path) -> None:
    reference, log = Reference(float(np.linalg.norm(ENU_NT))), at_noon(flight)
    short = BaseStation.read(iaga(tmp_path / "short.min", np.arange(-600.0, 200.0, 60.0)))
    with pytest.raises(InputError, match=r"covers 2024-05-01 11:50:00 to .*, the log 2024-05-01 12:00"):
        without_change(log, reference, short)
    gap = iaga(tmp_path / "gap.min", np.arange(-1800.0, 3600.0, 60.0), missing=slice(25, 42))
    with pytest.raises(InputError, match="gap of 1080 s"):
        without_change(replace(log, time_s=4.0 * log.time_s), reference, BaseStation.read(gap))


def test_a_strength_alone_is_enough(flight: Recording, tmp_path: Path) -> None:
    """A proton magnetometer's CSV with dates, beside the log."""
    time_s = np.arange(-60.0, 600.0, 5.0)
    strength_nT = np.linalg.norm(ENU_NT + course_enu_nT(time_s), axis=1)
    moments = [NOON + datetime.timedelta(seconds=float(t)) for t in time_s]
    rows = [f"{t:%Y-%m-%dT%H:%M:%S},{f:.3f}" for t, f in zip(moments, strength_nT, strict=True)]
    path = tmp_path / "proton.csv"
    path.write_text("\n".join(["time_s,scalar_nT", *rows, ""]))
    found = without_change(at_noon(flight), Reference(float(np.linalg.norm(ENU_NT))), BaseStation.read(path))
    assert not found.by_vector
    true = np.linalg.norm(ENU_NT + course_enu_nT(flight.time_s), axis=1)
    assert found.high_nT - found.low_nT == pytest.approx(np.ptp(true), abs=1.0)


def test_dates_in_a_log_are_its_start(tmp_path: Path) -> None:
    path, start_ms = tmp_path / "log.csv", 1000 * int(NOON.timestamp())
    starts = {
        NOON.timestamp() + 10: [f"2024-05-01T12:00:{k:02d}Z" for k in range(10, 40)],
        NOON.timestamp(): [f"{start_ms + 20 * k}" for k in range(30)],
        None: [f"{k}" for k in range(30)],
    }
    for start_s, times in starts.items():
        rows = "".join(f"{time},{100 * k},{2000 + k % 7},{-40000 + k % 5}\n" for k, time in enumerate(times))
        path.write_text("time_s,mag_x_nT,mag_y_nT,mag_z_nT\n" + rows)
        assert read_recording(path).origin.start_s == start_s


def test_the_command_says_what_was_taken_off(
    flight: Recording, station: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.parquet"
    write_recording(replace(flight, att_q=None), log)
    given = ["calibrate", str(log), "--with", "ellipsoid", "--field-strength-nT", "52219", "--base", str(station)]
    assert main(given) == 2
    assert "--base-start 2024-05-01T12:30:00" in capsys.readouterr().err
    assert main([*given, "--base-start", "2024-05-01T12:00:00"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert re.search(r"day's change of the strength, -\d+(\.\d+)? to \d+(\.\d+)? nT, is taken off", told)
