"""Calibrations read back in each form that is written, and recordings corrected file by file."""

from __future__ import annotations

import json
from dataclasses import replace
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
    done = apply_file(saved, measured, out).summary()
    assert (done["calibrator"], done["samples"], done["warning"]) == ("ellipsoid", 50, "")
    raw_nT, corrected_nT = (read_recording(path).mag_nT for path in (measured, out))
    np.testing.assert_allclose(corrected_nT, (raw_nT - OFFSET_NT) @ MATRIX.T, rtol=1e-12)


def test_nothing_is_written_over_what_it_is_made_from(saved: Path, measured: Path) -> None:
    for out in (saved, measured):
        with pytest.raises(InputError, match="would replace what it is made from"):
            apply_file(saved, measured, out)


def test_a_refused_export_keeps_back_no_other_file(tmp_path: Path) -> None:
    flat = Calibration(name="sphere", status=Status("unobservable", "the motion is flat"))
    old = tmp_path / "sphere" / "px4.params"
    old.parent.mkdir()
    old.write_text("param set CAL_MAG0_XOFF 0.1\n")
    refused = write_calibrations({"sphere": flat, "ellipsoid": ONE}, tmp_path, ["c", "px4"]).refused
    assert len(refused) == 1
    assert refused[0].startswith("c, px4 of sphere: there is no estimate (unobservable): the motion is flat")
    written = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()}
    assert written == {"calibration.json", "ellipsoid/mag_calibration.h", "ellipsoid/px4.params"}
    table = json.loads((tmp_path / "calibration.json").read_text())
    assert table["sphere"]["offset_nT"] is None
    assert table["sphere"]["matrix"] is None
    assert not read_calibrations(tmp_path / "calibration.json")["sphere"].has_estimate


def test_an_estimate_that_is_not_ok_is_applied_with_a_warning_and_none_is_refused(
    measured: Path, tmp_path: Path
) -> None:
    slow = replace(ONE, status=Status("not_converged", "too slow"))
    for key, fit in (("some", slow), ("none", Calibration(name="none", status=Status("unobservable", "flat")))):
        write_calibrations({key: fit}, tmp_path / key)
    done = apply_file(tmp_path / "some" / "calibration.json", measured, tmp_path / "o.csv").summary()
    assert done["warning"] == "some is not converged: too slow"
    with pytest.raises(InputError, match="gave no calibration: flat"):
        apply_file(tmp_path / "none" / "calibration.json", measured, tmp_path / "p.csv")
    assert not (tmp_path / "p.csv").exists()


def test_a_scalar_magnetometers_terms_correct_its_channel_alone(tmp_path: Path) -> None:
    """A permanent field along body x, measured at 10 Hz in a slow turn about z that nods."""
    time_s = np.arange(600) / 10.0
    level, nod = np.column_stack([np.cos(0.3 * time_s), np.sin(0.3 * time_s)]), 0.2 * np.sin(0.1 * time_s)
    mag_nT = 3e4 * np.column_stack([np.cos(nod)[:, None] * level, np.sin(nod)])
    scalar_nT = 3e4 + 20.0 * np.cos(nod) * np.cos(0.3 * time_s)
    log, out = tmp_path / "log.parquet", tmp_path / "o.parquet"
    write_recording(Recording(time_s, mag_nT, channels={"scalar_nT": scalar_nT}), log)
    told = {"permanent_x_nT": 20.0, "reference_nT": 3e4, "band_low_hz": 0.01, "band_high_hz": 0.9}
    fit = Calibration(name="tolles_lawson", status=Status("ok"), parameters=told)
    write_calibrations({"tolles_lawson": fit}, tmp_path)
    done = apply_file(tmp_path / "calibration.json", log, out).summary()
    assert done["corrected"] == "scalar_nT"
    found = read_recording(out)
    np.testing.assert_allclose(found.channels["scalar_nT"], 3e4, atol=0.05)
    np.testing.assert_array_equal(found.mag_nT, mag_nT)
    write_recording(Recording(time_s, mag_nT), log)
    with pytest.raises(InputError, match="the recording has none"):
        apply_file(tmp_path / "calibration.json", log, out)


def test_a_calibrator_with_options_has_one_folder(tmp_path: Path) -> None:
    write_calibrations({"twostep:band=0.1/0.9": ONE, "sphere@2": ONE}, tmp_path, ["c"])
    folders = {path.parent.name for path in tmp_path.glob("*/mag_calibration.h")}
    assert folders == {"twostep-band=0.1-0.9", "sphere@2"}
