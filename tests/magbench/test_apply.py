"""Calibrate one recording, apply the file to another."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from magbench.cli import main
from sim.dataset import read_recording, read_run
from tests.short import cuts


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("tumble")
    sets = [text for cut in cuts("tumble") for text in ("--set", cut)]
    assert main(["simulate", "tumble", "-o", str(out), "--runs", "2", "--set", "vary=", *sets]) == 0
    return out


def test_a_calibration_corrects_another_run(data: Path, tmp_path: Path) -> None:
    fit = ["calibrate", str(data), "--with", "vector_least_squares,ellipsoid", "-o", str(tmp_path), "--export", "c,ros"]
    assert main(fit) == 0
    names = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()}
    folders = {
        f"{c}/{f}" for c in ("vector_least_squares", "ellipsoid") for f in ("mag_calibration.h", "magnetometer.yaml")
    }
    assert names == {"calibration.json"} | folders
    out = tmp_path / "corrected.parquet"
    assert main(["apply", str(tmp_path / "calibration.json"), str(data), "--run", "1", "-o", str(out)]) == 0
    raw, truth = read_run(data, run=1)
    before = np.sqrt(((raw.mag_nT - truth.field_nT) ** 2).mean())
    after = np.sqrt(((read_recording(out).mag_nT - truth.field_nT) ** 2).mean())
    assert after < 0.1 * before


@pytest.mark.parametrize(
    ("text", "named"),
    [("{", "not JSON"), ("{}", "no calibration"), ('{"a": {"matrix": [1]}}', "matrix"), ('{"a": 5}', "JSON object")],
)
def test_bad_calibration_files(text: str, named: str, data: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "c.json").write_text(text)
    assert main(["apply", str(tmp_path / "c.json"), str(data), "-o", str(tmp_path / "o.csv")]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert named in lines[0]
    assert not (tmp_path / "o.csv").exists()


def test_unknown_calibration(data: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    assert main(["calibrate", str(data), "--with", "sphere", "-o", str(tmp_path)]) == 0
    capsys.readouterr()
    arguments = ["apply", str(tmp_path / "calibration.json"), str(data), "-o", str(tmp_path / "o.csv")]
    assert main([*arguments, "--with", "ellipsoid"]) == 2
    assert "sphere" in capsys.readouterr().err
    assert json.loads((tmp_path / "calibration.json").read_text())["sphere"]["status"]
