"""Calibrate one recording, apply the file to another."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from magbench.cli import main
from recordings import Recording, read_recording, read_run, write_recording
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
    assert names == {"calibration.json", "report.html"} | folders
    out = tmp_path / "corrected.parquet"
    assert main(["apply", str(tmp_path / "calibration.json"), str(data), "--run", "1", "-o", str(out)]) == 0
    raw, truth = read_run(data, run=1)
    before = np.sqrt(((raw.mag_nT - truth.field_nT) ** 2).mean())
    after = np.sqrt(((read_recording(out).mag_nT - truth.field_nT) ** 2).mean())
    assert after < 0.1 * before
    page = (tmp_path / "corrected.html").read_text()
    assert "the calibration fits the recording" in page
    assert "magbench recheck" in page


def test_the_strength_before_and_after_is_told_and_a_page_only_where_asked(data: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    """A calibration of another sensor makes the strength vary more, and is told."""
    raw_nT = read_recording(data).mag_nT
    for scale, words in ((1.0, "takes off little"), (3.0, "does not fit")):
        matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, scale]]
        (tmp_path / "c.json").write_text(edited(matrix=matrix))
        arguments = ["apply", str(tmp_path / "c.json"), str(data), "-o", str(tmp_path / "o.csv"), "--no-page"]
        assert main([*arguments, "--json"]) == 0
        told = json.loads(capsys.readouterr().out)
        sizes = [np.linalg.norm(one, axis=1).std() for one in (raw_nT, (raw_nT - GOOD["offset_nT"]) @ np.array(matrix))]
        np.testing.assert_allclose(told["strength"]["ellipsoid"]["std_nT"], sizes, rtol=1e-9)
        assert words in told["answer"]
        assert "page" not in told
    assert not (tmp_path / "o.html").exists()


GOOD = {"status": "ok", "offset_nT": [10.0, 20.0, 30.0], "matrix": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.1]]}
FLAT = [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
LONG = "1" * 5000


def edited(**changes: object) -> str:
    """A calibration file, edited by hand."""
    return json.dumps({"ellipsoid": GOOD | changes})


BAD_FILES = {
    "cut off": ("{", "not JSON"),
    "empty": ("", "not JSON"),
    "nothing in it": ("{}", "no calibration"),
    "a list": (f"[{json.dumps(GOOD)}]", "no calibration"),
    "a number": ('{"a": 5}', "JSON object"),
    "nested too deep": ("[" * 100_000, "nested"),
    "another schema": (edited(schema=2), "schema"),
    "not a number": (edited().replace("10.0", "NaN"), "NaN"),
    "infinite": (edited().replace("10.0", "1e999"), "1e999 is not a finite number"),
    "an endless number": (edited().replace("10.0", LONG), "not JSON: Exceeds the limit"),
    "null in a vector": (edited(offset_nT=[1, None, 3]), "offset_nT"),
    "text": (edited(offset_nT=["1", "2", "3"]), "offset_nT"),
    "too short": ('{"a": {"matrix": [1]}}', "matrix"),
    "ragged": (edited(matrix=[[1, 0, 0], [0, 1], [0, 0, 1]]), "matrix"),
    "no offset": ('{"a": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}', "offset_nT"),
    "singular": (edited(matrix=FLAT), "singular"),
    "singular with an eddy term": (edited(matrix=FLAT, eddy_s=np.diag([0.01] * 3).tolist()), "singular"),
    "singular in a segment": (edited(segments=[{"start_s": 0, "offset_nT": [0, 0, 0], "matrix": FLAT}]), "singular"),
    "an offset that is none": (edited(offset_nT=[1e300, 0, 0]), "offset"),
    "unknown status": (edited(status="fine"), "fine"),
    "no estimate": (edited(status="not_converged", reason="too\nslow", offset_nT=None, matrix=None), "too slow"),
    "several sensors": (json.dumps({"sphere@1": GOOD}), "sphere@1"),
}


@pytest.mark.parametrize("kind", BAD_FILES)
def test_bad_calibration_files(kind: str, data: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    text, named = BAD_FILES[kind]
    (tmp_path / "c.json").write_text(text)
    assert main(["apply", str(tmp_path / "c.json"), str(data), "-o", str(tmp_path / "o.csv")]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert named in lines[0]
    assert not (tmp_path / "o.csv").exists()


@pytest.mark.parametrize(
    "text",
    [edited(), "\ufeff" + edited(), json.dumps(GOOD), json.dumps({"calibrations": {"ellipsoid": GOOD}})],
    ids=["calibration.json", "byte order mark", "one alone", "what calibrate --json prints"],
)
def test_good_calibration_files(text: str, data: Path, tmp_path: Path) -> None:
    (tmp_path / "c.json").write_text(text, encoding="utf-8")
    assert main(["apply", str(tmp_path / "c.json"), str(data), "-o", str(tmp_path / "o.parquet")]) == 0
    expected = (read_recording(data).mag_nT - GOOD["offset_nT"]) @ np.diag([1.0, 1.0, 1.1])
    np.testing.assert_allclose(read_recording(tmp_path / "o.parquet").mag_nT, expected, atol=1e-9)


def test_an_unobservable_calibration_is_applied_with_a_warning(data: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "c.json").write_text(edited(status="unobservable", reason="the motion is flat"))
    assert main(["apply", str(tmp_path / "c.json"), str(data), "-o", str(tmp_path / "o.csv"), "--json"]) == 0
    told = capsys.readouterr()
    assert "ellipsoid is unobservable: the motion is flat" in told.err
    assert json.loads(told.out)["warning"] == "ellipsoid is unobservable: the motion is flat"


def test_what_it_is_made_from_is_not_overwritten(data: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    calibration, log = tmp_path / "c.csv", tmp_path / "log.csv"
    calibration.write_text(edited())
    assert main(["apply", str(calibration), str(data), "-o", str(log)]) == 0
    (tmp_path / "link.csv").symlink_to(log)
    capsys.readouterr()
    for source, out in [
        (log, log),
        (log, tmp_path / "link.csv"),
        (log, calibration),
        (data, data / "run-00001.parquet"),
    ]:
        before = out.read_bytes()
        assert main(["apply", str(calibration), str(source), "-o", str(out)]) == 2
        assert "would replace" in capsys.readouterr().err
        assert out.read_bytes() == before


def test_a_page_of_another_command_is_not_overwritten(data: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    calibration, page = tmp_path / "c.json", tmp_path / "report.html"
    calibration.write_text(edited())
    arguments = ["apply", str(calibration), str(data), "-o", str(tmp_path / "report.parquet")]
    page.write_text("<title>tumble · magbench calibrate</title>")
    assert main(arguments) == 2
    assert f"{page}: is another command's page" in capsys.readouterr().err
    assert not (tmp_path / "report.parquet").exists()
    assert main([*arguments, "--no-page"]) == 0
    page.unlink()
    assert [main(arguments), main(arguments)] == [0, 0]
    assert "magbench apply" in page.read_text(encoding="utf-8")


def test_unknown_calibration(data: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    assert main(["calibrate", str(data), "--with", "sphere", "-o", str(tmp_path)]) == 0
    capsys.readouterr()
    arguments = ["apply", str(tmp_path / "calibration.json"), str(data), "-o", str(tmp_path / "o.csv")]
    assert main([*arguments, "--with", "ellipsoid"]) == 2
    assert "sphere" in capsys.readouterr().err
    assert json.loads((tmp_path / "calibration.json").read_text())["sphere"]["status"]


def test_a_calibration_that_has_no_inverse_at_a_row_writes_nothing(tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    """B = -[z]x and omega = z in row 18: I - B [omega]x = diag(0, 0, 1)."""
    rng = np.random.default_rng(1)
    rate = 0.1 * rng.standard_normal((40, 3))
    rate[17] = [0.0, 0.0, 1.0]
    eddy = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    recording = Recording(np.arange(40.0), 3e4 * rng.standard_normal((40, 3)), gyro_rad_s=rate)
    write_recording(recording, tmp_path / "log.csv")
    (tmp_path / "c.json").write_text(edited(matrix=np.eye(3).tolist(), eddy_s=eddy))
    assert main(["apply", str(tmp_path / "c.json"), str(tmp_path / "log.csv"), "-o", str(tmp_path / "o.csv")]) == 2
    assert "corrects row" in capsys.readouterr().err
    assert not (tmp_path / "o.csv").exists()


def test_a_refused_export_ends_with_2_after_the_table_and_the_good_files(tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    angle = np.linspace(0.0, 40.0, 400)
    level = np.column_stack([2e4 * np.cos(angle) + 9e3, 2e4 * np.sin(angle), np.full(400, -4e4)])
    level += 50.0 * np.random.default_rng(0).standard_normal(level.shape)
    write_recording(Recording(0.1 * np.arange(400), level), tmp_path / "level.csv")
    named = ["--with", "sphere,planar", "--export", "px4"]
    fit = ["calibrate", str(tmp_path / "level.csv"), "--field-strength-nT", "45000", *named]
    assert main([*fit, "-o", str(tmp_path / "out")]) == 2
    told = capsys.readouterr()
    assert told.err.splitlines()[-1].startswith("magbench: --export: not exported: px4 of sphere: ")
    assert "unobservable │" in told.out
    assert "0.00 0.00 0.00" not in told.out
    assert sorted(path.name for path in (tmp_path / "out").rglob("*") if path.is_file()) == [
        "calibration.json",
        "px4.params",
        "report.html",
    ]
