"""What every entry of FORMATS owes: its own example comes back, and whatever is damaged is refused in one line."""

from __future__ import annotations

import datetime
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cdflib
import h5netcdf
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
from ulog_bytes import TopicOf, UlogOf, xyz

from recordings import Recording, read_recording, write_recording
from recordings.assemble import arrays_of
from recordings.columns import ACCEL, ATTITUDE, GYRO, POSITION, mag_names
from recordings.readers import FORMATS, FileFormat, load
from scenarios.errors import InputError
from tests.recordings.readers.blackbox_logs import BlackboxWriter, betaflight_fields, rows_of
from tests.recordings.readers.dataflash import write_dataflash
from tests.recordings.readers.dataflash_text import write_dataflash_text
from tests.recordings.readers.ros_bags import Series, vector, write_bag
from tests.recordings.readers.telemetry import write_telemetry

N = 60


def write_iaga(recording: Recording, path: Path) -> None:
    """Times to 1 ms and the field to 0.01 nT, as IAGA-2002 holds them."""
    start = datetime.datetime(2024, 5, 1, 23, 59, 59)
    lines = [" Format                 IAGA-2002                                    |"]
    lines.append("DATE       TIME         DOY     XXXX      XXXY      XXXZ      XXXF   |")
    for time_s, field_nT in zip(recording.time_s, recording.mag_nT, strict=True):
        stamp = (start + datetime.timedelta(seconds=float(time_s))).isoformat(" ", "milliseconds")
        lines.append(f"{stamp} 122   " + " ".join(f"{value:9.2f}" for value in (*field_nT, 88888.0)))
    path.write_text("\n".join(lines) + "\n")


def write_ros(recording: Recording, path: Path) -> None:
    """A ROS 1 bag: vectors as float64, temperature apart; the attitude would come back with signs of its own."""
    stamps = [1_714_564_800 * 10**9 + round(1e9 * t) for t in recording.time_s.tolist()]
    rates, forces = map(np.atleast_2d, (recording.gyro_rad_s, recording.accel_m_s2))
    imu = [
        {"angular_velocity": vector(w), "linear_acceleration": vector(f)} for w, f in zip(rates, forces, strict=True)
    ]
    field = [{"magnetic_field": vector(1e-9 * row)} for row in recording.mag_nT]
    degrees = np.atleast_1d(recording.temperature_degC).tolist()
    path.unlink(missing_ok=True)
    series = [
        Series("/mag", "sensor_msgs/msg/MagneticField", field, stamps),
        Series("/imu", "sensor_msgs/msg/Imu", imu, stamps),
        Series("/temperature", "sensor_msgs/msg/Temperature", [{"temperature": one} for one in degrees], stamps),
    ]
    write_bag(path, series, ros=1)


def numbers_of(recording: Recording) -> dict[str, np.ndarray]:
    """The columns of numbers: all but the phase."""
    return {name: values for name, values in arrays_of(recording).items() if name != "phase"}


def write_netcdf(recording: Recording, path: Path) -> None:
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"time": len(recording.time_s)}
        for name, values in numbers_of(recording).items():
            file.create_variable(name, ("time",), "f8", data=values)


def write_imagcdf(recording: Recording, path: Path) -> None:
    """Times to 1 ns and the field, of the observatory's own frame."""
    file = cdflib.cdfwrite.CDF(path, delete=True)
    start = cdflib.cdfepoch.compute_tt2000([2024, 5, 1, 23, 59, 59, 0, 0, 0])
    ticks = np.int64(start) + np.round(recording.time_s * 1e9).astype(np.int64)
    columns = {"GeomagneticVectorTimes": (33, ticks)}
    columns |= {
        f"GeomagneticField{element}": (45, values) for element, values in zip("XYZ", recording.mag_nT.T, strict=True)
    }
    for name, (kind, values) in columns.items():
        about = {"Variable": name, "Data_Type": kind, "Num_Elements": 1, "Rec_Vary": True, "Dim_Sizes": []}
        file.write_var(about, var_data=np.ascontiguousarray(values))
    file.close()


def write_mat(recording: Recording, path: Path) -> None:
    scipy.io.savemat(path, numbers_of(recording))


def write_ulog(recording: Recording, path: Path) -> None:
    """What PX4's topics hold: no attitude, whose sign is free, and no phases that are no modes."""
    t, down = recording.time_s, np.array([1.0, -1.0, -1.0])
    motion = {"gyro_rad": recording.gyro_rad_s, "accelerometer_m_s2": recording.accel_m_s2}
    east, north, up = recording.pos_enu_m.T
    escs = {f"esc[{k}].esc_current": ("float", column) for k, column in enumerate(recording.current_A.T)}
    degrees = {"temperature": ("float", recording.temperature_degC)}
    topics = [
        TopicOf("sensor_mag", t, xyz(recording.mag_nT * down / 1e5) | degrees),
        TopicOf("sensor_combined", t, {name: ("float", values * down) for name, values in motion.items()}),
        TopicOf("vehicle_local_position", t, xyz(np.column_stack([north, east, -up]))),
        TopicOf("esc_status", t, escs),
    ]
    path.write_bytes(UlogOf(topics).bytes())


def write_phone(recording: Recording, path: Path) -> None:
    """Sensor Logger's archive of an Android, axes in the order z, y, x."""
    tables = {
        "MagnetometerUncalibrated": recording.mag_nT / 1e3,
        "Gyroscope": np.atleast_2d(recording.gyro_rad_s),
        "TotalAcceleration": np.atleast_2d(recording.accel_m_s2),
    }
    with zipfile.ZipFile(path, "w") as file:
        for name, values in tables.items():
            rows = [
                f"{1_714_564_800 * 10**9 + round(1e9 * t)},{t!r},{z!r},{y!r},{x!r}"
                for t, (x, y, z) in zip(recording.time_s.tolist(), values.tolist(), strict=True)
            ]
            file.writestr(f"{name}.csv", "\n".join(["time,seconds_elapsed,z,y,x", *rows]) + "\n")


def write_blackbox(recording: Recording, path: Path) -> None:
    """Betaflight's main frames at high resolution: whole counts, tenths of deg/s, 2048 to a g, hundredths of A."""
    columns = {
        "loopIteration": np.arange(len(recording.time_s)),
        "time": 1e6 * recording.time_s,
        "magADC": recording.mag_nT,
        "gyroADC": 10 * np.degrees(np.atleast_2d(recording.gyro_rad_s)),
        "accSmooth": np.atleast_2d(recording.accel_m_s2) / 9.80665 * 2048,
        "amperageLatest": 100 * np.atleast_2d(recording.current_A)[:, 0],
    }
    about = {"Firmware revision": "Betaflight 4.5.1 (77d01ba3b) X", "acc_1G": "2048", "blackbox_high_resolution": "1"}
    names = ("loopIteration", "time", "magADC", "gyroADC", "accSmooth", "amperageLatest")
    fields = [one for one in betaflight_fields() if one.name.split("[")[0] in names]
    writer = BlackboxWriter(fields, about)
    for row in rows_of(columns):
        writer.main(row)
    path.write_bytes(writer.end())


EXAMPLES: dict[str, Callable[[Recording, Path], None]] = {
    "Parquet": write_recording,
    "MAVLink telemetry": write_telemetry,
    "ArduPilot": lambda recording, path: write_dataflash(replace(recording, att_q=None), path),
    "ArduPilot's log as text": lambda recording, path: write_dataflash_text(replace(recording, att_q=None), path),
    "netCDF": write_netcdf,
    "ImagCDF": write_imagcdf,
    "MATLAB": write_mat,
    "ULog": write_ulog,
    "phone recording": write_phone,
    "IAGA-2002": write_iaga,
    "CSV": write_recording,
    "ROS bag": write_ros,
    "blackbox": write_blackbox,
}
"""How a test writes a recording in each format, from the recording alone: an entry for each entry of FORMATS."""
NUMBERS = (
    *("time_s", *mag_names(), *GYRO, *ACCEL, *ATTITUDE, *POSITION),
    *("temperature_degC", "current_1_A", "current_2_A", "wheel_rad_s"),
)
HEAT_AND_CURRENTS = ("temperature_degC", "current_1_A", "current_2_A")
PARTS: dict[str, tuple[str, ...]] = {
    "MAVLink telemetry": ("time_s", *mag_names(), *GYRO, *ACCEL, *POSITION, "temperature_degC"),
    "ArduPilot": ("time_s", *mag_names(), *GYRO, *ACCEL, *POSITION, *HEAT_AND_CURRENTS),
    "ArduPilot's log as text": ("time_s", *mag_names(), *GYRO, *ACCEL, *POSITION, *HEAT_AND_CURRENTS),
    "netCDF": NUMBERS,
    "ImagCDF": ("time_s", *mag_names()),
    "MATLAB": NUMBERS,
    "phone recording": ("time_s", *mag_names(), *GYRO, *ACCEL),
    "IAGA-2002": ("time_s", *mag_names()),
    "ULog": tuple(name for name in NUMBERS if name not in (*ATTITUDE, "wheel_rad_s")),
    "blackbox": ("time_s", *mag_names(), *GYRO, *ACCEL, "current_1_A"),
    "ROS bag": ("time_s", *mag_names(), *GYRO, *ACCEL, "temperature_degC"),
}
"""What a format holds of a recording, where not all of it."""
STEPS_NT = {"ArduPilot": 100.0, "ArduPilot's log as text": 100.0, "blackbox": 0.51}
"""Steps of the field in formats that are coarser than 0.01 nT."""
FOREIGN = {
    "nothing": b"",
    "a zip archive": b"PK\x03\x04" + bytes(range(256)),
    "a picture": b"\x89PNG\r\n\x1a\n" + bytes(99),
    "noise": np.random.default_rng(5).bytes(4000),
    "a MATLAB file": b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(400),
    "prose": b"Calibration of three-axis magnetometers,\nby the sea.\n" * 9,
}
formats = pytest.mark.parametrize("form", FORMATS, ids=lambda form: form.name)


def recording() -> Recording:
    """Everything that an instrument may give but an array."""
    rng = np.random.default_rng(11)
    q = rng.standard_normal((N, 4))
    return Recording(
        time_s=np.arange(N) * 0.05,
        mag_nT=2e4 * rng.standard_normal((N, 3)),
        gyro_rad_s=rng.standard_normal((N, 3)),
        accel_m_s2=rng.standard_normal((N, 3)),
        att_q=q / np.linalg.norm(q, axis=1, keepdims=True),
        pos_enu_m=rng.standard_normal((N, 3)),
        temperature_degC=rng.standard_normal(N),
        current_A=rng.standard_normal((N, 2)),
        phase=np.where(np.arange(N) < 20, "spiral", "comb"),
        channels={"wheel_rad_s": rng.standard_normal(N)},
    )


def written(form: FileFormat, place: Path) -> Path:
    """An example of the format, under the first of its suffixes."""
    path = place / f"example{form.suffixes[0]}"
    path.write_bytes(example(form.name, path.name))
    return path


@cache
def example(form: str, name: str) -> bytes:
    """The bytes of a format's example, made once for all tests."""
    with TemporaryDirectory() as folder:
        EXAMPLES[form](recording(), Path(folder) / name)
        return (Path(folder) / name).read_bytes()


def refusal(path: Path) -> InputError | None:
    """The error of reading, if any; another exception than an InputError fails the test."""
    try:
        read_recording(path)
    except InputError as error:
        return error
    return None


def assert_read_or_refused(path: Path) -> None:
    """A refusal is one line about the file, with advice."""
    error = refusal(path)
    if error is not None:
        assert str(error).startswith(str(path))
        assert "\n" not in str(error)
        assert len(str(error)) < len(str(path)) + 500
        assert error.do


def test_every_format_has_suffixes_of_its_own_and_an_example() -> None:
    assert EXAMPLES.keys() == {form.name for form in FORMATS}
    suffixes = [suffix for form in FORMATS for suffix in form.suffixes]
    assert len(set(suffixes)) == len(suffixes)
    assert all(suffix == suffix.lower() and suffix.startswith(".") for suffix in suffixes)


@formats
def test_example_comes_back(form: FileFormat, tmp_path: Path) -> None:
    expected, again = arrays_of(recording()), arrays_of(read_recording(written(form, tmp_path)))
    assert again.keys() == set(PARTS.get(form.name, expected))
    for name, values in again.items():
        if form.name in PARTS:
            atol = STEPS_NT.get(form.name, 0.0051) if name.startswith("mag_") else 0.0051
            np.testing.assert_allclose(values, expected[name], atol=atol, err_msg=name)
        else:
            np.testing.assert_array_equal(values, expected[name], err_msg=name)


@formats
def test_only_wanted_columns_are_loaded(form: FileFormat, tmp_path: Path) -> None:
    contents = load(written(form, tmp_path), lambda name: name.startswith("mag_"))
    assert sorted(contents.table.column_names) == ["mag_x_nT", "mag_y_nT", "mag_z_nT"]
    assert all(any(word in note for word in ("body frame", "undone", "magnetometer")) for note in contents.notes)


@formats
def test_example_is_recognised_as_itself_alone(form: FileFormat, tmp_path: Path) -> None:
    path = written(form, tmp_path)
    first = next(other for other in FORMATS if other.recognises(path, path.read_bytes()))
    assert first == form


@formats
@pytest.mark.parametrize("what", FOREIGN)
def test_foreign_content_under_the_suffix_is_refused(form: FileFormat, what: str, tmp_path: Path) -> None:
    for suffix in form.suffixes:
        path = tmp_path / f"foreign{suffix}"
        path.write_bytes(FOREIGN[what])
        assert refusal(path) is not None
        assert_read_or_refused(path)


@formats
def test_other_formats_under_the_suffix(form: FileFormat, tmp_path: Path) -> None:
    for other in FORMATS:
        written(other, tmp_path).replace(tmp_path / f"renamed{form.suffixes[0]}")
        assert_read_or_refused(tmp_path / f"renamed{form.suffixes[0]}")


@formats
def test_cut_off_example(form: FileFormat, tmp_path: Path) -> None:
    path = written(form, tmp_path)
    whole = path.read_bytes()
    for length in sorted({0, 1, 3, 4, 8, *np.linspace(9, len(whole) - 1, 25, dtype=int).tolist()}):
        path.write_bytes(whole[:length])
        assert_read_or_refused(path)


@formats
@pytest.mark.parametrize("seed", range(8))
def test_example_with_damaged_bytes(form: FileFormat, seed: int, tmp_path: Path) -> None:
    path, rng = written(form, tmp_path), np.random.default_rng(seed)
    whole = np.frombuffer(path.read_bytes(), np.uint8).copy()
    for share in (0.001, 0.02, 0.3):
        hit = rng.random(len(whole)) < share
        path.write_bytes(np.where(hit, rng.integers(0, 256, len(whole), np.uint8), whole).tobytes())
        assert_read_or_refused(path)


def test_the_room_loads_nothing_of_the_simulator(run_python: Callable[[str], Any]) -> None:
    names = "{'sim', 'calib', 'validation', 'mujoco'}"
    code = f"import sys, recordings; sys.exit(bool({names} & {{name.split('.')[0] for name in sys.modules}}))"
    assert run_python(code).returncode == 0


def test_unknown_format_lists_every_known_one(tmp_path: Path) -> None:
    (tmp_path / "log.mat").write_bytes(FOREIGN["a MATLAB file"])
    with pytest.raises(InputError) as caught:
        read_recording(tmp_path / "log.mat")
    for form in FORMATS:
        assert form.name in caught.value.what
        assert (form.summary in caught.value.do) == (".mat" in form.suffixes)
        assert all(suffix in caught.value.do for suffix in form.suffixes)


def test_two_columns_that_differ_by_blanks_alone(tmp_path: Path) -> None:
    pq.write_table(pa.table({"time_s": [1.0], " time_s": [2.0]}), tmp_path / "log.parquet")
    (tmp_path / "log.csv").write_text("time_s, time_s\n1,2\n")
    for suffix in ("parquet", "csv"):
        with pytest.raises(InputError, match="time_s: there are two columns of this name"):
            load(tmp_path / f"log.{suffix}", lambda name: True)
