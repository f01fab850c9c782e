"""Several runs a file, folders of bounded size, and a cluster: the same rows and the same bytes as one process."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from recordings import layout, read_manifest
from recordings.layout import DatasetLayout
from recordings.resume import open_dataset_for_writing
from recordings.split import Split
from scenarios.errors import InputError
from sim import file_writer, motion_cache
from sim.dataset_writer import generate
from tests.short import short
from validation.comparison.cluster import Cluster

distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
SCENARIO = short("tumble")


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """The address of a scheduler with two workers in this process."""
    silent = {"dashboard_address": None, "silence_logs": False}
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=False, protocol="tcp", **silent) as made:
        yield made.scheduler_address


def everything(out: Path) -> dict[str, bytes]:
    """The bytes of every file."""
    return {str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()}


@pytest.mark.parametrize("options", [{}, {"split": "60/20/20", "runs_per_file": 2}])
def test_a_cluster_writes_the_bytes_of_one_process(options: dict[str, object], address: str, tmp_path: Path) -> None:
    generate(SCENARIO, tmp_path / "here", runs=5, **options)  # type: ignore[arg-type]
    generate(SCENARIO, tmp_path / "cluster", runs=5, engine=Cluster(address, 20.0), **options)  # type: ignore[arg-type]
    here = everything(tmp_path / "here")
    assert everything(tmp_path / "cluster") == here
    damaged = tmp_path / "cluster" / read_manifest(tmp_path / "here").files[1].path
    damaged.write_bytes(damaged.read_bytes()[:-40])
    told: list[str] = []
    generate(SCENARIO, tmp_path / "cluster", runs=5, engine=Cluster(address, 20.0), warn=told.append, **options)  # type: ignore[arg-type]
    assert everything(tmp_path / "cluster") == here
    assert damaged.name in told[0]


def test_several_runs_a_file_are_the_runs_of_single_files_and_grow(tmp_path: Path) -> None:
    generate(SCENARIO, tmp_path / "single", runs=5)
    generate(SCENARIO, tmp_path / "grown", runs=3, runs_per_file=2)
    first = (tmp_path / "grown" / "runs-00000.parquet").stat().st_mtime_ns
    told: list[str] = []
    generate(SCENARIO, tmp_path / "grown", runs=5, runs_per_file=2, warn=told.append)
    generate(SCENARIO, tmp_path / "whole", runs=5, runs_per_file=2)
    assert everything(tmp_path / "grown") == everything(tmp_path / "whole")
    assert (tmp_path / "grown" / "runs-00000.parquet").stat().st_mtime_ns == first
    assert told == []
    together = pa.concat_tables(pq.read_table(tmp_path / "whole" / name) for name in _names("runs", 0, 2, 4))
    alone = [pq.read_table(tmp_path / "single" / name) for name in _names("run", *range(5))]
    assert together.drop_columns("run").equals(pa.concat_tables(alone).cast(together.drop_columns("run").schema))
    assert together["run"].to_pylist() == [run for run, table in enumerate(alone) for _ in range(len(table))]
    table = pq.read_table(tmp_path / "whole" / "runs.parquet")
    assert table["run"].to_pylist() == [0, 1, 2, 3, 4]
    assert "split" not in table.column_names


def _names(stem: str, *numbers: int) -> list[str]:
    return [f"{stem}-{number:05d}.parquet" for number in numbers]


@pytest.mark.parametrize("split", [None, Split(70, 20, 10, seed=3)])
@pytest.mark.parametrize("per_file", [1, 3])
def test_every_run_has_one_place_in_folders_of_bounded_size(
    split: Split | None, per_file: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layout, "FILES_PER_FOLDER", 20)
    asked = DatasetLayout(split, per_file)
    files = asked.files(1000)
    held = [(file, run) for file in files for run in file.runs]
    assert sorted(run for _, run in held) == list(range(1000))
    assert len({file.path for file in files}) == len(files) == asked.count(1000)
    assert max(Counter(file.path.rpartition("/")[0] for file in files).values()) <= 20
    assert [asked.file_of(run, 1000) for _, run in held] == [file for file, _ in held]
    small = {file.path for file in asked.files(400)}
    assert small <= {file.path for file in files}


def test_files_of_several_runs_hold_one_part_each() -> None:
    split = Split(70, 20, 10, seed=3)
    held = [(file.path, run) for file in DatasetLayout(split, 3).files(1000) for run in file.runs]
    assert [split.part_of(run) for _, run in held] == [path.split("/")[1] for path, _ in held]


def test_a_million_runs_have_a_thousand_files_and_need_several_runs_a_file(tmp_path: Path) -> None:
    assert DatasetLayout(runs_per_file=1000).count(1_000_000) == 1000
    assert DatasetLayout().file_of(1_234_567).path == "1230000/run-1234567.parquet"
    assert DatasetLayout().file_of(9_999).path == "run-09999.parquet"
    with pytest.raises(InputError, match=r"--runs-per-file.*10 runs or more"):
        open_dataset_for_writing(tmp_path / "out", {}, 0, 1_000_000, ())
    assert not (tmp_path / "out").exists()


def test_runs_of_one_motion_simulate_it_once_with_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    driven: list[int] = []
    real = motion_cache.true_motion
    monkeypatch.setattr(file_writer, "MOTIONS", motion_cache.MotionCache())
    monkeypatch.setattr(motion_cache, "true_motion", lambda plan: driven.append(plan.run) or real(plan))
    generate(SCENARIO, tmp_path / "together", runs=3)
    assert driven == [0]
    task = file_writer.FileTask(SCENARIO, DatasetLayout().file_of(2), SCENARIO.seed, tmp_path)
    file_writer.write_file(task)
    name = "run-00002.parquet"
    assert (tmp_path / name).read_bytes() == (tmp_path / "together" / name).read_bytes()
