"""Calibrations read back in each form that is written, and recordings corrected file by file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from calib import Calibration, Status, to_dict
from recordings import Recording, read_recording, write_recording
from scenarios.errors import InputError
from validation.calibrating.calibration_file import apply_file, read_calibrations, write_calibrations

OFFSET_NT, MATRIX = np.array([100.0, -200.0, 300.0]), np.diag([1.1, 0.9, 1.0])
ONE = Calibration(name="ellipsoid", status=Status("ok"), offset_nT=OFFSET_NT, matrix=MATRIX)


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """The file of one calibration."""
    write_calibrations({"ellipsoid": ONE}, tmp_path)
    return tmp_path / "calibration.json"


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """A recording of random fields on disk."""
    rng = np.random.default_rng(0)
    write_recording(Recording(np.arange(50) / 10, rng.normal(size=(50, 3)) * 3e4), tmp_path / "measured.parquet")
    return tmp_path / "measured.parquet"


@pytest.mark.parametrize("text", ["{}", "[]", "3", '{"calibrations": {}}'])
def test_a_file_without_a_calibration_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "empty.json").write_text(text)
    with pytest.raises(InputError, match="holds no calibration"):
        read_calibrations(tmp_path / "empty.json")


def test_each_form_of_the_file_gives_the_same_calibration(saved: Path) -> None:
    table = to_dict(ONE)
    forms = {"ellipsoid": table}, table, {"calibrations": {"ellipsoid": table}}
    for form in forms:
        saved.write_text(json.dumps(form))
        (found,) = read_calibrations(saved).items()
        assert found[0] == "ellipsoid"
        np.testing.assert_array_equal(found[1].matrix, MATRIX)


def test_a_recording_is_corrected_to_the_offset_and_the_matrix(saved: Path, measured: Path) -> None:
    out = saved.parent / "corrected.parquet"
    done = apply_file(saved, measured, out)
    assert (done["calibrator"], done["samples"], done["warning"]) == ("ellipsoid", 50, "")
    raw_nT, corrected_nT = (read_recording(path).mag_nT for path in (measured, out))
    np.testing.assert_allclose(corrected_nT, (raw_nT - OFFSET_NT) @ MATRIX.T, rtol=1e-12)


def test_nothing_is_written_over_what_it_is_made_from(saved: Path, measured: Path) -> None:
    for out in (saved, measured):
        with pytest.raises(InputError, match="would replace what it is made from"):
            apply_file(saved, measured, out)
