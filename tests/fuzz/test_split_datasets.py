"""Damaged files of a dataset in parts, whose runs share files: read as arrays, from a URL, and by the commands."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

import fsspec
import numpy as np
import pytest
from hypothesis import strategies as st

import magbench
from tests.fuzz.contract import amounts, answered, fuzz, hold
from tests.fuzz.material import SCENARIO
from tests.fuzz.tables import Bytes, broken_bytes
from tests.fuzz.values import damaged_json

CASES, REMADE = 60, 8
"""Cases in the normal run: of what reads the dataset, and of its command repeated."""
NUMBERS = count()
MANIFEST, TABLE = "dataset.json", "runs.parquet"
COMMANDS: dict[str, tuple[str, ...]] = {
    "calibrate": ("calibrate", "OUT", "--run", "2", "--with", "sphere", "--json"),
    "inspect": ("inspect", "OUT", "--run", "2", "--json"),
}


@dataclass(frozen=True)
class Case:
    """A file of the dataset, counted from the first, what is done to its bytes or its text, and who reads it then."""

    file: int
    damage: Bytes | str
    use: str

    def to(self, out: Path) -> Path:
        """Damage the file, the manifest where the damage is a text; return its path."""
        files = sorted(path for path in out.rglob("*") if path.suffix in (".parquet", ".json"))
        path = files[self.file % len(files)]
        if isinstance(self.damage, str):
            path = out / MANIFEST
            path.write_text(self.damage, encoding="utf-8", errors="surrogateescape")
        else:
            path.write_bytes(self.damage.to(path.read_bytes()))
        return path


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four runs of some seconds in three parts, two to a file."""
    place = tmp_path_factory.mktemp("split")
    (place / "tiny.toml").write_text(SCENARIO.replace("duration_s = 12.0", "duration_s = 4.0"))
    assert simulate(place, place / "out") == 0
    return place


def simulate(place: Path, out: Path) -> int:
    words = ("--runs", "4", "--runs-per-file", "2", "--split", "50/25/25", "--jobs", "1")
    return hold(place / "checked by figures", "simulate", str(place / "tiny.toml"), "-o", str(out), *words)


def arrays(place: str | Path) -> dict[str, Any]:
    """Everything that a dataset is read for."""
    runs = magbench.dataset(place)
    parts = {name: runs.part(name).runs for name in ("train", "validation", "test")}
    single = [run.columns for run in runs]
    return {
        **{"rows": runs.numpy(), "parameters": runs.parameters, "parts": parts, "single": single},
        "windows": runs.windows(length_s=1.0).numpy(),
    }


def in_memory(out: Path) -> str:
    """A copy of a dataset in fsspec's memory, under a name of its own, since files are remembered by their URLs."""
    name = f"damaged-{next(NUMBERS)}"
    fsspec.filesystem("memory").put(f"{out}/", f"/{name}/", recursive=True)
    return f"memory://{name}"


@pytest.fixture(autouse=True)
def forgotten() -> Iterator[None]:
    """Nothing is left in fsspec's memory, which is the whole process's."""
    yield
    fsspec.filesystem("memory").store.clear()


def read(out: Path, use: str) -> dict[str, Any] | None:
    """Return the arrays of a dataset, None where it is refused."""
    found: list[dict[str, Any]] = []
    place = in_memory(out) if use == "url" else out
    return found[0] if answered(lambda: found.append(arrays(place))) else None


def copies(whole: Path, place: Path) -> Callable[[], Path]:
    """A function that makes another copy of the dataset, since files are remembered by their paths."""

    def copy() -> Path:
        out = place / str(next(NUMBERS))
        shutil.copytree(whole / "out", out)
        return out

    return copy


@amounts
def test_split_datasets(whole: Path, tmp_path: Path, times: int) -> None:
    """What is read of a damaged dataset is what the whole one holds, or is refused."""
    known, copy = arrays(whole / "out"), copies(whole, tmp_path)
    manifest = json.loads((whole / "out" / MANIFEST).read_text())

    def check(case: Case) -> None:
        out = copy()
        damaged = case.to(out)
        if case.use in COMMANDS:
            words = [str(out) if word == "OUT" else word for word in COMMANDS[case.use]]
            hold(tmp_path / "nowhere", *words)
        else:
            found = read(out, case.use)
            if found is not None and damaged.name != MANIFEST:
                np.testing.assert_equal(found, known)
        shutil.rmtree(out)
        fsspec.filesystem("memory").store.clear()

    damages = broken_bytes | broken_bytes | damaged_json(manifest)
    uses = st.sampled_from(["arrays", "arrays", "url", *COMMANDS])
    fuzz(st.builds(Case, st.integers(0, 20), damages, uses), check, CASES, times)


@amounts
def test_split_datasets_are_made_anew(whole: Path, tmp_path: Path, times: int) -> None:
    """The command repeated leaves the dataset as it was, or refuses."""
    known, copy = (whole / "out" / MANIFEST).read_bytes(), copies(whole, tmp_path)

    def check(case: Case) -> None:
        out = copy()
        case.to(out)
        if simulate(whole, out) == 0 and not isinstance(case.damage, str):
            assert (out / MANIFEST).read_bytes() == known
            for path in (whole / "out").rglob("*.parquet"):
                assert (out / path.relative_to(whole / "out")).read_bytes() == path.read_bytes()
        shutil.rmtree(out)

    fuzz(st.builds(Case, st.integers(0, 20), broken_bytes, st.just("simulate")), check, REMADE, times)


@pytest.mark.parametrize("use", ["arrays", "url"])
@pytest.mark.parametrize("name", [MANIFEST, TABLE, "data"])
def test_a_missing_file_is_told(whole: Path, tmp_path: Path, name: str, use: str) -> None:
    out = copies(whole, tmp_path)()
    (shutil.rmtree if name == "data" else Path.unlink)(out / name)
    assert read(out, use) is None


def test_a_digit_of_the_field_in_a_run(whole: Path, tmp_path: Path) -> None:
    """A run's own field, told in the file's footer, decides what a calibration is worth: the manifest notices."""
    out = copies(whole, tmp_path)()
    file = next(out.rglob("runs-00000.parquet"))
    content = file.read_bytes()
    at = content.rindex(b"-40000.0")
    file.write_bytes(content[:at] + b"-40001.0" + content[at + 8 :])
    run = str(json.loads((out / MANIFEST).read_text())["files"][0]["run"])
    assert hold(tmp_path / "nowhere", "calibrate", str(out), "--run", run, "--with", "sphere", "--json") == 2
