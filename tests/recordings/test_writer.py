"""Files hold exactly what was written, or do not exist."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import textwrap
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from recordings import RunWriter, columns, schema, writer
from recordings.files import canonical_json, sha256_of, system_errors_about, write_text
from scenarios.errors import InputError
from tests.recordings.conftest import restrained

posix = pytest.mark.skipif(os.name == "nt", reason="the system has neither this limit nor this signal")
SMALL_GROUP = 128


@pytest.fixture
def small_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "ROWS_PER_GROUP", SMALL_GROUP)


@pytest.mark.usefixtures("small_groups")
@pytest.mark.parametrize("step", [1, 128, 150, 1000])
@pytest.mark.parametrize("sensors", [1, 4])
def test_columns_come_back_exactly(tmp_path: Path, make_run: Any, step: int, sensors: int) -> None:
    run = make_run(sensors=sensors)
    run.write(tmp_path / "r.parquet", step)
    table = pq.read_table(tmp_path / "r.parquet")
    assert table.column_names == [c.name for c in run.table]
    for name, values in run.block.items():
        assert table[name].to_pylist() == values.tolist()


@pytest.mark.usefixtures("small_groups")
def test_row_groups_are_bounded_and_full(tmp_path: Path, run: Any) -> None:
    run.write(tmp_path / "r.parquet", 150)
    metadata = pq.read_metadata(tmp_path / "r.parquet")
    assert [metadata.row_group(i).num_rows for i in range(metadata.num_row_groups)] == [128, 128, 128, 16]


@pytest.mark.usefixtures("small_groups")
def test_same_data_give_the_same_bytes_however_cut(tmp_path: Path, run: Any) -> None:
    digests = set()
    for step in (1, 7, 128, 129, 400):
        run.write(tmp_path / f"{step}.parquet", step)
        digests.add(sha256_of(tmp_path / f"{step}.parquet"))
    assert len(digests) == 1
    run.block["mag_x_nT"][-1] = np.nextafter(run.block["mag_x_nT"][-1], np.inf)
    run.write(tmp_path / "other.parquet")
    assert sha256_of(tmp_path / "other.parquet") not in digests


def test_units_and_metadata_are_in_the_file(tmp_path: Path, run: Any, scenario: dict[str, Any]) -> None:
    run.write(tmp_path / "r.parquet", seed=7, run=2)
    stored = pq.read_schema(tmp_path / "r.parquet")
    assert stored.field("mag_x_nT").metadata[b"unit"] == b"nT"
    assert b"hard_iron" in stored.field("effect_hard_iron_x_nT").metadata[b"meaning"]
    text = stored.metadata[b"magbench"].decode()
    said = json.loads(text)
    assert (said["schema"], said["seed"], said["run"], said["scenario"]) == (1, 7, 2, scenario)
    assert said["parameters"] == {"hard_iron": {"x_nT": 300.0}}
    assert text == canonical_json(said)


def test_constant_and_zero_columns_cost_next_to_nothing(tmp_path: Path) -> None:
    table = columns(effects=("hard_iron", "soft_iron"))
    n = 200_000
    block = {c.name: np.full(n, 123.456) if c.group != "phase" else np.full(n, "spiral") for c in table}
    with RunWriter(tmp_path / "r.parquet", schema(table), {}) as out:
        out.write(block)
    assert (tmp_path / "r.parquet").stat().st_size < n * len(table) * 8 / 1000


def test_longer_words_may_come_later(tmp_path: Path) -> None:
    table = schema([c for c in columns() if c.name in ("time_s", "phase")])
    with RunWriter(tmp_path / "r.parquet", table, {}) as out:
        for i, word in enumerate(("a", "turntable", "b", "a")):
            out.write({"time_s": np.arange(3.0) + 3 * i, "phase": np.full(3, word)})
    words = pq.read_table(tmp_path / "r.parquet")["phase"].to_pylist()
    assert words == ["a"] * 3 + ["turntable"] * 3 + ["b"] * 3 + ["a"] * 3


@pytest.mark.parametrize("wrong", ["missing", "unknown", "length"])
def test_block_that_does_not_fit_the_schema(tmp_path: Path, run: Any, wrong: str) -> None:
    block = dict(run.block)
    if wrong == "missing":
        del block["mag_y_nT"]
    elif wrong == "unknown":
        block["mag_q_nT"] = block["mag_x_nT"]
    else:
        block["mag_y_nT"] = block["mag_y_nT"][:-1]
    with (
        pytest.raises(ValueError, match="different lengths" if wrong == "length" else "differ from the schema"),
        RunWriter(tmp_path / "r.parquet", schema(run.table), {}) as out,
    ):
        out.write(block)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("small_groups")
@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, RuntimeError, FileNotFoundError])
def test_nothing_is_left_when_the_block_fails(tmp_path: Path, run: Any, error: type[BaseException]) -> None:
    (tmp_path / "r.parquet").write_text("the one before")

    def fail() -> None:
        with RunWriter(tmp_path / "r.parquet", schema(run.table), {}) as out:
            out.write(run.block)
            assert (tmp_path / "r.parquet.magbench-part").exists()
            raise error("stop")

    with pytest.raises(error, match="stop"):
        fail()
    assert os.listdir(tmp_path) == ["r.parquet"]
    assert (tmp_path / "r.parquet").read_text() == "the one before"


@contextmanager
def one_line_about(path: Path, words: str) -> Iterator[None]:
    with pytest.raises(InputError) as caught:
        yield
    message = str(caught.value)
    assert str(path) in message
    assert words in message
    assert "\n" not in message


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk(tmp_path: Path, run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A device that is always full stands in for the file that is written beside."""
    target = tmp_path / "r.parquet"
    opened = pa.OSFile
    monkeypatch.setattr(pa, "OSFile", lambda path, mode: opened("/dev/full", mode))
    with one_line_about(target, os.strerror(errno.ENOSPC).lower()):
        run.write(target)
    assert list(tmp_path.iterdir()) == []


@posix
def test_full_disk_in_the_middle(tmp_path: Path) -> None:
    """The file may grow to 200 kB: some row groups are written, then no more."""
    script = textwrap.dedent("""
        import resource, sys
        from pathlib import Path
        import numpy as np
        from scenarios.errors import InputError
        from recordings import columns
        from recordings import writer
        from recordings import RunWriter, schema
        writer.ROWS_PER_GROUP = 256
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
        table = columns()
        rng = np.random.default_rng(1)
        block = {c.name: rng.normal(size=1000) if c.group != "phase" else np.full(1000, "a") for c in table}
        try:
            with RunWriter(Path(sys.argv[1]), schema(table), {}) as out:
                for _ in range(10):
                    out.write(block)
        except InputError as error:
            print(error)
    """)
    done = run_python(script, tmp_path / "r.parquet")
    assert done.stderr == ""
    assert done.stdout.startswith(f"{tmp_path / 'r.parquet'}: file too large (free some space")
    assert done.stdout.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["missing/r.parquet", "file/r.parquet"])
def test_directory_that_cannot_take_a_file(tmp_path: Path, run: Any, place: str) -> None:
    (tmp_path / "file").write_text("not a directory")
    with one_line_about(tmp_path / place, "directory"):
        run.write(tmp_path / place)
    assert os.listdir(tmp_path) == ["file"]


@pytest.mark.skipif(not restrained(), reason="this user may write everywhere")
def test_directory_without_permission(tmp_path: Path, run: Any) -> None:
    tmp_path.chmod(0o500)
    with one_line_about(tmp_path / "r.parquet", "permission denied"):
        run.write(tmp_path / "r.parquet")
    tmp_path.chmod(0o700)


@posix
def test_killed_while_writing_leaves_no_file_under_the_final_name(tmp_path: Path) -> None:
    script = textwrap.dedent("""
        import os, signal, sys
        from pathlib import Path
        import numpy as np
        from recordings import columns
        from recordings import writer
        from recordings import RunWriter, schema
        writer.ROWS_PER_GROUP = 256
        table = columns()
        block = {c.name: np.ones(1000) if c.group != "phase" else np.full(1000, "a") for c in table}
        with RunWriter(Path(sys.argv[1]), schema(table), {}) as out:
            out.write(block)
            os.kill(os.getpid(), signal.SIGKILL)
    """)
    done = run_python(script, tmp_path / "run-00000.parquet")
    assert done.returncode == -signal.SIGKILL
    assert os.listdir(tmp_path) == ["run-00000.parquet.magbench-part"]


def run_python(script: str, path: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=False)


@posix
def test_memory_is_bounded_whatever_the_length(tmp_path: Path) -> None:
    table, n, blocks = columns(), 20_000, 100
    block = {c.name: np.arange(n) * 1.0 if c.group != "phase" else np.full(n, "spiral") for c in table}
    buffers = writer.ROWS_PER_GROUP * len(table) * 8
    resource = pytest.importorskip("resource")
    resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    tracemalloc.start()
    with RunWriter(tmp_path / "r.parquet", schema(table), {}) as out:
        for _ in range(blocks):
            out.write(block)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - resident
    assert pq.read_metadata(tmp_path / "r.parquet").num_rows == n * blocks
    assert peak < 1.3 * buffers
    assert grown < 6 * buffers < n * blocks * len(table) * 8 / 5


def test_write_text_replaces_whole(tmp_path: Path) -> None:
    write_text(tmp_path / "a.json", "one")
    write_text(tmp_path / "a.json", "two\n")
    assert (tmp_path / "a.json").read_bytes() == b"two\n"
    assert os.listdir(tmp_path) == ["a.json"]


def test_what_arrow_says_without_a_number_is_told_too() -> None:
    with one_line_about(Path("x"), "strange"), system_errors_about(Path("x")):
        raise pa.ArrowIOError("Strange\nand long")


def test_canonical_json_of_numpy_values_in_any_order() -> None:
    one = canonical_json({"b": np.arange(2), "a": np.float64(0.1), "c": "µ"})
    assert one == canonical_json({"c": "µ", "a": 0.1, "b": [0, 1]}) == '{"a":0.1,"b":[0,1],"c":"µ"}'
    with pytest.raises(ValueError, match="not JSON compliant"):
        canonical_json({"a": float("nan")})
    with pytest.raises(TypeError, match="set"):
        canonical_json({"a": {1}})
