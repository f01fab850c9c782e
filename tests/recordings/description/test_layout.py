"""A split dataset on disk: where its runs are, how it resumes and grows, and that every reader finds a run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magbench.cli import main
from recordings import read_manifest, read_recording, read_run
from scenarios.errors import InputError
from sim.dataset_writer import generate
from tests.recordings.description.conftest import RUNS, VARY
from tests.short import short

SCENARIO = short("tumble", *VARY)


def everything(out: Path) -> dict[str, bytes]:
    return {str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()}


def test_every_run_is_in_the_folder_of_its_part_and_nothing_else_is_there(dataset: Path) -> None:
    manifest = read_manifest(dataset)
    listed = {file.path for file in manifest.files}
    assert {str(path.relative_to(dataset)) for path in (dataset / "data").rglob("*") if path.is_file()} == listed
    assert manifest.split is not None
    assert all(file.path.split("/")[1] == manifest.split.part_of(file.run) for file in manifest.files)
    assert {path.name for path in dataset.iterdir()} == {
        *("data", "dataset.json", "runs.parquet", "README.md", "croissant.json")
    }


def test_the_files_are_those_of_the_plain_dataset_with_the_number_of_the_run(dataset: Path, tmp_path: Path) -> None:
    generate(SCENARIO, tmp_path, runs=3)
    for plain, split in zip(read_manifest(tmp_path).files, read_manifest(dataset).files, strict=False):
        one, other = pq.read_table(tmp_path / plain.path), pq.read_table(dataset / split.path, partitioning=None)
        assert other["run"].to_pylist() == [split.run] * split.rows
        assert other.drop_columns("run").equals(one)


@pytest.mark.usefixtures("undrawn")
def test_readers_find_a_run_by_its_number(dataset: Path, tmp_path: Path) -> None:
    for entry in read_manifest(dataset).files:
        recording, truth = read_run(dataset, run=entry.run)
        assert len(recording) == len(truth.q) == entry.rows
        assert "run" not in recording.channels
        assert len(read_recording(dataset / entry.path)) == entry.rows
    command = ["calibrate", str(dataset), "--run", "4", "--with", "ellipsoid", "-o", str(tmp_path / "fit")]
    assert main(command) == 0
    assert main(["inspect", str(dataset), "--run", str(RUNS - 1), "-o", str(tmp_path / "look")]) == 0
    with pytest.raises(InputError, match=rf"has no run {RUNS} \(it has runs 0 to {RUNS - 1}\)"):
        read_recording(dataset, run=RUNS)


def test_the_same_bytes_whatever_the_jobs_and_however_often_interrupted(dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "tumbles"
    generate(SCENARIO, out, runs=4, jobs=2, split="80/10/10")
    kept = {name: text for name, text in everything(out).items() if name.startswith("data/")}
    (out / "data" / "train" / "run-00007.parquet.magbench-part").write_bytes(b"PAR1 cut off")
    (out / "runs.parquet").unlink()
    damaged = out / read_manifest(out).files[2].path
    damaged.write_bytes(damaged.read_bytes()[:-50])
    told: list[str] = []
    generate(SCENARIO, out, runs=RUNS, split="80/10/10", warn=told.append)
    assert told == [f"{out}: not the files that dataset.json lists, so made anew: {damaged.name}"]
    assert everything(out) == everything(dataset)
    assert kept.items() <= everything(out).items()


@pytest.mark.parametrize(
    ("split", "said"),
    [
        (None, "holds another dataset: split is {.* there and missing here"),
        ("70/20/10", "holds another dataset: split.train is 80 there and 70 here"),
    ],
)
def test_another_split_is_refused_and_nothing_is_touched(
    dataset: Path, split: str | None, said: str, tmp_path: Path
) -> None:
    out = shutil.copytree(dataset, tmp_path / "copy")
    before = everything(out)
    with pytest.raises(InputError, match=said):
        generate(SCENARIO, out, runs=RUNS, split=split)
    (out / "dataset.json").unlink()
    with pytest.raises(InputError, match=r"holds run files but no dataset\.json"):
        generate(SCENARIO, out, runs=RUNS, split="80/10/10")
    assert before.keys() - everything(out).keys() == {"dataset.json"}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"train": 80', '"train": 90', "the shares do not add up to 100 per cent"),
        ('"train": 80', '"train": -80', "split: train"),
        ('"train": 80', '"some": 80', "split: "),
    ],
)
def test_a_damaged_split_is_one_line(dataset: Path, old: str, new: str, said: str, tmp_path: Path) -> None:
    text = (dataset / "dataset.json").read_text()
    (tmp_path / "dataset.json").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=said):
        read_recording(tmp_path)
