"""What phones export besides tables in an archive: JSON, directories with phyphox' meta, GnssLogger, spreadsheets."""

from __future__ import annotations

import datetime
import json
from pathlib import Path

import numpy as np
import pytest

from recordings import read_recording
from recordings.readers import phone_json
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.swing import DOWN, assert_read_or_refused, assert_the_same_field, damaged, swing
from tests.recordings.readers.test_phone import START_NS

OF = swing(300)
MAY_1 = datetime.date(2024, 5, 1)
STAMPS = [START_NS + round(t * 1e9) for t in OF.time_s]
SENSORS = {
    "MagnetometerUncalibrated": OF.mag_nT / 1e3,
    "Magnetometer": OF.mag_nT / 1e3 - 30,
    "Gyroscope": OF.rate_rad_s,
    "TotalAcceleration": OF.accel_m_s2,
}


def exported() -> str:
    rows: list[dict[str, str]] = [{"sensor": "Metadata", "platform": "ios", "standardisation": "true"}]
    for k, (stamp, t) in enumerate(zip(STAMPS, OF.time_s, strict=True)):
        for sensor, values in SENSORS.items():
            z, y, x = (f"{part:.7f}" for part in values[k][::-1])
            head = {"sensor": sensor, "time": str(stamp), "seconds_elapsed": f"{t:.6f}"}
            rows.append({**head, "z": z, "y": y, "x": x})
    head = {"sensor": "Location", "time": str(STAMPS[9]), "seconds_elapsed": "0.45"}
    return json.dumps([*rows, {**head, "latitude": "47.37", "longitude": "8.55", "altitude": "400.5"}])


def pushed() -> str:
    rows = [
        {"name": sensor.lower(), "time": stamp, "values": dict(zip("xyz", values[k].tolist(), strict=True))}
        for k, stamp in enumerate(STAMPS)
        for sensor, values in SENSORS.items()
    ]
    return json.dumps({"messageId": 1, "sessionId": "a", "deviceId": "b", "payload": rows})


@pytest.mark.parametrize("form", [exported, pushed])
def test_sensor_loggers_json(form: object, tmp_path: Path) -> None:
    (tmp_path / "log.json").write_text(exported() if form is exported else pushed(), encoding="utf-8")
    found = read_recording(tmp_path / "log.json")
    assert_the_same_field(found, OF, 0.1)
    assert found.gyro_rad_s is not None
    assert found.accel_m_s2 is not None
    assert found.origin.date == MAY_1
    assert found.origin.magnetometer == "uncalibrated"
    assert found.origin.place == ((47.37, 8.55, 400.5) if form is exported else None)


@DAMAGED_FILES
def test_damaged_json(files: int, tmp_path: Path) -> None:
    whole = json.dumps(json.loads(exported())[:200]).encode()
    assert_read_or_refused(tmp_path / "log.json", damaged(whole, files // 3))


def test_too_long_a_json_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(phone_json, "MOST_JSON_BYTES", 1000)
    (tmp_path / "log.json").write_text(exported(), encoding="utf-8")
    with pytest.raises(InputError, match="export it as CSV"):
        read_recording(tmp_path / "log.json")


@pytest.mark.parametrize("name", ["Magnetometer.csv", "Magnetic field.csv", "Raw Data.csv"])
@pytest.mark.parametrize(("mark", "decimal"), [(",", "."), ("\t", ","), (";", ",")])
def test_a_directory_of_phyphox(name: str, mark: str, decimal: str, tmp_path: Path) -> None:
    """One table of the magnetometer, and the clock in the folder meta."""
    rows = [
        [f"{v:.9E}".replace(".", decimal) for v in (t, *row)] for t, row in zip(OF.time_s, OF.mag_nT / 1e3, strict=True)
    ]
    names = ["Time (s)", *(f"Magnetic field {axis} (µT)" for axis in "xyz")]
    lines = [mark.join(f'"{one}"' for one in names), *(mark.join(row) for row in rows)]
    (tmp_path / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    (tmp_path / "meta").mkdir()
    clock = ["START", "0.000E0", f"{START_NS / 1e9:.6E}"], ["PAUSE", "1.5E1", f"{START_NS / 1e9 + 15:.6E}"]
    cells = [mark.join([f'"{event}"', *(n.replace(".", decimal) for n in numbers)]) for event, *numbers in clock]
    head = mark.join(f'"{one}"' for one in ("event", "experiment time", "system time"))
    (tmp_path / "meta" / "time.csv").write_text("\n".join([head, *cells]) + "\n", encoding="utf-8")
    found = read_recording(tmp_path)
    assert_the_same_field(found, OF, 0.1)
    assert found.origin.date == MAY_1


def test_gnss_logger_of_a_newer_release(tmp_path: Path) -> None:
    """Lines with a cell more than their header, place by the fixes, and the date by the phone's clock."""
    names = ",".join(f"UncalMag{axis}MicroT" for axis in "XYZ")
    lines = [
        f"# UncalMag,utcTimeMillis,elapsedRealtimeNanos,{names},BiasXMicroT,BiasYMicroT,BiasZMicroT",
        "# Fix,Provider,LatitudeDegrees,LongitudeDegrees,AltitudeMeters,UnixTimeMillis",
    ]
    for stamp, t, row in zip(STAMPS, OF.time_s, OF.mag_nT / 1e3, strict=True):
        values = ",".join(f"{part:.5f}" for part in row)
        lines.append(f"UncalMag,{stamp // 10**6},{round(t * 1e9) + 10**12},{values},1.0,2.0,3.0,3")
        lines.append(f"Fix,GPS,47.37,8.55,{430 + t:.1f},{stamp // 10**6}")
    (tmp_path / "gnss_log.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = read_recording(tmp_path / "gnss_log.txt")
    assert_the_same_field(found, OF, 0.1)
    np.testing.assert_allclose(found.time_s - found.time_s[0], OF.time_s, atol=1e-6)
    assert found.origin.place == pytest.approx((47.37, 8.55, 437.5), abs=0.1)
    assert found.origin.date == MAY_1


def test_vectornavs_lines_of_text(tmp_path: Path) -> None:
    values = np.column_stack(
        [OF.roll_pitch_yaw_deg[:, ::-1], OF.mag_nT @ DOWN / 1e5, OF.accel_m_s2 @ DOWN, OF.rate_rad_s @ DOWN]
    )
    lines = ["$VNYMR," + ",".join(f"{part:+.7f}" for part in row) + "*5F" for row in values]
    (tmp_path / "serial.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = read_recording(tmp_path / "serial.txt")
    np.testing.assert_allclose(found.mag_nT, OF.mag_nT, atol=0.1)
    assert found.accel_m_s2 is not None
    np.testing.assert_allclose(found.accel_m_s2, OF.accel_m_s2, atol=1e-4)
    assert found.att_q is not None


@pytest.mark.parametrize("suffix", [".xls", ".xlsx"])
def test_a_spreadsheet_is_refused_in_one_line(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"phyphox{suffix}"
    path.write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(500))
    with pytest.raises(InputError, match=r"is a spreadsheet \(save or export it as CSV\)"):
        read_recording(path)
