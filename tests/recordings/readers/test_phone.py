"""Phones: Sensor Logger's and phyphox' exports, archives and directories, signs of accelerations, and damage."""

from __future__ import annotations

import datetime
import zipfile
from pathlib import Path

import numpy as np
import pytest

from recordings import read_recording
from recordings.readers import load, packages
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.swing import Swing, assert_read_or_refused, assert_the_same_field, damaged, swing

START_NS = 1_714_564_800 * 10**9
"""1 May 2024, 12:00 UTC."""
PHONE_BIAS_NT = np.array([4000.0, -2500.0, 1500.0])
"""What the phone's own calibration takes off."""


def vectors(of: Swing, values: np.ndarray, delay_s: float = 0.0) -> str:
    """A table of Sensor Logger: nanoseconds, seconds, and the axes backwards."""
    lines = ["time,seconds_elapsed,z,y,x"]
    for t, (x, y, z) in zip(of.time_s + delay_s, values, strict=True):
        lines.append(f"{START_NS + round(t * 1e9)},{t:.6f},{z:.6f},{y:.6f},{x:.6f}")
    return "\n".join(lines) + "\n"


def orientation(of: Swing) -> str:
    lines = ["time,seconds_elapsed,yaw,qx,qz,roll,qw,qy,pitch"]
    for t, (w, x, y, z) in zip(of.time_s, of.wxyz(), strict=True):
        lines.append(f"{START_NS + round(t * 1e9)},{t:.6f},0,{x:.7f},{z:.7f},0,{w:.7f},{y:.7f},0")
    return "\n".join(lines) + "\n"


def metadata(platform: str, standardisation: str = "false") -> str:
    head = "version,device name,recording time,platform,standardisation"
    return f"{head}\n3,my phone,2024-05-01_12-00-00,{platform},{standardisation}\n"


def android(of: Swing) -> dict[str, str]:
    """Gravity alone turns: the acceleration without gravity is a shake along x."""
    shake = np.column_stack([0.2 * np.sin(9 * of.time_s), 0 * of.time_s, 0 * of.time_s])
    location = "time,seconds_elapsed,altitude,longitude,latitude\n"
    return {
        "MagnetometerUncalibrated.csv": vectors(of, of.mag_nT / 1e3),
        "Magnetometer.csv": vectors(of, (of.mag_nT - PHONE_BIAS_NT) / 1e3),
        "Gyroscope.csv": vectors(of, of.rate_rad_s, 0.003),
        "Accelerometer.csv": vectors(of, shake),
        "Gravity.csv": vectors(of, of.accel_m_s2),
        "TotalAcceleration.csv": vectors(of, of.accel_m_s2),
        "Orientation.csv": orientation(of),
        "Location.csv": location + "".join(f"{START_NS},{t},400.5,8.55,47.37\n" for t in (0.0, 10.0, 20.0)),
        "Metadata.csv": metadata("android"),
        "Annotation.csv": "time,seconds_elapsed,text\n",
    }


def pack(path: Path, tables: dict[str, str], folder: str = "") -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in tables.items():
            file.writestr(folder + name, text)
    return path


def unpack(path: Path, tables: dict[str, str]) -> Path:
    path.mkdir()
    for name, text in tables.items():
        (path / name).write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("form", ["zip", "folder in zip", "directory", "file"])
def test_sensor_logger_of_an_android(form: str, tmp_path: Path) -> None:
    of = swing(400)
    if form in ("directory", "file"):
        path = unpack(tmp_path / "log", android(of)) / ("Magnetometer.csv" if form == "file" else "")
    else:
        path = pack(tmp_path / "log.zip", android(of), "log-2024/" if form == "folder in zip" else "")
    found = read_recording(path)
    assert found.origin.magnetometer == "uncalibrated"
    assert found.gyro_rad_s is not None
    assert found.att_q is not None
    rows = np.searchsorted(of.time_s, found.time_s - 1e-6)
    kept = Swing(of.time_s[rows], of.attitude[rows], of.rate_rad_s[rows])
    assert_the_same_field(found, kept, 0.01)
    assert len(rows) > 395
    assert found.origin.place == (47.37, 8.55, 400.5)
    assert found.origin.date == datetime.date(2024, 5, 1)
    notes = " ".join(found.origin.notes)
    assert "--stream reads another: calibrated" in notes
    assert "this same magnetometer, from magnetic north" in notes


def test_the_calibrated_magnetometer_by_name(tmp_path: Path) -> None:
    of = swing(100)
    contents = load(pack(tmp_path / "log.zip", android(of)), lambda name: name.startswith("mag"), "calibrated")
    field = np.column_stack([contents.table.column(f"mag_{axis}_nT").to_numpy() for axis in "xyz"])
    np.testing.assert_allclose(field, of.mag_nT - PHONE_BIAS_NT, atol=1e-3)
    assert any("may have been calibrated by the phone" in note for note in contents.notes)


@pytest.mark.parametrize("standardised", ["true", "false"])
def test_an_iphones_accelerations(standardised: str, tmp_path: Path) -> None:
    """Without the total: gravity and the acceleration together, against the force unless standardised."""
    of, sign = swing(100), 1 if standardised == "true" else -1
    tables = {name: android(of)[name] for name in ("MagnetometerUncalibrated.csv", "Orientation.csv")}
    tables["Gravity.csv"] = vectors(of, 0.75 * sign * of.accel_m_s2)
    tables["Accelerometer.csv"] = vectors(of, 0.25 * sign * of.accel_m_s2)
    tables["Metadata.csv"] = metadata("ios", standardised)
    found = read_recording(pack(tmp_path / "log.zip", tables))
    assert found.accel_m_s2 is not None
    assert_the_same_field(found, of, 0.01)
    assert found.att_q is None
    assert any("their sign was turned" in note for note in found.origin.notes) == (sign < 0)


def test_without_gravity_there_is_no_specific_force(tmp_path: Path) -> None:
    of = swing(50)
    kept = ("Magnetometer.csv", "Accelerometer.csv", "Metadata.csv")
    found = read_recording(pack(tmp_path / "log.zip", {name: android(of)[name] for name in kept}))
    assert found.accel_m_s2 is None
    assert any("without gravity" in note for note in found.origin.notes)


def test_an_orientation_that_turns_otherwise_is_left_out(tmp_path: Path) -> None:
    of = swing(100)
    back = Swing(of.time_s, of.attitude.inv(), of.rate_rad_s)
    found = read_recording(pack(tmp_path / "log.zip", android(of) | {"Orientation.csv": orientation(back)}))
    assert found.att_q is None
    assert any("does not lift gravity up" in note for note in found.origin.notes)


def phyphox(of: Swing, mark: str = ",", decimal: str = ".") -> dict[str, str]:
    def table(names: tuple[str, ...], values: np.ndarray) -> str:
        rows = [[f"{cell:.9e}".replace(".", decimal) for cell in row] for row in np.column_stack([of.time_s, values])]
        head = mark.join(f'"{name}"' for name in ("Time (s)", *names))
        return "\n".join([head, *map(mark.join, rows)]) + "\n"

    field = of.mag_nT / 1e3
    return {
        "Magnetometer.csv": table(
            (*(f"Magnetic field {axis} (µT)" for axis in "xyz"), "Absolute field (µT)"),
            np.column_stack([field, np.linalg.norm(field, axis=1)]),
        ),
        "Gyroscope.csv": table(tuple(f"Gyroscope {axis} (rad/s)" for axis in "xyz"), of.rate_rad_s),
        "Accelerometer.csv": table(tuple(f"Acceleration {axis} (m/s^2)" for axis in "xyz"), of.accel_m_s2),
        "meta/device.csv": '"property","value"\n"version","1.1.16"\n',
        "meta/time.csv": (
            '"event","experiment time","system time","system time text"\n'
            f'"START",0.0,{START_NS / 1e9:.3f},"2024-05-01 12:00:00.000 UTC"\n'
            f'"PAUSE",20.0,{START_NS / 1e9 + 20:.3f},"2024-05-01 12:00:20.000 UTC"\n'
        ),
    }


@pytest.mark.parametrize(("mark", "decimal"), [(",", "."), (";", ","), ("\t", ",")])
def test_phyphox(mark: str, decimal: str, tmp_path: Path) -> None:
    of = swing(200)
    found = read_recording(pack(tmp_path / "exp.zip", phyphox(of, mark, decimal)))
    assert found.gyro_rad_s is not None
    assert found.accel_m_s2 is not None
    assert_the_same_field(found, of, 1e-3)
    assert found.origin.date == datetime.date(2024, 5, 1)


def test_phyphox_table_alone(tmp_path: Path) -> None:
    of = swing(100)
    (tmp_path / "Magnetometer.csv").write_text(phyphox(of)["Magnetometer.csv"], encoding="utf-8")
    assert_the_same_field(read_recording(tmp_path / "Magnetometer.csv"), of, 1e-3)


def test_archives_of_other_content(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is neither"):
        read_recording(pack(tmp_path / "a.zip", {"readme.csv": "a,b\n1,2\n"}))
    with pytest.raises(InputError, match="no table with times and x, y, z"):
        read_recording(pack(tmp_path / "b.zip", {"Magnetometer.csv": "a,b\n1,2\n"}))
    of = swing(20)
    pack(tmp_path / "c.zip", {f"{day}/{name}": text for day in "ab" for name, text in android(of).items()})
    with pytest.raises(InputError, match=r"holds 2 recordings: a, b .*unpack"):
        read_recording(tmp_path / "c.zip")


def test_an_archive_that_unpacks_to_more_than_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = pack(tmp_path / "a.zip", {"Magnetometer.csv": "0" * 10**6})
    assert path.stat().st_size < 2000
    monkeypatch.setattr(packages, "MOST_BYTES", 10**5)
    with pytest.raises(InputError, match=r"holds 1 tables of 1 MB together, at most 1000 of 0\.1 MB are read"):
        read_recording(path)


@DAMAGED_FILES
def test_damage(files: int, tmp_path: Path) -> None:
    path = pack(tmp_path / "log.zip", android(swing(30)))
    assert_read_or_refused(path, damaged(path.read_bytes(), files))
