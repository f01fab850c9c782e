"""A dataset as arrays: every row is the file's own, splits share no run, windows and workers miss none."""

from __future__ import annotations

import importlib.util
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

import magbench
from recordings.loading import RunSet, rows
from scenarios.errors import InputError
from sim.dataset_writer import generate
from tests.short import short

MAG = ["mag_x_nT", "mag_y_nT", "mag_z_nT"]
RUNS = 5


@pytest.fixture(scope="module", params=[1, 2], ids=["one a file", "two a file"])
def place(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of five short runs."""
    out: Path = tmp_path_factory.mktemp("dataset")
    generate(short("tumble"), out, runs=RUNS, runs_per_file=request.param)
    return out


@pytest.fixture
def data(place: Path) -> RunSet:
    """The dataset, opened."""
    return magbench.dataset(place)


def frames(place: Path) -> pd.DataFrame:
    """Every row, by pandas, with the number of its run."""
    held = [pd.read_parquet(path, partitioning=None) for path in sorted(place.glob("run*-*.parquet"))]
    return pd.concat([one if "run" in one else one.assign(run=k) for k, one in enumerate(held)])


def test_runs_rows_and_parameters_are_the_files_own(data: RunSet, place: Path) -> None:
    every = frames(place)
    assert len(data) == RUNS
    assert data.runs.tolist() == list(range(RUNS))
    assert repr(data).startswith(f"RunSet: {RUNS} runs, ")
    assert repr(data[:1]).startswith("RunSet: 1 run, ")
    for one in data:
        wanted = every[every["run"] == one.run]
        assert all(np.array_equal(one.columns[name], wanted[name]) for name in data.columns if name != "phase")
        assert one.columns["phase"].tolist() == wanted["phase"].tolist()
    whole = data.numpy()
    assert all(np.array_equal(whole[name], every[name]) for name in ("run", *MAG))
    assert whole["phase"].tolist() == every["phase"].tolist()
    key = "effects.white_noise.std_nT.0"
    assert data.parameters[key].tolist() == [one.parameters[key] for one in data]


def test_a_split_shares_no_run_and_is_drawn_by_the_seed(data: RunSet) -> None:
    train, rest = data.split(train=0.6, seed=1)
    assert (len(train), len(rest)) == (3, 2)
    assert sorted([*train.runs, *rest.runs]) == list(range(RUNS))
    assert train.runs.tolist() == data.split(train=0.6, seed=1)[0].runs.tolist()
    assert len({tuple(data.split(train=0.6, seed=seed)[0].runs) for seed in range(9)}) > 2
    assert rest.numpy()["run"].tolist() == [run for run in rest.runs for _ in range(len(data[0].columns["time_s"]))]


def test_windows_lie_in_one_run_and_index_and_iteration_agree(place: Path) -> None:
    windows = magbench.dataset(place, columns=["time_s", *MAG]).windows(length_s=2.0, stride_s=1.5)
    every = frames(place)
    values = windows.numpy()
    assert values.shape == (len(windows), windows.length, 4)
    assert len(windows) == sum((n - windows.length) // windows.stride + 1 for n in every.groupby("run").size())
    assert np.allclose(np.diff(values[:, :, 0], axis=1), values[0, 1, 0] - values[0, 0, 0])
    for index in (0, len(windows) // 2, -1):
        one = windows[index]
        assert np.array_equal(one.values, values[index])
        rows_there = every[every["run"] == one.run][["time_s", *MAG]].to_numpy()
        assert np.array_equal(one.values, rows_there[one.first : one.first + windows.length])
        assert one.run == windows.runs[index]
    with pytest.raises(IndexError):
        windows[len(windows)]
    assert windows.astype("float32").numpy().dtype == np.float32


def test_only_the_asked_columns_are_read(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened, asked = magbench.dataset(place, columns=MAG), list[list[str]]()
    real = rows.pq.read_table
    monkeypatch.setattr(rows.pq, "read_table", lambda *a, **k: asked.append(k["columns"]) or real(*a, **k))
    opened.numpy()
    assert asked
    assert all(columns == MAG for columns in asked)


USES: dict[str, Callable[[RunSet], object]] = {
    "rows": lambda data: data.numpy(),
    "run": lambda data: data[RUNS - 1],
    "windows": lambda data: data.windows(length_s=2.0)[-1],
    "parameters of a run": lambda data: data._parameters_of(data.places[-1]),
}


@pytest.mark.parametrize("use", USES.values(), ids=USES)
def test_a_file_with_one_bit_turned_is_refused(place: Path, tmp_path: Path, use: Callable[[RunSet], object]) -> None:
    out = tmp_path / "copy"
    shutil.copytree(place, out)
    opened, last = magbench.dataset(out), sorted(out.glob("run*-*.parquet"))[-1]
    use(opened)
    content = bytearray(last.read_bytes())
    content[len(content) // 3] ^= 1 << 4
    last.write_bytes(content)
    for data in (opened, magbench.dataset(out, columns=MAG)):
        with pytest.raises(InputError, match=f"{last.name}: differs from its SHA-256") as refused:
            use(data)
        assert "\n" not in str(refused.value)
        assert len(data[0].columns["mag_x_nT"]) > 0


def test_without_a_check_a_turned_bit_is_read(place: Path, tmp_path: Path) -> None:
    shutil.copytree(place, tmp_path, dirs_exist_ok=True)
    last, known = sorted(tmp_path.glob("run*-*.parquet"))[-1], magbench.dataset(place, columns=MAG)[RUNS - 1].columns
    start = pq.ParquetFile(last).metadata.row_group(0)
    at = next(start.column(k) for k in range(start.num_columns) if start.column(k).path_in_schema == MAG[0])
    content = bytearray(last.read_bytes())
    content[at.data_page_offset + at.total_compressed_size // 2] ^= 1
    last.write_bytes(content)
    read = magbench.dataset(tmp_path, columns=MAG, check=False)[RUNS - 1].columns
    assert [np.array_equal(read[name], known[name]) for name in MAG] == [False, True, True]


def test_a_table_of_runs_with_one_bit_turned_is_refused(place: Path, tmp_path: Path) -> None:
    shutil.copytree(place, tmp_path, dirs_exist_ok=True)
    table = tmp_path / "runs.parquet"
    if not table.exists():
        pytest.skip("runs that have files of their own need no table")
    content = bytearray(table.read_bytes())
    middle = np.median(magbench.dataset(place).parameters["effects.hard_iron.offset_nT.0"])
    content[content.index(middle.tobytes())] ^= 1
    table.write_bytes(content)
    with pytest.raises(InputError, match=r"runs\.parquet"):
        print(magbench.dataset(tmp_path).parameters)


def test_wrong_use_is_one_line(data: RunSet, place: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no column 'mag_q'"):
        magbench.dataset(place, columns=["mag_q"])
    with pytest.raises(InputError, match="shorter than a sample"):
        data.windows(length_s=1e-6)
    with pytest.raises(InputError, match="no parts"):
        data.part("train")
    with pytest.raises(InputError, match=r"dataset\.json"):
        magbench.dataset(tmp_path)


@pytest.fixture
def worker(monkeypatch: pytest.MonkeyPatch) -> Iterator[SimpleNamespace]:
    """A stand-in for the parts of torch that the stream uses, and the worker that it tells of."""
    told = SimpleNamespace(id=0, num_workers=1)
    torch, utils, data = (ModuleType(name) for name in ("torch", "torch.utils", "torch.utils.data"))
    torch.as_tensor = np.asarray  # type: ignore[attr-defined]
    data.IterableDataset, data.get_worker_info = object, lambda: told  # type: ignore[attr-defined]
    for module in (torch, utils, data):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.delitem(sys.modules, "recordings.loading.torch_stream", raising=False)
    yield told
    sys.modules.pop("recordings.loading.torch_stream", None)


def test_workers_together_stream_every_window_once(data: RunSet, worker: SimpleNamespace) -> None:
    windows = magbench.dataset(data.path, columns=MAG).windows(length_s=2.0)
    key = "effects.white_noise.std_nT.0"
    stream = windows.torch(targets={key: data.parameters[key]}, shuffle_seed=3)
    worker.num_workers, seen = 3, []
    for worker.id in range(3):
        seen += list(stream)
    assert len(seen) == len(windows)
    assert sorted(one["values"][0, 0] for one in seen) == sorted(windows.numpy()[:, 0, 0])
    assert all(one["targets"].tolist() == [data.parameters[key][one["run"]]] for one in seen)
    assert [one["run"] for one in seen] != sorted(one["run"] for one in seen)


@pytest.mark.skipif(importlib.util.find_spec("torch") is not None, reason="torch is installed")
def test_without_torch_it_says_what_to_install(data: RunSet) -> None:
    with pytest.raises(InputError, match=r"magbench\[learn\]"):
        data.windows(length_s=2.0).torch()


def test_hugging_face_streams_the_files_and_their_run_numbers(place: Path, tmp_path: Path) -> None:
    datasets = pytest.importorskip("datasets", reason="Hugging Face's datasets is not installed")
    files = [str(path) for path in sorted(place.glob("run*-*.parquet"))]
    streamed = datasets.load_dataset(
        "parquet", data_files=files, split="train", streaming=True, columns=MAG, cache_dir=tmp_path
    )
    first = next(iter(streamed))
    assert first == {name: frames(place)[name].iloc[0] for name in MAG}
    assert sum(1 for _ in streamed) == len(frames(place))
