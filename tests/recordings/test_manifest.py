"""A dataset is begun, interrupted, resumed, grown and refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from recordings import columns, finish_dataset, open_dataset_for_writing, read_manifest, resume, run_file, run_path
from recordings.files import sha256_of
from scenarios.errors import InputError

TABLE = columns(motors=(1, 2), effects=("soft_iron", "hard_iron", "white_noise"))


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "deep" / "out"


def write_runs(make_run: Any, out: Path, runs: list[int], seed: int = 7) -> None:
    for run in runs:
        make_run(n=60, seed=run).write(run_path(out, run), seed=seed, run=run)


def everything(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


def test_begun_and_finished(out: Path, make_run: Any, scenario: dict[str, Any]) -> None:
    assert open_dataset_for_writing(out, scenario, 7, 2, TABLE) == [0, 1]
    begun = read_manifest(out)
    assert (begun.complete, begun.files, begun.seed, begun.runs) == (False, (), 7, 2)
    write_runs(make_run, out, [0, 1])
    done = finish_dataset(out, [run_file(run_path(out, 0), 0)])
    assert read_manifest(out) == done
    assert done.complete
    assert done.scenario == scenario
    assert done.columns == TABLE
    for run, entry in enumerate(done.files):
        path = out / entry.path
        assert (entry.run, entry.rows, entry.bytes) == (run, 60, path.stat().st_size)
        assert entry.sha256 == sha256_of(path)
    assert {"numpy", "mujoco-core", "magbench"} < set(done.packages)


def test_same_command_gives_the_same_bytes_even_when_interrupted(
    tmp_path: Path, make_run: Any, scenario: dict[str, Any]
) -> None:
    straight, broken = tmp_path / "a", tmp_path / "b"
    for directory, parts in ((straight, [[0, 1, 2]]), (broken, [[1], [0, 2]])):
        for part in parts:
            open_dataset_for_writing(directory, scenario, 7, 3, TABLE)
            write_runs(make_run, directory, part)
        finish_dataset(directory)
    assert everything(straight) == everything(broken)


def test_resumed_after_a_kill(out: Path, make_run: Any, scenario: dict[str, Any]) -> None:
    open_dataset_for_writing(out, scenario, 7, 4, TABLE)
    write_runs(make_run, out, [0, 1, 2])
    (out / "run-00003.parquet.magbench-part").write_bytes(b"PAR1 cut off")
    (out / "dataset.json.magbench-part").write_bytes(b"{")
    run_path(out, 1).write_bytes(run_path(out, 1).read_bytes()[:-50])
    assert open_dataset_for_writing(out, scenario, 7, 4, TABLE) == [1, 3]
    assert not list(out.glob("*.magbench-part"))


@pytest.mark.parametrize(("seed", "run"), [(8, 0), (7, 1)])
def test_run_of_another_seed_or_number_is_done_again(
    out: Path, make_run: Any, scenario: dict[str, Any], seed: int, run: int
) -> None:
    open_dataset_for_writing(out, scenario, 7, 1, TABLE)
    make_run(n=60).write(run_path(out, 0), seed=seed, run=run)
    assert open_dataset_for_writing(out, scenario, 7, 1, TABLE) == [0]


def test_foreign_parquet_under_the_name_of_a_run_is_done_again(
    out: Path, make_run: Any, scenario: dict[str, Any], tmp_path: Path
) -> None:
    open_dataset_for_writing(out, scenario, 7, 2, TABLE)
    run_path(out, 0).mkdir()
    run_path(out, 1).write_bytes(b"")
    assert open_dataset_for_writing(out, scenario, 7, 2, TABLE) == [0, 1]


def test_runs_may_grow_but_not_shrink(out: Path, make_run: Any, scenario: dict[str, Any]) -> None:
    open_dataset_for_writing(out, scenario, 7, 1, TABLE)
    write_runs(make_run, out, [0])
    finish_dataset(out)
    assert open_dataset_for_writing(out, scenario, 7, 3, TABLE) == [1, 2]
    assert [entry.run for entry in read_manifest(out).files] == [0]
    with pytest.raises(InputError, match="holds a dataset of 3 runs, 1 were asked for"):
        open_dataset_for_writing(out, scenario, 7, 1, TABLE)


def test_file_that_is_not_the_listed_one_is_told_and_done_again(
    out: Path, make_run: Any, scenario: dict[str, Any]
) -> None:
    """Its footer still says that it is this run; only the hash tells."""
    open_dataset_for_writing(out, scenario, 7, 3, TABLE)
    write_runs(make_run, out, [0, 1, 2])
    finish_dataset(out)
    make_run(n=60, seed=99).write(run_path(out, 1), seed=7, run=1)
    told: list[str] = []
    assert open_dataset_for_writing(out, scenario, 7, 3, TABLE, told.append) == [1]
    assert told == [f"{out}: not the files that dataset.json lists, so made anew: run-00001.parquet"]
    assert [entry.run for entry in read_manifest(out).files] == [0, 2]


def test_finished_dataset_asks_for_nothing(out: Path, make_run: Any, scenario: dict[str, Any]) -> None:
    open_dataset_for_writing(out, scenario, 7, 2, TABLE)
    write_runs(make_run, out, [0, 1])
    finish_dataset(out)
    before = everything(out)
    assert open_dataset_for_writing(out, scenario, 7, 2, TABLE) == []
    finish_dataset(out)
    assert everything(out) == before


def test_other_scenario_is_refused_and_nothing_touched(out: Path, make_run: Any, scenario: dict[str, Any]) -> None:
    open_dataset_for_writing(out, scenario, 7, 1, TABLE)
    (out / "run-00000.parquet.magbench-part").write_bytes(b"in work")
    before = everything(out)
    other = json.loads(json.dumps(scenario))
    other["effects"]["hard_iron"]["x_nT"] = 500.0
    with pytest.raises(InputError) as caught:
        open_dataset_for_writing(out, other, 7, 1, TABLE)
    assert "scenario.effects.hard_iron.x_nT is 300.0 there and 500.0 here (choose another" in str(caught.value)
    with pytest.raises(InputError, match="seed is 7 there and 8 here"):
        open_dataset_for_writing(out, scenario, 8, 1, TABLE)
    assert everything(out) == before


def test_key_that_only_one_scenario_has_is_named(out: Path, scenario: dict[str, Any]) -> None:
    open_dataset_for_writing(out, scenario, 7, 1, TABLE)
    other = {**scenario, **{f"extra_{i}": "x" * 99 for i in range(9)}}
    with pytest.raises(InputError, match=r"scenario\.extra_0 is missing there and .*; …") as caught:
        open_dataset_for_writing(out, other, 7, 1, TABLE)
    assert len(str(caught.value)) < 600


def test_other_versions_do_not_continue_a_dataset(
    out: Path, make_run: Any, scenario: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    open_dataset_for_writing(out, scenario, 7, 2, TABLE)
    write_runs(make_run, out, [0])
    monkeypatch.setattr(resume, "version", lambda name: "99.0")
    with pytest.raises(InputError, match=r"packages\.magbench is .* there and \"99\.0\" here"):
        open_dataset_for_writing(out, scenario, 7, 2, TABLE)
    monkeypatch.undo()
    write_runs(make_run, out, [1])
    finish_dataset(out)
    before = everything(out)
    monkeypatch.setattr(resume, "version", lambda name: "99.0")
    assert open_dataset_for_writing(out, scenario, 7, 2, TABLE) == []
    finish_dataset(out)
    assert everything(out) == before


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is not a manifest"),
        ("[]", "is not a manifest"),
        ('{"schema": 1}', "is not a manifest"),
        ('{"schema": 99}', "has schema 99, this version reads 1"),
        ('{"schema": 1, "seed": NaN}', "NaN is not a finite number"),
        ('{"schema": 1, "seed": 1e999}', "1e999 is not a finite number"),
        ("[" * 100_000, "nested too deep"),
    ],
)
def test_manifest_that_cannot_be_read(tmp_path: Path, scenario: dict[str, Any], text: str, words: str) -> None:
    (tmp_path / "dataset.json").write_text(text)
    with pytest.raises(InputError, match=words):
        open_dataset_for_writing(tmp_path, scenario, 7, 1, TABLE)
    assert everything(tmp_path) == {"dataset.json": text.encode()}


def test_directory_with_runs_of_unknown_origin_is_refused(tmp_path: Path, scenario: dict[str, Any]) -> None:
    run_path(tmp_path, 0).write_bytes(b"precious")
    with pytest.raises(InputError, match=r"holds run files but no dataset\.json"):
        open_dataset_for_writing(tmp_path, scenario, 7, 1, TABLE)
    assert everything(tmp_path) == {"run-00000.parquet": b"precious"}


def test_output_that_is_a_file_is_refused(tmp_path: Path, scenario: dict[str, Any]) -> None:
    (tmp_path / "out").write_text("a file")
    with pytest.raises(InputError, match=r"out: file exists \(choose another output directory\)"):
        open_dataset_for_writing(tmp_path / "out", scenario, 7, 1, TABLE)


def test_long_values_are_shown_where_they_begin_to_differ():
    found = resume.differences("command", "v" * 60 + " --old", "v" * 60 + " --new")
    assert found == 'command is …vvvvv --old" there and …vvvvv --new" here'
