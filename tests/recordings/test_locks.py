"""One process writes a file or a directory at a time, and the lock is gone with its process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from recordings import locks
from recordings.files import atomic_write, locked_directory
from scenarios.errors import InputError


@pytest.mark.parametrize("what", ["directory", "file"])
@pytest.mark.parametrize("windows", [False, True])
def test_what_another_process_writes_is_refused(
    tmp_path: Path, what: str, windows: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two descriptors of one process exclude each other as two processes do."""
    monkeypatch.setattr(locks, "ON_WINDOWS", windows)
    hold = locked_directory if what == "directory" else atomic_write
    with hold(tmp_path / "x") as part:
        if part is not None:
            part.write_text("first")
        with pytest.raises(InputError, match=r"x: another magbench is writing"), hold(tmp_path / "x"):
            pass
    assert what == "directory" or (tmp_path / "x").read_text() == "first"
    assert not (tmp_path / "x.magbench-part").exists()


@pytest.mark.parametrize("windows", [False, True])
def test_a_locked_directory_lists_what_is_written_alone(
    tmp_path: Path, windows: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On Windows the lock is a file beside the directory, which the system removes."""
    monkeypatch.setattr(locks, "ON_WINDOWS", windows)
    monkeypatch.chdir(tmp_path)
    for out in (tmp_path / "out", Path("out"), Path("out/../out")):
        with locked_directory(out):
            (out / "mine").write_text("kept")
            assert os.listdir(out) == ["mine"]
    with locked_directory(tmp_path / "stays-empty"):
        pass
    beside = {"out.magbench-lock", "stays-empty.magbench-lock"} if windows else set()
    assert set(os.listdir(tmp_path)) == {"out", *beside}  # here no O_TEMPORARY removes it


def test_the_lock_of_a_killed_process_is_free(tmp_path: Path) -> None:
    script = """
import sys, time
from pathlib import Path
from recordings.files import locked_directory
with locked_directory(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""
    command = [sys.executable, "-c", script, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        with pytest.raises(InputError, match="another magbench is writing here"), locked_directory(tmp_path):
            pass
        process.kill()
        process.wait()
    with locked_directory(tmp_path):
        assert os.listdir(tmp_path) == []


def test_a_file_system_without_locks_goes_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(descriptor: int, *, blocking: bool) -> bool:
        raise OSError("no locks available")

    monkeypatch.setattr("filelock.lock_descriptor", refuse)
    with locked_directory(tmp_path / "x"), locked_directory(tmp_path / "x"):
        pass


def test_directory_that_goes_between_making_and_locking_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The one before leaves it empty and removes it, twice before we have opened it, twice before we hold its lock."""
    out, left = tmp_path / "out", {"open": 2, "lock": 2}

    def removing(name: str, call: Any) -> Any:
        def wrapped(*arguments: Any) -> Any:
            if out.exists() and left[name]:
                left[name] -= 1
                out.rmdir()
            return call(*arguments)

        return wrapped

    monkeypatch.setattr(locks.os, "open", removing("open", os.open))
    monkeypatch.setattr(locks, "_taken", removing("lock", locks._taken))
    with locked_directory(out):
        monkeypatch.undo()
        assert left == {"open": 0, "lock": 0}
        (out / "mine").write_text("kept")
    assert (out / "mine").read_text() == "kept"
