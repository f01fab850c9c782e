"""Tables as makers of inertial units export them: frames, units and clocks that each format fixes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recordings import Recording, read_recording
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.swing import (
    DOWN,
    NED,
    Swing,
    assert_read_or_refused,
    assert_the_same_field,
    damaged,
    swing,
)

GAIN_NT = 49_000.0
"""The field at the factory, Xsens' unit."""


def table(path: Path, names: list[str], columns: np.ndarray, mark: str = ",", above: str = "", units: str = "") -> Path:
    rows = [mark.join(f"{cell:.12g}" for cell in row) for row in columns]
    path.write_text(above + "\n".join([mark.join(names), *([units] if units else []), *rows]) + "\n", encoding="utf-8")
    return path


def axes(form: str) -> list[str]:
    return [form.format(axis) for axis in "XYZ"]


def motion(found: Recording) -> None:
    assert found.gyro_rad_s is not None
    assert found.accel_m_s2 is not None
    assert found.att_q is not None


@pytest.mark.parametrize("mark", ["\t", ",", ";"])
@pytest.mark.parametrize("clock", ["SampleTimeFine", "PacketCounter"])
def test_xsens(mark: str, clock: str, tmp_path: Path) -> None:
    """Both counters wrap in the log."""
    of = swing(400)
    packets = (65_400 + np.arange(400)) % 65_536
    ticks = (2**32 - 50_000 + np.round(of.time_s * 1e4)) % 2**32
    above = "// Start Time: Unknown\n// Update Rate: 20.0Hz\n// Firmware Version: 4.6.0\n// Coordinate system: ENU\n"
    names = ["PacketCounter", *axes("Acc_{}"), *axes("Gyr_{}"), *axes("Mag_{}"), *(f"Quat_q{k}" for k in range(4))]
    columns = [packets, of.accel_m_s2, of.rate_rad_s, of.mag_nT / GAIN_NT, of.wxyz()]
    if clock == "SampleTimeFine":
        names.insert(1, clock)
        columns.insert(1, ticks)
    found = read_recording(table(tmp_path / "MT.txt", names, np.column_stack(columns), mark, above))
    motion(found)
    assert found.origin.unit == "count"
    np.testing.assert_allclose(found.time_s - found.time_s[0], of.time_s, atol=1e-4)
    assert_the_same_field(found, of, 0.1, GAIN_NT)


def test_xsens_without_a_stated_world(tmp_path: Path) -> None:
    of = swing(50)
    names = ["PacketCounter", *axes("Acc_{}"), *axes("Mag_{}"), *(f"Quat_q{k}" for k in range(4))]
    columns = np.column_stack([np.arange(50), of.accel_m_s2, of.mag_nT / GAIN_NT, of.wxyz()])
    found = read_recording(table(tmp_path / "MT.csv", names, columns))
    assert found.att_q is None
    assert any("left as channels" in note for note in found.origin.notes)


@pytest.mark.parametrize("units", [True, False])
def test_vectornav(units: bool, tmp_path: Path) -> None:
    of = swing(400)
    gauss, force, rate = (" [Gauss]", " [m/s^2]", " [rad/s]") if units else ("", "", "")
    names = ["TimeStartup" + (" [ns]" if units else ""), *axes("UnCompMag{}" + gauss), *axes("Accel{}" + force)]
    names += [*axes("AngularRate{}" + rate), *axes("Mag{}" + gauss), "Yaw", "Pitch", "Roll"]
    field = of.mag_nT @ DOWN / 1e5
    columns = [5e9 + of.time_s * 1e9, field, of.accel_m_s2 @ DOWN, of.rate_rad_s @ DOWN, field - 0.1]
    columns.append(of.roll_pitch_yaw_deg[:, ::-1])
    found = read_recording(table(tmp_path / "vn.csv", names, np.column_stack(columns)))
    motion(found)
    assert found.origin.frame == "frd"
    assert_the_same_field(found, of, 0.1)
    np.testing.assert_allclose(found.time_s - found.time_s[0], of.time_s, atol=1e-6)


def test_sbg(tmp_path: Path) -> None:
    """sbgBasicLogger's table of the magnetometer, with a row of units; the angles joined to it."""
    of = swing(400)
    names = ["timestamp", "status", *axes("mag{}"), *axes("accel{}"), "roll", "pitch", "yaw"]
    units = "\t".join(["(us)", "(na)", *["(au)"] * 3, *["(m.s^-2)"] * 3, *["(deg)"] * 3])
    columns = [of.time_s * 1e6, 0 * of.time_s, of.mag_nT @ DOWN / GAIN_NT, of.accel_m_s2 @ DOWN, of.roll_pitch_yaw_deg]
    found = read_recording(table(tmp_path / "mag.txt", names, np.column_stack(columns), "\t", "", units))
    assert found.att_q is not None
    assert found.origin.unit == "count"
    assert_the_same_field(found, of, 0.1, GAIN_NT)


@pytest.mark.parametrize("form", ["IMU_ATTI(0):{}{}", "IMU_ATTI(0):{}:{}"])
def test_dji(form: str, tmp_path: Path) -> None:
    of = swing(400)
    ned = Rotation.from_matrix(NED @ of.attitude.as_matrix() @ DOWN).as_quat(scalar_first=True)
    vectors = [form.format(kind, axis) for kind in ("mag", "accel", "gyro") for axis in "XYZ"]
    names = ["Tick#", "offsetTime", *vectors, *(f"IMU_ATTI(0):quat{part}" for part in "WXYZ")]
    columns = [np.arange(400), of.time_s, of.mag_nT @ DOWN / 40, of.accel_m_s2 @ DOWN / 9.80665]
    columns += [np.degrees(of.rate_rad_s @ DOWN), ned]
    found = read_recording(table(tmp_path / "FLY001.csv", names, np.column_stack(columns)))
    motion(found)
    assert found.origin.unit == "count"
    assert_the_same_field(found, of, 0.1, 40.0)


def test_gnss_logger(tmp_path: Path) -> None:
    """Lines of several sensors, whose columns are told in comments; the bias of the phone stands behind each vector."""
    of = swing(300)
    sensors = {
        "Accel": ("Mps2", of.accel_m_s2),
        "Gyro": ("RadPerSec", of.rate_rad_s),
        "Mag": ("MicroT", of.mag_nT / 1e3),
    }
    lines = ["# Version: v3.0.6.1", "# Raw,utcTimeMillis,TimeNanos", "# Fix,Provider,LatitudeDegrees,LongitudeDegrees"]
    for name, (unit, _) in sensors.items():
        vector = [f"{kind}{axis}{unit}" for kind in (f"Uncal{name}", "Bias") for axis in "XYZ"]
        lines += ["# ", f"# Uncal{name},utcTimeMillis,elapsedRealtimeNanos,{','.join(vector)}"]
    for k, t in enumerate(of.time_s):
        for name, (_, values) in sensors.items():
            cells = ",".join(f"{value:.7f}" for value in (*values[k], 1.5, 2.5, -3.0))
            lines.append(f"Uncal{name},{1_714_564_800_000 + round(1e3 * t)},{10**12 + round(1e9 * t)},{cells}")
        lines += [f"Fix,GPS,47.37,{8.55 + k}"] if k % 20 == 0 else []
    (tmp_path / "gnss_log.txt").write_text("\n".join(lines) + "\n")
    found = read_recording(tmp_path / "gnss_log.txt")
    assert found.gyro_rad_s is not None
    assert found.accel_m_s2 is not None
    assert_the_same_field(found, of, 0.01)
    np.testing.assert_allclose(found.time_s - found.time_s[0], of.time_s, atol=1e-6)


def test_angles_of_another_convention_stay_channels(tmp_path: Path) -> None:
    of = swing(100)
    names = ["TimeStartup", *axes("UncompMag{}"), *axes("Accel{}"), "Yaw", "Pitch", "Roll"]
    angles = of.roll_pitch_yaw_deg[:, ::-1] * [1, 1, -1]
    columns = np.column_stack([of.time_s * 1e9, of.mag_nT @ DOWN / 1e5, of.accel_m_s2 @ DOWN, angles])
    found = read_recording(table(tmp_path / "vn.csv", names, columns))
    assert found.att_q is None
    np.testing.assert_allclose(found.channels["Roll"], angles[:, 2], atol=1e-6)


@DAMAGED_FILES
def test_damage(files: int, tmp_path: Path) -> None:
    of = swing(30)
    names = ["TimeStartup", *axes("UncompMag{}"), *axes("Accel{}"), "Yaw", "Pitch", "Roll"]
    columns = np.column_stack([of.time_s * 1e9, of.mag_nT / 1e5, of.accel_m_s2, of.roll_pitch_yaw_deg[:, ::-1]])
    path = table(tmp_path / "vn.csv", names, columns)
    assert_read_or_refused(path, damaged(path.read_bytes(), files))


def test_other_tables_keep_their_names(tmp_path: Path) -> None:
    of: Swing = swing(60)
    names = ["timestamp", "status", *axes("mag{}"), *axes("accel{}")]
    columns = np.column_stack([of.time_s * 1e6, 0 * of.time_s, of.mag_nT / 1e3, of.accel_m_s2])
    found = read_recording(table(tmp_path / "log.csv", names, columns))
    np.testing.assert_allclose(found.mag_nT, of.mag_nT, rtol=1e-6)
