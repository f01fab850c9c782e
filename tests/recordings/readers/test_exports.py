"""Further exports of makers: other worlds, angles, clocks and signs, and other spellings of the columns."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recordings import read_recording
from tests.recordings.readers.swing import DOWN, NED, assert_the_same_field, swing
from tests.recordings.readers.test_makers import GAIN_NT, axes, motion, table

OF = swing(400)
WORLDS = {"ENU": np.eye(3), "NED": NED, "NWU": np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])}
"""East, north, up as Xsens' worlds: rows are their axes."""


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("form", ["quaternion", "angles", "matrix"])
def test_xsens_in_every_world(world: str, form: str, tmp_path: Path) -> None:
    turned = Rotation.from_matrix(WORLDS[world] @ OF.attitude.as_matrix())
    forms = {
        "quaternion": ([f"Quat_q{k}" for k in range(4)], turned.as_quat(scalar_first=True)),
        "angles": (["Roll", "Pitch", "Yaw"], turned.as_euler("ZYX", degrees=True)[:, ::-1]),
        "matrix": ([f"Mat[{i}][{j}]" for i in (1, 2, 3) for j in (1, 2, 3)], turned.as_matrix().reshape(-1, 9)),
    }
    names, attitude = forms[form]
    date = np.tile([2024, 5, 1], (400, 1))
    columns = [np.arange(400), OF.time_s * 1e4, date, OF.accel_m_s2, OF.rate_rad_s, OF.mag_nT / GAIN_NT, attitude]
    first = ["PacketCounter", "SampleTimeFine", "UTC_Year", "UTC_Month", "UTC_Day"]
    names = [*first, *axes("Acc_{}"), *axes("Gyr_{}"), *axes("Mag_{}"), *names]
    above = f"// General information:\n//  MT Manager version: 2022.0.0\n// Coordinate system: {world}\n"
    found = read_recording(table(tmp_path / "MT.txt", names, np.column_stack(columns), "\t", above))
    motion(found)
    assert_the_same_field(found, OF, 0.1, GAIN_NT)
    assert found.origin.date == datetime.date(2024, 5, 1)


def test_xsens_dot(tmp_path: Path) -> None:
    """A clock in microseconds that wraps, and rates in degrees."""
    ticks = (2**32 - 3_000_000 + np.round(OF.time_s * 1e6)) % 2**32
    columns = [np.arange(400), ticks, OF.wxyz(), OF.accel_m_s2, np.degrees(OF.rate_rad_s), OF.mag_nT / GAIN_NT]
    quaternion = [f"Quat_{part}" for part in "WXYZ"]
    names = ["PacketCounter", "SampleTimeFine", *quaternion, *axes("Acc_{}"), *axes("Gyr_{}"), *axes("Mag_{}")]
    above = "sep=,\nDeviceTag:,Xsens DOT\nFirmwareVersion:,2.0.0\nOutputRate:,20Hz\n\n"
    found = read_recording(table(tmp_path / "dot.csv", names, np.column_stack(columns), above=above))
    motion(found)
    np.testing.assert_allclose(found.time_s - found.time_s[0], OF.time_s, atol=1e-5)
    assert_the_same_field(found, OF, 0.1, GAIN_NT)


@pytest.mark.parametrize("form", ["{}.{}", "Group.{}[{}]"])
def test_vectornavs_other_spellings(form: str, tmp_path: Path) -> None:
    def three(name: str, parts: str = "xyz") -> list[str]:
        return [form.format(name, k if "[" in form else part) for k, part in enumerate(parts)]

    turn = ["yaw", "pitch", "roll"]
    angles = three("YawPitchRoll") if "[" in form else [f"YawPitchRoll.{name}" for name in turn]
    vectors = [name for kind in ("UncompMag", "Accel", "AngularRate") for name in three(kind)]
    down = [values @ DOWN for values in (OF.mag_nT / 1e5, OF.accel_m_s2, OF.rate_rad_s)]
    columns = np.column_stack([OF.time_s * 1e9 + 5e9, *down, OF.roll_pitch_yaw_deg[:, ::-1]])
    found = read_recording(table(tmp_path / "vn.csv", ["TimeStartup", *vectors, *angles], columns))
    motion(found)
    assert_the_same_field(found, OF, 0.1)


@pytest.mark.parametrize("form", ["6253.4220:scaled{kind}{axis}", "{axis} {kind} [x800{number}]"])
def test_microstrain(form: str, tmp_path: Path) -> None:
    """Gauss, g and rad, forward, right, down; the angles of the second form in radians."""
    kinds = (("Mag", OF.mag_nT / 1e5), ("Accel", OF.accel_m_s2 / 9.80665), ("Gyro", OF.rate_rad_s))
    names = [form.format(kind=kind, axis=axis, number=k) for k, (kind, _) in enumerate(kinds) for axis in "XYZ"]
    columns = [OF.time_s + 1e5, *(values @ DOWN for _, values in kinds), np.radians(OF.roll_pitch_yaw_deg)]
    angles = ["Roll [x800C]", "Pitch [x800C]", "Yaw [x800C]"]
    found = read_recording(table(tmp_path / "gx5.csv", ["GPS TOW", *names, *angles], np.column_stack(columns)))
    motion(found)
    assert found.origin.frame == "frd"
    assert_the_same_field(found, OF, 0.1)


def test_an_iphones_raw_magnetometer_and_sign(tmp_path: Path) -> None:
    raw, calibrated = OF.mag_nT / 1e3, OF.mag_nT / 1e3 - 7
    names = ["magnetometerTimestamp_sinceReboot(s)", *axes("accelerometerAcceleration{}(G)")]
    names += [*axes("gyroRotation{}(rad/s)"), *axes("magnetometer{}(µT)"), *axes("motionMagneticField{}(µT)")]
    columns = [OF.time_s + 900, -OF.accel_m_s2 / 9.80665, OF.rate_rad_s, raw, calibrated]
    assert_the_same_field(read_recording(table(tmp_path / "ios.csv", names, np.column_stack(columns))), OF, 0.1)


def test_stamps_with_a_blank_between_tabs(tmp_path: Path) -> None:
    """The blank in a time is no delimiter, in a line above the header neither."""
    start = datetime.datetime(2024, 5, 1, 12, tzinfo=datetime.UTC)
    lines = ["StartTime: 2024-05-01 12:00:00.000", "\t".join(["Device", "Chip Time", *axes("Magnetic field {}(uT)")])]
    for t, row in zip(OF.time_s, OF.mag_nT / 1e3, strict=True):
        now = start + datetime.timedelta(seconds=float(t))
        lines.append("\t".join(["WT901", f"{now:%Y-%m-%d %H:%M:%S.%f}", *(f"{part:.4f}" for part in row)]))
    (tmp_path / "wit.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = read_recording(tmp_path / "wit.txt")
    assert_the_same_field(found, OF, 0.1)
    np.testing.assert_allclose(found.time_s - found.time_s[0], OF.time_s, atol=1e-5)
    assert found.origin.date == start.date()


PRINTS = {
    "equals": "t={t:.3f} mag=[{m[0]:.4f}, {m[1]:.4f}, {m[2]:.4f}] acc=[{a[0]:.4f}, {a[1]:.4f}, {a[2]:.4f}]",
    "json": '{{"t": {t:.3f}, "mag": [{m[0]:.4f}, {m[1]:.4f}, {m[2]:.4f}], '
    '"acc": [{a[0]:.4f}, {a[1]:.4f}, {a[2]:.4f}]}}',
    "units": "time: {t:.3f} Acc (m/s2) [ {a[0]:09.4f}, {a[1]:09.4f}, {a[2]:09.4f} ], "
    "Mag (uT) [ {m[0]:09.4f}, {m[1]:09.4f}, {m[2]:09.4f} ], Tmp (C) [ 00025.10 ]",
}
"""Lines with vectors in brackets."""


@pytest.mark.parametrize("form", PRINTS)
def test_prints_of_vectors_in_brackets(form: str, tmp_path: Path) -> None:
    rows = zip(OF.time_s, OF.mag_nT / 1e3, OF.accel_m_s2, strict=True)
    lines = [PRINTS[form].format(t=t, m=m, a=a) for t, m, a in rows]
    path = tmp_path / ("log.jsonl" if form == "json" else "log.txt")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = read_recording(path)
    assert found.accel_m_s2 is not None
    assert_the_same_field(found, OF, 0.2)
    np.testing.assert_allclose(found.time_s, OF.time_s, atol=1e-3)


def test_a_blackbox_table_with_units_behind_the_index(tmp_path: Path) -> None:
    names = [f"{kind}[{k}]{unit}" for kind, unit in (("gyroADC", " (deg/s)"), ("accSmooth", " (g)")) for k in range(3)]
    columns = [OF.time_s * 1e6, np.degrees(OF.rate_rad_s), OF.accel_m_s2 / 9.80665, OF.mag_nT / 33]
    names = ["time (us)", *names, *(f"magADC[{k}]" for k in range(3))]
    found = read_recording(table(tmp_path / "log.csv", names, np.column_stack(columns)))
    assert found.gyro_rad_s is not None
    assert found.accel_m_s2 is not None
    assert_the_same_field(found, OF, 0.1, 33.0)
