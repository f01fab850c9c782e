"""The native logs that ship with the docs hold the flight that their script simulates: its iron and its motors."""

from __future__ import annotations

from pathlib import Path

import native_logs
import numpy as np
import pytest
from native_flight import IRON_NT, MOTOR_NT_A, PLACE, SOFT, UTC
from native_logs import LOGS, OLD_OFFSET_NT

import magbench
from recordings import write_recording

MOST_BYTES = 1_500_000


@pytest.mark.parametrize("name", ["flight.bin", "flight.ulg"])
def test_a_calibration_gives_the_true_iron_and_motors_back(name: str) -> None:
    found = magbench.calibrate(str(LOGS / name), with_="motor_ellipsoid:battery")
    assert found.status.kind == "ok"
    assert found.offset_nT is not None
    assert found.matrix is not None
    np.testing.assert_allclose(found.offset_nT, IRON_NT, atol=50.0)
    np.testing.assert_allclose(found.matrix @ SOFT, np.eye(3), atol=2e-3)
    applied = found.recording.origin.applied
    assert applied is not None
    np.testing.assert_allclose(applied.offset_nT, OLD_OFFSET_NT, atol=0.1)
    assert np.linalg.norm(OLD_OFFSET_NT - IRON_NT) > 1000.0


def test_the_motors_term_is_taken_off_before_the_heading_error_is_stated() -> None:
    """Left in, the motors' mean field of 8 A turns a level heading by half a degree."""
    found = magbench.calibrate(str(LOGS / "flight.bin"), with_=["motor_ellipsoid:battery"])
    best = found.assessment.best
    assert best is not None
    assert best.heading is not None
    assert best.heading.value < 0.1


def test_legs_are_held_out_beside_the_motors_term() -> None:
    """With the term the noise of 60 nT is left on unseen legs; the motors' field without the term is 167 nT."""
    found = magbench.calibrate(str(LOGS / "flight.bin"), with_=["motor_ellipsoid:battery"], tolerance_deg=2.0)
    best, answer = found.assessment.best, found.assessment.tolerance
    assert best is not None
    assert best.strength is not None
    assert best.strength.after_nT < 100.0
    assert answer is not None
    assert answer.causes is not None
    assert answer.causes.motors == 0.0


@pytest.mark.parametrize("name", ["flight.bin", "flight.ulg"])
def test_place_and_date_are_the_flights(name: str) -> None:
    origin = magbench.read(LOGS / name).recording.origin
    assert origin.date == UTC.date()
    assert origin.place is not None
    np.testing.assert_array_less(np.abs(np.subtract(origin.place, PLACE)), [1e-3, 1e-3, 30.0])


def test_the_logs_are_small() -> None:
    assert sum(path.stat().st_size for path in LOGS.iterdir()) < MOST_BYTES


def test_a_motor_adds_some_hundred_nanotesla_at_full_current() -> None:
    current_A = magbench.read(LOGS / "flight.bin").recording.current_A
    assert current_A is not None
    assert np.linalg.norm(MOTOR_NT_A) * np.ptp(current_A) > 300.0


@pytest.mark.slow
def test_the_script_writes_the_logs_that_ship(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the last digits of the simulation on another machine: the fields agree to a step of ArduPilot's log."""
    monkeypatch.setattr(native_logs, "LOGS", tmp_path)
    native_logs.main()
    for name in ("flight.bin", "flight.ulg"):
        kept, made = (magbench.read(folder / name).recording for folder in (LOGS, tmp_path))
        np.testing.assert_allclose(made.mag_nT, kept.mag_nT, atol=101.0)


def test_a_recording_is_written_into_a_new_directory(tmp_path: Path) -> None:
    recording = magbench.read(LOGS / "flight.bin").recording
    write_recording(recording, tmp_path / "new" / "flight.parquet")
    assert (tmp_path / "new" / "flight.parquet").is_file()
