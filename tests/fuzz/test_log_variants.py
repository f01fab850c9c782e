"""Damaged logs in the other forms of a format: directories, their metadata, JSON of a phone, MATLAB's newest files."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import strategies as st
from rosbags.rosbag2 import StoragePlugin

from recordings.reading import kept_file
from tests.fuzz.contract import amounts, fuzz
from tests.fuzz.tables import Bytes, broken_bytes
from tests.fuzz.test_native_logs import COMMANDS, asked, place  # noqa: F401
from tests.fuzz.test_scenarios import VALUES
from tests.fuzz.values import damaged_json
from tests.recordings.readers.ros_bags import Series, vector, write_bag
from tests.recordings.readers.swing import swing
from tests.recordings.readers.test_mat import newest
from tests.recordings.readers.test_phone import START_NS, android, unpack
from tests.recordings.readers.test_phone_forms import exported, pushed

CASES, KEPT = 12, 40
"""Cases of each form, and of options that are kept beside a log, in the normal run."""
OF = swing(120)
ROWS = 160
"""Rows of a phone's JSON: forty of each sensor."""


def bag(path: Path, storage: StoragePlugin) -> Path:
    """A ROS 2 bag: a directory of one file, and its metadata."""
    stamps = [START_NS + round(1e9 * t) for t in OF.time_s.tolist()]
    field = [{"magnetic_field": vector(1e-9 * row)} for row in OF.mag_nT]
    write_bag(path, [Series("/mag", "sensor_msgs/msg/MagneticField", field, stamps)], storage=storage)
    return path


FORMS: dict[str, Callable[[Path], Path]] = {
    "ROS 2, MCAP": lambda to: bag(to / "log", StoragePlugin.MCAP),
    "ROS 2, SQLite": lambda to: bag(to / "log", StoragePlugin.SQLITE3),
    "phone's directory": lambda to: unpack(to / "log", android(OF)),
    "MATLAB 7.3": lambda to: newest(to / "log.mat", OF),
}
JSON: dict[str, Any] = {
    "exported": json.loads(exported())[:ROWS],
    "pushed": (whole := json.loads(pushed())) | {"payload": whole["payload"][:ROWS]},
}
OPTIONS = """mag = ["bx", "by", "bz"]
unit = "uT"
axes = "y,x,-z"
frame = "frd"
place = [47.4, 8.5, 400.0]
date = 2024-05-01
stream = "mag"
maps = ["current_1_A=wheel"]
"""


@dataclass(frozen=True)
class Case:
    """One to three things done to the bytes of a form's files, each to one of the files, and the command."""

    broken: tuple[tuple[int, Bytes], ...]
    command: str


@pytest.fixture
def whole_log(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log in a form, whole."""
    return FORMS[request.param](tmp_path_factory.mktemp("whole"))


@amounts
@pytest.mark.parametrize("whole_log", FORMS, indirect=True)
def test_damaged_files(whole_log: Path, place: Path, times: int) -> None:  # noqa: F811
    log = place / whole_log.name

    def check(case: Case) -> None:
        copied(whole_log, log)
        files = sorted(path for path in (log, *log.rglob("*")) if path.is_file())
        for number, broken in case.broken:
            file = files[number % len(files)]
            file.write_bytes(broken.to(file.read_bytes() or b"\x00"))
        asked(place, log, case.command)

    damages = st.lists(st.tuples(st.integers(0, 20), broken_bytes), min_size=1, max_size=3).map(tuple)
    fuzz(st.builds(Case, damages, st.sampled_from(list(COMMANDS))), check, CASES, times)


def copied(whole: Path, log: Path) -> None:
    """A fresh copy of a file or a directory."""
    if whole.is_file():
        shutil.copy(whole, log)
        return
    shutil.rmtree(log, ignore_errors=True)
    shutil.copytree(whole, log)


@amounts
@pytest.mark.parametrize("form", JSON)
def test_values_of_a_phones_json(form: str, place: Path, times: int) -> None:  # noqa: F811
    log = place / "log.json"

    def check(case: tuple[str, str]) -> None:
        log.write_text(case[0], encoding="utf-8", errors="surrogateescape")
        asked(place, log, case[1])

    fuzz(st.tuples(damaged_json(JSON[form]), st.sampled_from(list(COMMANDS))), check, CASES, times)


def test_a_stamp_of_four_hundred_digits(place: Path) -> None:  # noqa: F811
    rows = [dict(row) for row in JSON["exported"]]
    for row in rows:
        if row["sensor"] == "Gyroscope":
            del row["seconds_elapsed"]
            row["time"] = 10**400
    (place / "log.json").write_text(json.dumps(rows))
    assert asked(place, place / "log.json", "inspect") in (0, 2)


@pytest.fixture
def csv_log(place: Path) -> Path:  # noqa: F811
    """A log whose columns the kept options name."""
    lines = [f"{t},{x},{y},{z},{k}" for k, (t, (x, y, z)) in enumerate(zip(OF.time_s, OF.mag_nT / 1e3, strict=True))]
    (place / "log.csv").write_text("\n".join(["t,bx,by,bz,wheel", *lines]) + "\n")
    return place / "log.csv"


@amounts
def test_options_that_are_kept_beside_a_log(place: Path, csv_log: Path, times: int) -> None:  # noqa: F811
    kept = kept_file(csv_log)

    def check(case: tuple[list[tuple[int, str]], str]) -> None:
        lines = OPTIONS.splitlines()
        for at, value in case[0]:
            key, equals, _ = lines[at % len(lines)].partition(" = ")
            lines[at % len(lines)] = f"{key} = {value}" if equals else value
        kept.write_text("\n".join(lines))
        asked(place, csv_log, case[1])

    changes = st.lists(st.tuples(st.integers(0, 20), st.sampled_from(VALUES)), min_size=1, max_size=3)
    fuzz(st.tuples(changes, st.sampled_from(list(COMMANDS))), check, KEPT, times)


@pytest.mark.parametrize(
    "line",
    [
        *("mag = [1, 2, 3]", "maps = [1]", "mag = 5", "stream = 5", "stream = [1]", "unit = [1]", "frame = {}"),
        *(
            f"place = [{'9' * 400}, 0.0]",
            "place = [nan, 0.0]",
            "date = 12:00:00",
            "date = 5",
            "axes = [[1]]",
            "other = 1",
        ),
    ],
)
def test_options_of_other_types(line: str, place: Path, csv_log: Path) -> None:  # noqa: F811
    kept_file(csv_log).write_text(line + "\n")
    assert asked(place, csv_log, "inspect") == 2
