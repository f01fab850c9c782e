"""Programs as calibrators: what they are told, what they may answer, and that a bad one costs its own fit alone."""

from __future__ import annotations

import json
import os
import pickle
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from calib import Calibration, Reference
from recordings import Recording, read_recording
from scenarios.errors import InputError
from validation.calibrating import program
from validation.calibrating.calibrator_entry import CalibratorEntry
from validation.calibrating.external_command import parse_command
from validation.calibrating.selection import select_calibrators

IDENTITY = '{"offset_nT": [1, 2, 3], "matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}'
Script = Callable[..., CalibratorEntry]


@pytest.fixture
def script(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Script:
    """A candidate that is a shell script with this text; its first word is the recording, its second the result."""
    monkeypatch.chdir(tmp_path)

    def write(text: str, words: str = "{recording.csv} {result}", time_limit_s: float = 20.0) -> CalibratorEntry:
        Path("mycal.sh").write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
        Path("mycal.sh").chmod(0o755)
        return select_calibrators((), [f"./mycal.sh {words}"], time_limit_s)[0]

    return write


def test_the_answer_is_the_programs_with_its_time(script: Script, recording: Recording, reference: Reference) -> None:
    spin = "i=0; while [ $i -lt 20000 ]; do i=$((i+1)); done"
    found = script(f"{spin}; echo '{IDENTITY}' > $2").fit_timed(recording, reference)
    assert (found.calibration.name, found.calibration.status.kind) == ("mycal", "ok")
    np.testing.assert_array_equal(found.calibration.offset_nT, [1.0, 2.0, 3.0])
    assert found.cpu_s > 0.0
    assert 0.0 < found.calibration.wall_s < 20.0


def test_a_program_is_told_all_that_is_known(
    script: Script, recording: Recording, reference: Reference, tmp_path: Path
) -> None:
    words = "{recording} {recording.csv} {field_strength_nT} {field_enu_nT} {seed}"
    told = f'cp "$@" reference.json {tmp_path} 2>/dev/null; env > {tmp_path}/env; echo "$@" > {tmp_path}/words; false'
    script(told, f"{words} {{result}}").fit(recording, reference, np.random.default_rng(5))
    parquet, table, strength, vector, seed, _ = (tmp_path / "words").read_text().split()
    assert (float(strength), [float(one) for one in vector.split(",")]) == (50_000.0, [0.0, 30_000.0, -40_000.0])
    values = {"field_strength_nT": 50_000.0, "field_enu_nT": [0.0, 30_000.0, -40_000.0], "seed": int(seed)}
    assert json.loads((tmp_path / "reference.json").read_text()) == values
    variables = dict(line.split("=", 1) for line in (tmp_path / "env").read_text().splitlines() if "=" in line)
    assert (variables["MAGBENCH_FIELD_STRENGTH_NT"], variables["MAGBENCH_FIELD_ENU_NT"]) == (strength, vector)
    assert variables["MAGBENCH_SEED"] == seed
    for file in (parquet, table):
        copied = read_recording(tmp_path / Path(file).name)
        np.testing.assert_allclose(copied.mag_nT, recording.mag_nT)
    assert pq.read_table(tmp_path / "recording.parquet").num_rows == len(recording)
    assert not os.path.exists(parquet)


def test_the_seed_is_the_trials(script: Script, recording: Recording, reference: Reference) -> None:
    seeded = IDENTITY.replace("}", ', "parameters": {"seed": %s}}')
    candidate = script(f"printf '{seeded}' $MAGBENCH_SEED > $2")
    drawn = [candidate.fit(recording, reference, np.random.default_rng(k)).parameters["seed"] for k in (1, 1, 2)]
    assert drawn[0] == drawn[1] != drawn[2]


def test_the_vector_makes_a_command_one_with_attitude(script: Script, recording: Recording) -> None:
    blind, seeing = script("false"), script("false", "{recording} {result} {field_enu_nT}")
    assert (blind.attitude_free, seeing.attitude_free) == (True, False)
    assert seeing.fit(recording, Reference(50_000.0)).status.kind == "not_applicable"
    assert pickle.loads(pickle.dumps(seeing)) == seeing


def failed(candidate: CalibratorEntry, recording: Recording, reference: Reference, place: Path) -> Calibration:
    """The failed calibration; the program left nothing behind where it was started."""
    before = sorted(place.iterdir())
    found = candidate.fit(recording, reference)
    assert found.status.kind == "not_converged"
    np.testing.assert_array_equal(found.matrix, np.eye(3))
    assert sorted(place.iterdir()) == before
    assert "\n" not in found.status.reason
    assert "/magbench-" not in found.status.reason, "a path of its own makes a reason differ from run to run"
    return found


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("echo no pivot in column 2 >&2; exit 3", "exit status 3; it said: no pivot in column 2"),
        ("true", "wrote no result"),
        ("kill -SEGV $$", "SIGSEGV"),
        ("echo nonsense > $2", "not JSON"),
        ("head -c 200 /dev/urandom > $2", "result.json: not"),
        ('echo \'{"offset_nT": [1, 2, NaN], "matrix": []}\' > $2', "NaN"),
        (f"echo '{IDENTITY}' | sed 's/1, 0, 0/0, 0, 0/' > $2", "singular"),
        ("mkfifo $2", "pipe"),
        ("ln -s /dev/zero $2", "no file"),
        ("mkdir $2", "directory"),
        (f"echo '{IDENTITY}' > $2; exit 1", "exit status 1"),
        ("rm $1; cd /; rm -r $OLDPWD; kill -9 $$", "SIGKILL"),
        ("printf 'caf\\351\\033[31m\\n'; exit 1", "it said: caf"),
    ],
)
def test_a_program_that_fails_says_why(
    text: str, told: str, script: Script, recording: Recording, reference: Reference, tmp_path: Path
) -> None:
    assert told in failed(script(text), recording, reference, tmp_path).status.reason


@pytest.mark.parametrize("text", ["sleep 60", "trap '' TERM INT HUP; sleep 60; sleep 60", "kill -STOP $$"])
def test_a_program_that_hangs_is_ended(
    text: str, script: Script, recording: Recording, reference: Reference, tmp_path: Path
) -> None:
    begun_s = time.monotonic()
    found = failed(script(text, time_limit_s=0.3), recording, reference, tmp_path)
    assert found.status.reason == "stopped at the time limit"
    assert time.monotonic() - begun_s < 30.0


SLEEPER = "/bin/sh -c 'echo $$ > %s/pid; exec sleep 77' >/dev/null 2>&1 </dev/null"


@pytest.mark.parametrize(
    "start",
    ["", "/usr/bin/setsid", "env -i /usr/bin/setsid", "env -i /bin/sh -c '/usr/bin/setsid \"$@\" & exit' sh"],
    ids=["beside it", "session of its own", "environment of its own", "adopted by init"],
)
def test_what_a_program_leaves_running_is_ended(
    start: str, script: Script, recording: Recording, reference: Reference, tmp_path: Path
) -> None:
    found = script(f"{start} {SLEEPER % tmp_path} &\nsleep 0.3; echo '{IDENTITY}' > $2").fit(recording, reference)
    assert found.status.kind == "ok"
    assert not alive(int((tmp_path / "pid").read_text()))


def alive(process: int) -> bool:
    """Whether a process runs; one that has ended and waits for its parent does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("yes", "SIGXFSZ"),
        ("for i in 1 2 3 4 5; do head -c 900000 /dev/zero > big$i; done; sleep 60", "wrote more than"),
        ("i=0; while [ $i -lt 300 ]; do i=$((i+1)); : > f$i; done; sleep 60", "wrote more than"),
        ("head -c 900000 /dev/zero | tr '\\000' ' ' > $2", "longer than a calibration"),
    ],
)
def test_a_program_that_fills_the_disk_is_ended(
    text: str, told: str, script: Script, recording: Recording, reference: Reference, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(program, "MAX_FILE_BYTES", 2**20)
    monkeypatch.setattr(program, "MAX_DISK_BYTES", 2**21)
    monkeypatch.setattr(program, "MAX_FILES", 200)
    monkeypatch.setattr("validation.calibrating.external_command.MAX_RESULT_BYTES", 2**19)
    begun_s = time.monotonic()
    reason = failed(script(text, time_limit_s=40.0), recording, reference, tmp_path).status.reason
    assert told in reason
    assert time.monotonic() - begun_s < 30.0


def test_a_program_of_many_words_finds_the_files_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recording: Recording, reference: Reference
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "answer.json").write_text(IDENTITY)
    (tmp_path / "copy.sh").write_text("cp $1 $3")
    (candidate,) = select_calibrators((), ["mine=sh copy.sh answer.json {recording.csv} {result}"])
    monkeypatch.chdir("/")
    assert candidate.fit(recording, reference).status.kind == "ok"
    assert candidate.name == "mine"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("./nowhere {recording} {result}", "no such program"),
        ("sh 'x {recording} {result}", "No closing quotation"),
        ("sh {recroding} {result}", "known are {recording}"),
        ("sh {recording}", "where it writes the result"),
        ("sh {result}", "finds the recording"),
        ("", "finds the recording"),
        ("./plain.txt {recording} {result}", "may not be run"),
    ],
)
def test_a_text_that_cannot_be_run_is_refused_at_once(
    text: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plain.txt").write_text("hello")
    with pytest.raises(InputError, match=told):
        parse_command(text, 1.0)


def test_a_program_that_has_changed_is_another_candidate(script: Script) -> None:
    before, same, after = script("true"), script("true"), script("false")
    assert before == same
    assert repr(before) != repr(after)


def test_words_are_split_and_braces_of_others_are_left_alone() -> None:
    found = parse_command("sh -c 'echo \"$1\"' x {recording.csv} --out={result} '{\"a\": 1}'", 1.0)
    assert found.words == ("sh", "-c", 'echo "$1"', "x", "{recording.csv}", "--out={result}", '{"a": 1}')
