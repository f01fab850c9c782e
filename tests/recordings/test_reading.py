"""What is stated of a log: columns, axes and frame, and the file that keeps the options."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.spatial.transform import Rotation

from recordings import Reading, read_recording
from recordings.reading import kept_file, listening
from scenarios.errors import InputError

TIME_S = np.arange(50) * 0.1
TURNS = Rotation.random(50, rng=1)
MAG_NT = 50_000.0 * TURNS.as_matrix()[:, 0]
NED_FROM_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD_FROM_FLU = np.diag([1.0, -1.0, -1.0])


def written(path: Path, mag: np.ndarray, names: str = "bx,by,bz", **more: np.ndarray) -> Path:
    pq.write_table(pa.table({"time_s": TIME_S, **dict(zip(names.split(","), mag.T, strict=True)), **more}), path)
    return path


def test_columns_and_unit(tmp_path: Path) -> None:
    log = written(tmp_path / "log.parquet", MAG_NT / 1e3)
    found = read_recording(log, reading=Reading(mag="bx, by, bz", unit="uT"))
    np.testing.assert_allclose(found.mag_nT, MAG_NT, rtol=1e-12)


def test_axes_are_those_of_the_log_that_form_the_body(tmp_path: Path) -> None:
    log = written(tmp_path / "log.parquet", np.column_stack([MAG_NT[:, 1], MAG_NT[:, 0], -MAG_NT[:, 2]]))
    found = read_recording(log, reading=Reading(mag=("bx", "by", "bz"), unit="nT", axes="y,x,-z"))
    np.testing.assert_array_equal(found.mag_nT, MAG_NT)


def test_axes_may_be_a_list() -> None:
    assert Reading(axes=("y", "x", "-z")) == Reading(axes=["y", "x", "-z"]) == Reading(axes="y,x,-z")


def test_a_native_log_has_no_other_unit(tmp_path: Path) -> None:
    log = Path(__file__).parents[2] / "docs" / "logs" / "flight.ulg"
    with pytest.raises(InputError, match="--unit uT: does not apply: the reader of this format gives nT already"):
        read_recording(log, reading=Reading(unit="uT"))
    assert read_recording(log, reading=Reading(unit="nT")).mag_nT.shape[1] == 3


def test_a_log_in_frd_and_ned_is_turned(tmp_path: Path) -> None:
    """The field in the world, from attitude and measurement, does not depend on the frames of the log."""
    frd = NED_FROM_ENU @ TURNS.as_matrix() @ FRD_FROM_FLU
    q = Rotation.from_matrix(frd).as_quat(scalar_first=True)
    names = dict(zip(("att_qw", "att_qx", "att_qy", "att_qz"), q.T, strict=True))
    gyro = {f"gyro_{axis}_rad_s": np.full(50, value) for axis, value in zip("xyz", (1.0, -2.0, -3.0), strict=True)}
    log = written(tmp_path / "log.parquet", MAG_NT @ FRD_FROM_FLU, **names, **gyro)
    found = read_recording(log, reading=Reading(mag="bx,by,bz", unit="nT", frame="frd"))
    np.testing.assert_allclose(found.mag_nT, MAG_NT, atol=1e-9)
    np.testing.assert_allclose(found.gyro_rad_s, [[1.0, 2.0, 3.0]] * 50)
    assert found.att_q is not None
    turned = Rotation.from_quat(found.att_q, scalar_first=True)
    np.testing.assert_allclose((turned.inv() * TURNS).magnitude(), 0.0, atol=1e-7)
    assert found.origin.frame == "frd"


def test_options_are_kept_beside_the_log(tmp_path: Path) -> None:
    log = written(tmp_path / "log.parquet", MAG_NT / 1e3, 'b"x,by,bz')
    stated = Reading(
        mag='b"x,by,bz',
        unit="uT",
        axes="y,x,-z",
        frame="frd",
        place=(47.4, 8.5),
        date="2024-05-01",
        maps=("time_s=time_s",),
    )
    assert stated.keep(log)
    lines: list[str] = []
    with listening(lines.append):
        again = Reading.for_file(log)
    assert again == stated
    assert again.date == datetime.date(2024, 5, 1)
    assert lines[0].startswith("read as kept in log.parquet.magbench.toml: ")
    assert Reading.for_file(log, ("mag_x_nT=a",)).axes is None, "options given replace those kept"
    np.testing.assert_array_equal(read_recording(log).mag_nT, read_recording(log, reading=stated).mag_nT)


def test_a_damaged_file_of_options_is_named(tmp_path: Path) -> None:
    log = written(tmp_path / "log.parquet", MAG_NT)
    for text in ("axes = ", "axis = 'x'", "frame = 'ned'", "\x00"):
        kept_file(log).write_text(text)
        with pytest.raises(InputError, match=r"magbench\.toml"):
            read_recording(log)


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ({"mag": "bx"}, "--mag: 1 columns"),
        ({"unit": "furlong"}, "--unit: 'furlong' is no unit of a field"),
        ({"axes": "x,y"}, "--axes: 'x,y'"),
        ({"axes": "x,x,z"}, "does not name each axis once"),
        ({"axes": "x,y,--z"}, "does not name each axis once"),
        ({"axes": "x,y,"}, "does not name each axis once"),
        ({"axes": ("x", "y")}, "--axes: 'x,y'"),
        ({"axes": 5}, "--axes: '5'"),
        ({"frame": "ned"}, "--frame: 'ned' is no frame"),
        ({"place": "91,0"}, "--place"),
        ({"place": "47"}, "--place"),
        ({"place": "here"}, "--place"),
        ({"date": "1.5.2024"}, "--date"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(stated: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError) as caught:
        Reading(**stated)
    assert words in str(caught.value)
    assert caught.value.do
