"""ArduPilot's logs as text: the same flight as the binary log's comes back, whatever else the file holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dataflash_bytes import DOWN, Log

from recordings.readers import load
from recordings.readers.ardupilot import text_log
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.dataflash import START_S, flight
from tests.recordings.readers.dataflash_text import as_text, write_text
from tests.recordings.readers.test_ardupilot import (
    HALF_STEP_NT,
    MOTOR_MG_A,
    OFFSET_MG,
    everything,
    field_of,
    flight_log,
    measured,
    refusal,
    vectors,
)


@pytest.mark.parametrize("separator", [", ", ","])
def test_a_flight_comes_back_as_from_the_binary_log(separator: str, tmp_path: Path) -> None:
    one = flight(120)
    log = flight_log(one)
    text = load(write_text(log, tmp_path / "flight.log", separator), everything)
    error = field_of(text) - measured(one) + 100 * one.current_A[:, None] * MOTOR_MG_A * DOWN
    assert np.abs(error).max() < 4 * HALF_STEP_NT
    binary = load(log.write(tmp_path / "flight.bin"), everything)
    assert text.table.column_names == binary.table.column_names
    for name in text.table.column_names:
        if name != "phase":
            found, expected = text.table[name].to_numpy(), binary.table[name].to_numpy()
            np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6, err_msg=name)
    assert text.place == pytest.approx(binary.place)
    assert (text.date, text.notes) == (binary.date, binary.notes)
    assert text.applied["1"].parameters == pytest.approx(dict(binary.applied["1"].parameters))


def test_an_old_log_with_a_heading_names_of_modes_and_messages_without_times(tmp_path: Path) -> None:
    """Text before the layouts, a byte order mark, commas within a text, a damaged line; PARM has no time."""
    log, one = Log(), flight(60)
    log.layout("MSG", "Z", "Message")
    log.add("MSG", START_S, "ArduCopter V3.2.1, of Mission Planner, 2015")
    log.layout("PARM", "Nf", "Name,Value")
    for axis, offset in zip("XYZ", OFFSET_MG, strict=True):
        log.add("PARM", START_S, f"COMPASS_OFS_{axis}", float(offset))
    log.layout("MODE", "IMh", "TimeMS,Mode,ThrCrs")
    log.add("MODE", START_S + 1, 5, 400)
    log.add("MODE", START_S + 3, 16, 400)
    log.layout("MAG", "Ihhhhhh", "TimeMS,MagX,MagY,MagZ,OfsX,OfsY,OfsZ")
    log.rows("MAG", one.time_s, *np.trunc(one.field_nT * DOWN / 100 + OFFSET_MG).T, *np.trunc(OFFSET_MG))
    lines = as_text(log).splitlines()
    lines[-3:-3] = ["MAG, 1053x0, 1, 2, 3, 4, 5, 6", "MAG, 105", "GPS?", "\x00\xff"]
    path = tmp_path / "2015-03-01 12-00-00.log"
    path.write_text("\ufeff\n[Log 7]\nFree RAM: 1200\n" + "\n".join(lines), encoding="utf-8")
    contents = load(path, everything)
    np.testing.assert_allclose(field_of(contents), one.field_nT, atol=1.1 * HALF_STEP_NT)
    np.testing.assert_allclose(contents.table["time_s"].to_numpy(), one.time_s, atol=1e-3)
    phases = contents.table["phase"].to_pylist()
    assert [phases[0], phases[-1], phases.index("poshold")] == ["loiter", "poshold", 30]


def test_other_text_is_no_log_of_ardupilot(tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text("FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n")
    assert "no whole message" in refusal(tmp_path / "a.log")
    (tmp_path / "b.log").write_text("# FMT of a table\ntime_s,mag_x_nT,mag_y_nT,mag_z_nT\n0,1,2,3\n1,2,3,4\n")
    assert load(tmp_path / "b.log", everything).table.num_rows == 2


def test_a_log_too_long_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_text(flight_log(flight(20)), tmp_path / "flight.log")
    for name in ("MOST_BYTES", "MOST_LINES"):
        with monkeypatch.context() as patched:
            patched.setattr(text_log, name, 100)
            with pytest.raises(InputError, match="is a log as text of more than"):
                load(path, everything)
    monkeypatch.setattr(text_log, "CHUNK", 7)
    assert load(path, everything).table.num_rows == 20


@DAMAGED_FILES
def test_damaged_logs_are_read_or_refused(files: int, tmp_path: Path) -> None:
    path = write_text(flight_log(flight(8)), tmp_path / "flight.log")
    whole, rng = np.frombuffer(path.read_bytes(), np.uint8), np.random.default_rng(6)
    for trial in range(files):
        damaged = whole[: rng.integers(1, len(whole))] if trial % 3 == 0 else whole.copy()
        if trial % 3:
            hit = rng.random(len(damaged)) < 10.0 ** rng.uniform(-4, -1)
            damaged = np.where(hit, rng.choice(np.frombuffer(b"0123456789-.e,\n\xff\x00 nanifF", np.uint8)), damaged)
        path.write_bytes(damaged.tobytes())
        said = refusal(path)
        assert not said or (said.startswith(str(path)) and "\n" not in said)
    assert vectors(load(write_text(flight_log(flight(8)), path), everything), "mag_").shape == (8, 3)
