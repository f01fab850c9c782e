"""Damaged manifests and run files: read, and resumed onto."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import strategies as st

from tests.fuzz.contract import amounts, check_dataset, fuzz, hold
from tests.fuzz.material import scenario_in
from tests.fuzz.tables import Bytes, broken_bytes
from tests.fuzz.values import damaged_json

CASES = 80
COMMANDS = ("simulate", "simulate", "calibrate", "inspect")


@dataclass(frozen=True)
class Case:
    """A dataset with another manifest, another run file, or without one of them."""

    manifest: str | None = None
    broken: Bytes | None = None
    runs: int = 2
    command: str = "simulate"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole dataset of two runs, beside its scenario."""
    place = tmp_path_factory.mktemp("whole")
    arguments = ("simulate", str(scenario_in(place)), "-o", str(place / "out"), "--runs", "2", "--jobs", "1")
    assert hold(place / "out", *arguments) == 0
    return place


def check(whole: Path, place: Path, case: Case) -> int:
    """Damage a copy of the dataset and use it; a command that was content leaves it whole."""
    out = place / "out"
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(whole / "out", out)
    if case.manifest is not None:
        (out / "dataset.json").write_text(case.manifest, encoding="utf-8", errors="surrogateescape")
    if case.broken is not None:
        run = out / "run-00001.parquet"
        run.write_bytes(case.broken.to(run.read_bytes()))
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    arguments = {
        "simulate": ("simulate", str(whole / "tiny.toml"), "-o", str(out), "--runs", str(case.runs), "--jobs", "1"),
        "calibrate": ("calibrate", str(out), "--run", "1", "--with", "sphere", "--json"),
        "inspect": ("inspect", str(out), "--run", "1", "--json"),
    }[case.command]
    status = hold(place / "nowhere", *arguments)
    if case.command == "simulate" and status == 0:
        check_dataset(out)
        for run in sorted((whole / "out").glob("*.parquet")):
            assert (out / run.name).read_bytes() == run.read_bytes()
    else:
        assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    return status


@amounts
def test_datasets(whole: Path, tmp_path: Path, times: int) -> None:
    manifest = json.loads((whole / "out" / "dataset.json").read_text())
    cases = st.builds(
        Case,
        st.none() | damaged_json(manifest) | damaged_json(manifest),
        st.none() | broken_bytes,
        st.sampled_from([2, 2, 3]),
        st.sampled_from(COMMANDS),
    )
    fuzz(cases, lambda case: check(whole, tmp_path, case), CASES, times)


@pytest.mark.parametrize("at", [200, 600, 995])
def test_a_run_file_that_is_not_the_listed_one_is_made_anew(whole: Path, tmp_path: Path, at: int) -> None:
    """Its hash differs, and often nothing else does."""
    assert check(whole, tmp_path, Case(broken=Bytes(at, b"\x17", False))) == 0


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999", "-1", "1.5", '"2"'])
@pytest.mark.parametrize("key", ["seed", "runs", "schema"])
def test_numbers_in_a_manifest(whole: Path, tmp_path: Path, key: str, number: str) -> None:
    manifest = json.loads((whole / "out" / "dataset.json").read_text()) | {key: 99_887}
    for command in COMMANDS[1:]:
        text = json.dumps(manifest).replace("99887", number)
        assert check(whole, tmp_path, Case(manifest=text, command=command)) == 2


def test_a_number_that_is_not_finite_in_the_scenario(whole: Path, tmp_path: Path) -> None:
    text = (whole / "out" / "dataset.json").read_text().replace("20000.0", "NaN")
    assert check(whole, tmp_path, Case(manifest=text)) == 2
