"""The ULog container: against pyulog, and with damage, ends and sizes that no log should have."""

from __future__ import annotations

import contextlib
import io
import resource
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ulog_bytes import MAGIC, SYNC, TopicOf, UlogOf, message, xyz

from recordings import read_recording
from recordings.readers import load
from recordings.readers.px4.ulog import read_ulog
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES

T = 5.0 + np.arange(60) * 0.1
MAG = xyz(np.column_stack([0.2 + 0.1 * np.sin(T), 0.1 * np.cos(T), 0.4 + 0.02 * T]))
TOPICS = (
    TopicOf("sensor_mag", T, {"device_id": ("uint32_t", np.full(60, 197388))} | MAG, padding=4),
    TopicOf("sensor_mag", T, MAG | {"device_id": ("uint32_t", np.full(60, 7))}, instance=1),
    TopicOf("vehicle_attitude", T, {"q": ("float", np.tile([1, 0, 0, 0.5], (60, 1)))}),
    TopicOf("vehicle_status", T[::10], {"nav_state": ("uint8_t", np.arange(6)), "wide": ("double", T[::10])}),
)
"""The second sensor_mag takes the format of the first by name, so both have the same fields in one order."""
LOG = UlogOf(TOPICS[:1] + TOPICS[2:], {"CAL_MAG0_ID": 197388, "CAL_MAG0_XOFF": 0.3}, [(7.02, "CAL_MAG0_XOFF", 0.4)])
HEADER = struct.pack("<7sBQ", MAGIC, 1, 0)


def log_file(tmp_path: Path, data: bytes) -> Path:
    (tmp_path / "log.ulg").write_bytes(data)
    return tmp_path / "log.ulg"


def assert_like_pyulog(path: Path) -> None:
    """Topics, columns, parameters and their changes, as the format's own library reads them."""
    pyulog = pytest.importorskip("pyulog")
    expected, found = pyulog.ULog(io.BytesIO(path.read_bytes())), read_ulog(path)
    assert found.parameters == expected.initial_parameters
    assert [(one.name, one.value) for one in found.changes] == [one[1:] for one in expected.changed_parameters]
    assert found.topics.keys() == {(one.name, one.multi_id) for one in expected.data_list}
    for one in expected.data_list:
        topic = found.topics[one.name, one.multi_id]
        kinds = {each.field_name: each.type_str for each in one.field_data}
        assert set(topic.names) == {name for name, kind in kinds.items() if kind != "char" and "_padding" not in name}
        for name in topic.names:
            np.testing.assert_array_equal(topic.column(name), one.data[name], err_msg=f"{one.name}.{name}")


def test_a_written_log_is_read_as_by_pyulog(tmp_path: Path) -> None:
    assert_like_pyulog(log_file(tmp_path, LOG.bytes()))


@pytest.mark.parametrize("name", ["px4-sample", "px4-long-sparse", "px4-events"])
def test_real_logs_are_read_as_by_pyulog(name: str, realdata: Path, tmp_path: Path) -> None:
    assert_like_pyulog(log_file(tmp_path, (realdata / "native" / f"{name}.ulg").read_bytes()))


@pytest.mark.parametrize(
    ("name", "strength_nT", "place"),
    [
        ("px4-sample", 48_300, None),
        ("px4-long-sparse", 44_600, (63.417, 10.408, 103.9)),
        ("px4-events", 48_100, (47.3977, 8.5456, 488.0)),
    ],
)
def test_real_logs_of_three_ages(name: str, strength_nT: float, place: Any, realdata: Path) -> None:
    """The calibration that was undone, applied again, gives PX4's field; gravity and the dip have their signs."""
    contents = load(realdata / "native" / f"{name}.ulg", lambda column: True)
    m, up = (
        np.column_stack([contents.table[column.format(axis)].to_numpy() for axis in "xyz"])
        for column in ("mag_{}_nT", "accel_{}_m_s2")
    )
    applied = contents.applied[contents.magnetometer]
    field = (m - applied.offset_nT) @ applied.matrix.T
    assert np.median(np.linalg.norm(field, axis=1)) == pytest.approx(strength_nT, rel=0.03)
    assert np.median(up[:, 2]) == pytest.approx(9.8, abs=0.3)
    if name != "px4-long-sparse":  # its magnetometer is mounted otherwise than its parameters say
        assert np.median(np.sum(field * up, axis=1)) < 0
    assert contents.place == (pytest.approx(place, abs=0.05) if place else None)


def test_a_cut_off_log_gives_the_samples_before(tmp_path: Path) -> None:
    whole = LOG.bytes()
    contents = load(log_file(tmp_path, whole[: len(whole) * 2 // 3]), lambda name: True)
    assert 20 < contents.table.num_rows < 60
    assert any("cut off" in note for note in contents.notes)


@pytest.mark.parametrize("sync", [b"", message("S", SYNC)], ids=["without a mark", "with a mark"])
def test_a_damaged_stretch_is_skipped(sync: bytes, tmp_path: Path) -> None:
    """Noise before a sample: the samples behind are read."""
    whole = LOG.bytes()
    sample = whole.index(message("S", SYNC)) + len(message("S", SYNC))
    noise = bytes(np.random.default_rng(2).integers(128, 256, 300, np.uint8))
    log = read_ulog(log_file(tmp_path, whole[:sample] + noise + sync + whole[sample:]))
    assert len(log.topics["sensor_mag", 0]) == 60
    assert log.damaged == 300 + len(sync)


def test_a_sample_of_another_length_is_damage(tmp_path: Path) -> None:
    whole = LOG.bytes()
    start = whole.index(message("S", SYNC))
    log = read_ulog(log_file(tmp_path, whole[:start] + message("D", bytes(2) + bytes(range(100))) + whole[start:]))
    assert len(log.topics["sensor_mag", 0]) == 60
    assert log.damaged > 100


def test_data_that_were_appended_after_a_crash(tmp_path: Path) -> None:
    """The flags give the offset at which messages begin anew behind a message that was cut off."""
    whole = bytearray(LOG.bytes())
    cut = len(whole) - 3
    appended = whole[:cut] + message("P", bytes([12]) + b"int32_t TAIL" + struct.pack("<i", 5))
    appended[19:59] = struct.pack("<8s8s3Q", bytes(8), b"\x01" + bytes(7), cut, 0, 0)
    log = read_ulog(log_file(tmp_path, bytes(appended)))
    assert log.changes[-1].name == "TAIL"
    appended[27] = 2
    with pytest.raises(InputError, match="features that are not known"):
        read_ulog(log_file(tmp_path, bytes(appended)))


def _nested(depth: int, width: int) -> bytes:
    """Formats of arrays of arrays, which a reader that makes all their fields has no memory for."""
    formats = [message("F", f"f0:uint64_t timestamp;f1[{width}] x;".encode())]
    formats += [message("F", f"f{k}:f{k + 1}[{width}] x;".encode()) for k in range(1, depth)]
    return HEADER + b"".join(formats) + message("F", f"f{depth}:float x;".encode()) + message("A", b"\0\0\0f0")


def _of(fields: str, times: int = 1) -> bytes:
    """A topic of these fields beside its time, added several times."""
    added = (message("A", struct.pack("<BH", 0, k) + b"a") for k in range(times))
    return HEADER + message("F", f"a:uint64_t timestamp;{fields}".encode()) + b"".join(added)


HOSTILE: dict[str, Callable[[], bytes]] = {
    "a format that names itself": lambda: _of("a x;"),
    "deep arrays": lambda: _nested(6, 60_000),
    "wide arrays of nothing": lambda: _nested(7, 99_999).replace(b":float x;", b":;"),
    "fields of one name": lambda: _of("int8_t x;int8_t x;"),
    "many topics": lambda: _of("float[4000] x;", 60_000),
    "a size behind the end": lambda: HEADER + struct.pack("<HB", 60_000, 0x58) + bytes(50),
    "a header alone": lambda: HEADER,
    "zeros": lambda: HEADER + bytes(3_000_000),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_files_are_refused_in_one_line_and_little_memory(what: str, tmp_path: Path) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    path = log_file(tmp_path, HOSTILE[what]())
    with pytest.raises(InputError) as caught:
        read_recording(path)
    assert "\n" not in str(caught.value)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000  # kB


@DAMAGED_FILES
def test_damaged_logs_are_read_or_refused(files: int, tmp_path: Path) -> None:
    """Bytes replaced at several rates, stretches removed and repeated, ends cut off."""
    whole, rng = np.frombuffer(LOG.bytes(), np.uint8), np.random.default_rng(7)
    for k in range(files):
        data = whole.copy()
        start, stop = np.sort(rng.integers(0, len(data), 2))
        if k % 3 == 0:
            hit = rng.random(len(data)) < 10.0 ** rng.uniform(-4, -0.5)
            data = np.where(hit, rng.integers(0, 256, len(data), np.uint8), data)
        elif k % 3 == 1:
            data = np.r_[data[:start], data[stop:]]
        else:
            data = np.r_[data[:stop], data[start : rng.integers(start, len(data) + 1)]]
        data[: len(MAGIC)] = whole[: len(MAGIC)]
        path = log_file(tmp_path, data.astype(np.uint8).tobytes())
        with contextlib.suppress(InputError):
            read_recording(path)


def test_a_file_of_messages_without_samples_is_no_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("recordings.readers.px4.ulog.MOST_OTHERS", 1000)
    with pytest.raises(InputError, match=r"log\.ulg: holds more than 1000 messages that are no samples"):
        read_ulog(log_file(tmp_path, LOG.bytes() + message("S", SYNC) * 1000))
