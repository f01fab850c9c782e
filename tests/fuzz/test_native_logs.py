"""Damaged logs of every format that magbench reads, given to the commands that read logs."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import strategies as st

from recordings import write_recording
from tests.fuzz.contract import amounts, fuzz, hold
from tests.fuzz.material import CALIBRATION
from tests.fuzz.tables import Bytes, broken_bytes
from tests.recordings.readers.test_contract import EXAMPLES, FORMATS, FileFormat, formats, recording

CASES = 8
"""Cases of each format in the normal run."""
FIELD = ("--field-strength-nT", "44721")
COMMANDS: dict[str, tuple[str, ...]] = {
    "inspect": ("inspect", "LOG", "--json"),
    "read": ("read", "LOG", "-o", "OUT/read.parquet"),
    "calibrate": ("calibrate", "LOG", "--with", "sphere", "-o", "OUT/c", "--json", *FIELD),
    "apply": ("apply", "CALIBRATION", "LOG", "-o", "OUT/corrected.parquet"),
    "recheck": ("recheck", "CALIBRATION", "LOG", "--json", *FIELD),
    "bound": ("bound", "LOG", "--json", *FIELD),
}


@dataclass(frozen=True)
class Case:
    """One to three things done to a log's bytes, and the command that is given the log."""

    broken: tuple[Bytes, ...]
    command: str


@pytest.fixture
def place(tmp_path: Path) -> Iterator[Path]:
    """A directory with a calibration and a whole log; `out` in it is what a command may write."""
    (tmp_path / "calibration.json").write_text(json.dumps({"ellipsoid": CALIBRATION["ellipsoid"]}))
    write_recording(recording(), tmp_path / "whole.parquet")
    yield tmp_path
    shutil.rmtree(tmp_path)


def asked(place: Path, log: Path, command: str) -> int:
    """Give a log to a command, hold it to the contract, return the status; a refusal leaves nothing."""
    out = place / "out"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    words = {"LOG": str(log), "CALIBRATION": str(place / "calibration.json")}
    status = hold(out, *(words.get(word, word.replace("OUT", str(out))) for word in COMMANDS[command]))
    if status == 2:
        assert [path for path in out.rglob("*") if path.is_file()] == []
    return status


def cases() -> st.SearchStrategy[Case]:
    """Any damage, and any command."""
    return st.builds(Case, st.lists(broken_bytes, min_size=1, max_size=3).map(tuple), st.sampled_from(list(COMMANDS)))


@amounts
@formats
def test_damaged_logs(form: FileFormat, place: Path, times: int) -> None:
    log = place / f"log{form.suffixes[0]}"
    EXAMPLES[form.name](recording(), log)
    whole = log.read_bytes()

    def check(case: Case) -> None:
        content = whole
        for one in case.broken:
            content = one.to(content)
        log.write_bytes(content)
        asked(place, log, case.command)

    fuzz(cases(), check, CASES, times)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_log_of_nothing(place: Path, command: str) -> None:
    for form in FORMATS:
        log = place / f"log{form.suffixes[0]}"
        log.write_bytes(b"")
        assert asked(place, log, command) == 2
