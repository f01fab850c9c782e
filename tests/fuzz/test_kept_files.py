"""Damaged files that an earlier command kept: baselines, bounds of a comparison, and datasets read as arrays."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import strategies as st

import magbench
from tests.fuzz.contract import amounts, answered, fuzz
from tests.fuzz.tables import Bytes, Damage, broken_bytes, damages
from tests.fuzz.test_datasets import whole  # noqa: F401
from tests.fuzz.values import damaged_json
from tests.validation.comparison.conftest import small
from validation.comparison.kept_bounds import BOUNDS, KeptBounds
from validation.gates.score_baseline import COLUMNS, read_baseline, rows_of, write_baseline

BASELINES, BOUND_FILES, DATASETS = 40, 8, 40
"""Cases of each in the normal run."""
SCORE = "offset_error_nT"


@amounts
def test_bytes_of_baselines(tmp_path: Path, times: int) -> None:
    """Damage in a page is noticed by its checksum: no other figure than the kept ones is ever given."""
    design, path, kept = small(), tmp_path / "b.parquet", np.linspace(1.0, 2.0, 12)
    write_baseline(path, [rows_of(design, "sphere", SCORE, kept)])
    content = path.read_bytes()

    def check(damage: Bytes) -> None:
        path.write_bytes(damage.to(content))
        found: list[list[float]] = []
        if answered(lambda: found.append(read_baseline(path, design, "sphere", SCORE, 12).tolist())):
            assert found == [kept.tolist()]

    fuzz(broken_bytes, check, BASELINES, times)


def test_a_bit_of_a_kept_figure(tmp_path: Path) -> None:
    """One bit turned anywhere in the scores' page is refused, however likely the figure that it makes."""
    design, path, kept = small(), tmp_path / "b.parquet", np.random.default_rng(2).uniform(1.0, 2.0, 50)
    write_baseline(path, [rows_of(design, "sphere", SCORE, kept)])
    content = path.read_bytes()
    start = content.index(kept[20].tobytes())
    for bit in range(64):
        turned = bytearray(content)
        turned[start + bit // 8] ^= 1 << bit % 8
        path.write_bytes(turned)
        assert not answered(lambda: read_baseline(path, design, "sphere", SCORE, 50)), bit


@amounts
def test_tables_of_baselines(tmp_path: Path, times: int) -> None:
    """Whatever another program wrote, what is believed is finite or no estimate, and not negative."""
    design, path = small(), tmp_path / "b.parquet"
    table = rows_of(design, "sphere", SCORE, np.linspace(1.0, 2.0, 12))

    def check(case: tuple[Damage, ...]) -> None:
        changed = table
        for one in case:
            changed = one.to(changed)
        pq.write_table(changed, path)
        found: list[np.ndarray] = []
        if answered(lambda: found.append(read_baseline(path, design, "sphere", SCORE, 12))):
            assert (found[0] >= 0.0).all()

    fuzz(damages(list(COLUMNS.names)), check, BASELINES, times)


@amounts
def test_kept_bounds(tmp_path: Path, times: int) -> None:
    """A damaged line is computed again; the bounds are those of the whole file."""
    design = small()

    def bounds() -> object:
        return KeptBounds(tmp_path / BOUNDS, design, frozenset({"norm"})).of(0, range(3))

    known = bounds()
    content = (tmp_path / BOUNDS).read_bytes()

    def check(damage: Bytes) -> None:
        (tmp_path / BOUNDS).write_bytes(damage.to(content))
        assert answered(lambda: np.testing.assert_equal(bounds(), known))
        assert (tmp_path / BOUNDS).read_bytes().count(b"\n") == content.count(b"\n")

    fuzz(broken_bytes, check, BOUND_FILES, times)


def used(out: Path) -> None:
    """Everything that a dataset is read for."""
    runs = magbench.dataset(out)
    rows = runs.numpy()
    assert len(runs[0].columns["time_s"]) > 0
    assert all(np.isfinite(values).all() for name, values in rows.items() if name != "phase")
    assert runs.parameters
    assert len(runs.windows(length_s=2.0).numpy()) > 0
    assert sum(map(len, runs.split(0.5, seed=1))) == len(runs)


@amounts
def test_datasets_as_arrays(whole: Path, tmp_path: Path, times: int) -> None:  # noqa: F811
    manifest = json.loads((whole / "out" / "dataset.json").read_text())
    numbered = iter(range(10**9))

    def check(case: tuple[str | None, Bytes | None]) -> None:
        out = tmp_path / str(next(numbered))
        shutil.copytree(whole / "out", out)
        text, broken = case
        if text is not None:
            (out / "dataset.json").write_text(text, encoding="utf-8", errors="surrogateescape")
        if broken is not None:
            run = out / "run-00001.parquet"
            run.write_bytes(broken.to(run.read_bytes()))
        content = answered(lambda: used(out))
        assert not (content and text is None and _differs(out, whole / "out", "run-00001.parquet"))
        shutil.rmtree(out)

    fuzz(st.tuples(st.none() | damaged_json(manifest), st.none() | broken_bytes), check, DATASETS, times)


def _differs(one: Path, other: Path, name: str) -> bool:
    return (one / name).read_bytes() != (other / name).read_bytes()


@pytest.mark.parametrize("damage", [Bytes(500, b"\x17\x17", False), Bytes(700, b"", True)])
def test_a_whole_dataset_is_read_and_a_torn_one_refused(whole: Path, tmp_path: Path, damage: Bytes) -> None:  # noqa: F811
    assert answered(lambda: used(whole / "out"))
    shutil.copytree(whole / "out", tmp_path / "out")
    run = tmp_path / "out" / "run-00000.parquet"
    run.write_bytes(damage.to(run.read_bytes()))
    assert not answered(lambda: used(tmp_path / "out"))
