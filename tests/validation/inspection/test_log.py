"""A file as it is: names, units, faults kept, and the sound rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.dataset_writer import generate
from sim.scenario import load
from validation.inspection.log import read_log, series_of

CSV = """t,bx,by,bz,temperature_degC
0,20,-3,41,5
20,21,,41,5
40,22,-3,41,
30,23,-3,41,5
30,24,-3,41,5
60,25,-3,inf,5
80,26,-3,41,5
"""
MAPS = ("time_s=t,unit=ms", "mag_x_nT=bx,unit=uT", "mag_y_nT=by,unit=uT", "mag_z_nT=bz,unit=uT")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    path.write_text(CSV)
    return path


def test_columns_get_names_and_units_and_their_faults_are_known(path: Path) -> None:
    log = read_log(path, maps=MAPS)
    np.testing.assert_allclose(log.as_found["time_s"], [0, 0.02, 0.04, 0.03, 0.03, 0.06, 0.08])
    np.testing.assert_allclose(log.as_found["mag_x_nT"], 1e3 * np.arange(20, 27))
    assert np.isnan(log.as_found["mag_y_nT"][1])
    assert np.isnan(log.as_found["temperature_degC"][2])
    assert log.sources["mag_x_nT"] == "bx"
    assert log.sensors == (None,)
    assert log.refusal
    assert str(path) not in log.refusal


def test_sound_rows_are_finite_and_in_order(path: Path) -> None:
    """Rows 2 and 6 have no field, rows 4 and 5 are late, and row 5 has the time of row 4: between it and row 3."""
    log = read_log(path, maps=MAPS)
    sound = series_of(log, None)
    assert len(log) == len(sound) == 5
    np.testing.assert_allclose(sound.time_s, [0, 0.03, 0.035, 0.04, 0.08])
    np.testing.assert_allclose(sound.mag_nT[:, 0], [20e3, 23e3, 24e3, 22e3, 26e3])
    assert [note.split()[0] for note in log.origin.notes] == ["2", "1", "1"]
    assert (sound.gyro_rad_s, sound.accel_m_s2, sound.att_q) == (None, None, None)
    np.testing.assert_allclose(sound.scaled(2.0).mag_nT, 2 * sound.mag_nT)


def test_vectors_are_there_whole_or_not_at_all(path: Path) -> None:
    log = read_log(path, maps=MAPS)
    assert log.vector(("mag_x_nT", "mag_y_nT")).shape == (5, 2)  # type: ignore[union-attr]
    assert log.vector(("mag_x_nT", "gyro_x_rad_s")) is None


def test_a_file_without_a_field_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.csv"
    path.write_text("time_s,a\n0,1\n1,2\n")
    with pytest.raises(InputError, match=r"other\.csv.*mag_x_nT"):
        read_log(path)


def test_a_run_of_a_dataset(tmp_path: Path) -> None:
    generate(load("tumble", ["sampling.rate_hz=5"]), tmp_path / "data")
    log = read_log(tmp_path / "data")
    assert log.path.name == "run-00000.parquet"
    assert log.refusal == ""
    assert not any(name.startswith(("true_", "effect_")) for name in log.columns)
    with pytest.raises(InputError, match="has no run 3"):
        read_log(tmp_path / "data", run=3)
