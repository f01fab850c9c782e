"""The functions for notebooks and scripts: every kind of data and of mistake, and results that show themselves."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

import magbench
from magbench import InputError
from magbench.api.calibration_results import CalibrationResult
from magbench.api.displayed import Displayed
from recordings import Recording, write_recording
from scenarios.arrays import Array
from tests.short import short

STRENGTH_NT = 48_000.0
OFFSET_NT = np.array([3000.0, -2000.0, 5000.0])
TABLE = "turntable-twelve-stops"


def measured() -> Array:
    """A field (500, 3) of known offset and scale in every direction, with noise of 5 nT."""
    rng = np.random.default_rng(0)
    direction = rng.standard_normal((500, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return np.asarray(STRENGTH_NT * direction * [1.1, 0.9, 1.0] + OFFSET_NT + 5 * rng.standard_normal((500, 3)))


def columns(mag_nT: Array) -> dict[str, Array]:
    return {"time_s": 0.1 * np.arange(len(mag_nT)), **{f"mag_{a}_nT": mag_nT[:, k] for k, a in enumerate("xyz")}}


def as_csv(mag_nT: Array, place: Path) -> Path:
    pd.DataFrame(columns(mag_nT)).to_csv(place / "log.csv", index=False)
    return place / "log.csv"


KINDS: dict[str, Callable[[Array, Path], Any]] = {
    "array": lambda mag_nT, _: mag_nT,
    "single precision": lambda mag_nT, _: mag_nT.astype(np.float32),
    "lists": lambda mag_nT, _: mag_nT.tolist(),
    "dict": lambda mag_nT, _: columns(mag_nT),
    "pandas": lambda mag_nT, _: pd.DataFrame(columns(mag_nT)),
    "arrow": lambda mag_nT, _: pa.table(columns(mag_nT)),
    "recording": lambda mag_nT, _: Recording(0.1 * np.arange(len(mag_nT)), mag_nT),
    "path": as_csv,
    "text": lambda mag_nT, place: str(as_csv(mag_nT, place)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_data_is_calibrated_inspected_and_corrected(kind: str, tmp_path: Path) -> None:
    data = KINDS[kind](measured(), tmp_path)
    found = magbench.calibrate(data, STRENGTH_NT)
    np.testing.assert_allclose(found.offset_nT, OFFSET_NT, atol=2)
    corrected_nT = magbench.apply(found, data)
    np.testing.assert_allclose(np.linalg.norm(corrected_nT, axis=1), STRENGTH_NT, atol=30)
    np.testing.assert_array_equal(corrected_nT, found.corrected_nT)
    assert len(magbench.inspect(data).log) == len(measured())


def test_columns_are_renamed_and_converted() -> None:
    frame = pd.DataFrame(columns(measured() / 1000)).rename(columns=lambda name: name.replace("mag_", "b")[:2])
    maps = ["time_s=ti", *(f"mag_{axis}_nT=b{axis},unit=uT" for axis in "xyz")]
    found = magbench.calibrate(frame, STRENGTH_NT, maps=maps)
    np.testing.assert_allclose(found.offset_nT, OFFSET_NT, atol=2)


def test_several_calibrators_come_by_name_and_the_time_of_an_array_is_used() -> None:
    found = magbench.calibrate(measured(), STRENGTH_NT, with_=["sphere", "twostep"], time_s=np.arange(500.0) / 50)
    assert list(found) == ["sphere", "twostep"]
    assert found["sphere"].recording.time_s[-1] == 499 / 50
    assert isinstance(found["sphere"], CalibrationResult)


def test_a_vector_is_a_reference_too() -> None:
    found = magbench.calibrate(measured(), field_enu_nT=(0, 0.6 * STRENGTH_NT, -0.8 * STRENGTH_NT))
    assert found.reference.strength_nT == pytest.approx(STRENGTH_NT)


WITH_GAPS = np.where(np.arange(1500).reshape(500, 3) == 4, np.nan, measured())
MISTAKES: dict[str, tuple[Any, str]] = {
    "a number": (5, "data: is of type int"),
    "nothing": (None, "data: is of type NoneType"),
    "words": (["a", "b"], "not numbers"),
    "text in an array": (measured().astype(str), "not numbers"),
    "complex numbers": (measured() + 0j, "not numbers"),
    "ragged rows": ([[1.0, 2.0], [3.0]], "differ in length"),
    "columns for rows": (measured().T, r"shape \(3, 500\) .*pass its transpose"),
    "two axes": (measured()[:, :2], r"shape \(500, 2\), not \(n, 3\)"),
    "one axis": (measured()[:, 0], r"shape \(500,\)"),
    "a missing value": (WITH_GAPS, "mag_y_nT: 1 of 500 values are missing or infinite, the first in row 2"),
    "another unit": (measured() / 1000, "it looks like uT"),
    "too few rows": (measured()[:4], "holds 4 samples"),
    "no rows": (np.zeros((0, 3)), "holds 0 samples"),
    "a frame without time": (pd.DataFrame(measured()), "there is no column mag_x_nT"),
    "a dict of unequal columns": ({"time_s": [0.0], "mag_x_nT": [1.0, 2.0]}, "data frame: cannot be read"),
    "a dict of tables": ({"time_s": np.zeros((3, 3))}, "time_s: is not a column"),
    "a recording of odd shape": (Recording(np.arange(3.0), measured()), "recording: time_s has shape"),
    "a path to nowhere": ("nowhere.csv", "nowhere.csv: no such file"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_the_data_is_told_with_what_to_pass(mistake: str) -> None:
    data, told = MISTAKES[mistake]
    with pytest.raises(InputError, match=told) as error:
        magbench.calibrate(data, STRENGTH_NT)
    assert error.value.do
    assert "--" not in str(error.value)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({}, "give field_strength_nT"),
        ({"field_strength_nT": 48}, "field_strength_nT: a field of 48 nT .* looks like uT"),
        ({"field_strength_nT": "strong"}, "field_strength_nT: 'strong' is not a number"),
        ({"field_enu_nT": (1, 2)}, "field_enu_nT: .* not a field vector"),
        ({"field_enu_nT": "1,2,3"}, "field_enu_nT: .* not a field vector"),
        ({"field_strength_nT": STRENGTH_NT, "with_": "elipsoid"}, "no calibrator is called 'elipsoid'"),
        ({"field_strength_nT": STRENGTH_NT, "time_s": np.arange(3.0)}, "time_s: has shape"),
        ({"field_strength_nT": STRENGTH_NT, "maps": ["mag_x_nT=bx"]}, "maps mag_x_nT=bx: there is no column 'bx'"),
    ],
)
def test_a_mistake_in_an_argument_is_told_by_its_name(arguments: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told):
        magbench.calibrate(measured(), **arguments)


def test_a_recording_of_an_array_wants_a_list_of_calibrators() -> None:
    mag_nT = measured()
    recording = Recording(np.arange(500.0), mag_nT, array_mag_nT=np.stack([mag_nT, mag_nT + 100]))
    with pytest.raises(InputError, match="with_: the recording is of an array"):
        magbench.calibrate(recording, STRENGTH_NT)
    found = magbench.calibrate(recording, STRENGTH_NT, with_=["sphere"])
    np.testing.assert_allclose(found["sphere@2"].offset_nT - found["sphere@1"].offset_nT, 100, atol=1e-6)


def test_a_failed_calibration_is_not_applied() -> None:
    found = magbench.calibrate(measured(), STRENGTH_NT, with_="kalman")
    assert found.status.kind == "not_applicable"
    with pytest.raises(InputError, match="kalman: gave no calibration"):
        magbench.apply(found, measured())


def test_a_calibration_that_flattens_the_field_is_not_applied() -> None:
    """A singular matrix, and an eddy term whose I - B [omega]x is diag(0, 0, 1) at a rate of 1 rad/s about z."""
    found = magbench.calibrate(measured(), STRENGTH_NT)
    flat = dataclasses.replace(found, matrix=np.diag([1.0, 1.0, 0.0]))
    with pytest.raises(InputError, match="ellipsoid: is no calibration: its matrix is singular"):
        magbench.apply(flat, measured())
    eddy = dataclasses.replace(found, matrix=np.eye(3), eddy_s=np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 0]]))
    turning = Recording(np.arange(500.0), measured(), gyro_rad_s=np.tile([0.0, 0.0, 1.0], (500, 1)))
    with pytest.raises(InputError, match=r"corrects row 1 to no finite field \(500 rows"):
        magbench.apply(eddy, turning)


def shown(result: Displayed, rows: int) -> str:
    """What a notebook shows: a line or few of text, a picture, and a table of so many rows."""
    assert len(repr(result)) < 500
    html = result._repr_html_()
    assert "data:image/" in html
    assert html.count("<tr") == rows + 1
    assert not re.search(r"[1-9]\.\d{4,}", html.split("<table", 1)[1])
    assert result.plot().axes
    assert len(result.to_frame()) == rows
    return repr(result)


def test_a_calibration_shows_itself() -> None:
    found = magbench.calibrate(measured(), STRENGTH_NT)
    assert shown(found, 3).startswith("ellipsoid: ok, offset (2999.")
    np.testing.assert_array_equal(found.to_frame()["offset_nT"], found.offset_nT)


def test_an_inspection_shows_itself() -> None:
    found = magbench.inspect(measured())
    assert "nothing to mend" in shown(found, len(found.findings))
    raw = magbench.inspect(measured() / 1000)
    assert "uT" in repr(raw)


def test_a_run_shows_itself_and_writes_where_it_is_told_to(tmp_path: Path) -> None:
    found = magbench.run(TABLE)
    assert shown(found, 4).startswith(f"{TABLE}: use {found.answer().use}: ")
    assert found.to_frame().index[0] == found.ranking()[0][0]
    written = magbench.run(magbench.load(TABLE), tmp_path / "out")
    assert (tmp_path / "out" / "report.html").is_file()
    assert written.ranking() == found.ranking()


def test_simulated_data_are_a_recording_and_its_truth() -> None:
    recording, truth = magbench.simulate(TABLE, overrides=["effects.white_noise.std_nT=[0, 0, 0]"], seed=5)
    np.testing.assert_allclose(truth.field_nT + sum(truth.effects.values()), recording.mag_nT, atol=1e-6)
    assert repr(recording).startswith("Recording: 3000 samples of one magnetometer")
    assert repr(truth).startswith("Truth: 3000 samples; ")
    with pytest.raises(InputError, match="did you mean turntable-twelve-stops"):
        magbench.simulate("turntable-twelve-stop")
    with pytest.raises(InputError, match="takes no overrides"):
        magbench.simulate(magbench.load(TABLE), overrides=["seed=1"])


def test_a_diagnosis_takes_data_in_memory_and_shows_itself() -> None:
    recording, _ = magbench.simulate(short("auv-spiral-excited", "effects.motor_current.gain_nT_A=[20, -10, 40]"))
    found = magbench.diagnose(recording, "auv-spiral-excited")
    told = repr(found)
    assert told.startswith(f"{found.verdict}: ")
    assert len(told) < 1000
    assert list(found.to_frame().columns) == ["effect", "parameter", "value", "low", "high", "unit"]
    assert "data:image/" in found._repr_html_()


SHORT = ["phases.0.duration_s=40"]
GATE = """
[[gate]]
name = "near"
scenario = "tumble"
set = ["phases.0.duration_s=40"]
calibrator = "ellipsoid"
score = "heading_rms_deg"
limit = {limit}
"""


def test_a_comparison_in_this_process_is_that_of_processes(tmp_path: Path) -> None:
    found = magbench.compare("tumble", trials=2, with_=["sphere", "ellipsoid"], overrides=SHORT)
    assert found.to_frame()["calibrator"].nunique() == 3  # and the raw measurement
    assert found.plot().axes
    again = magbench.compare("tumble", tmp_path, trials=2, with_=["sphere", "ellipsoid"], overrides=SHORT, jobs=2)
    assert again.summary() == found.summary()
    assert repr(again) in (tmp_path / "comparison.json").read_text()


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: magbench.compare("tumble", trials=0, with_="sphere"), "trials: 0 is too few"),
        (lambda: magbench.compare("tumble", jobs=0), "jobs: 0 is too few"),
        (lambda: magbench.gate("gates.toml", jobs=-1), "jobs: -1 is too few"),
        (lambda: magbench.reproduce("long2013", seeds=1), "seeds: 1 is too few"),
    ],
)
def test_a_count_that_is_too_small_is_refused(call: Callable[[], object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        call()


@pytest.mark.parametrize(("limit", "failed"), [(90.0, 0), (1e-9, 1)])
def test_a_file_of_gates_is_decided(limit: float, failed: int, tmp_path: Path) -> None:
    (tmp_path / "gates.toml").write_text(GATE.format(limit=limit), encoding="utf-8")
    found = magbench.gate(tmp_path / "gates.toml")
    assert len(found.failed) == failed
    assert list(found.to_frame()["gate"]) == ["near"]
    assert found.plot().axes


def test_several_files_are_diagnosed_together(tmp_path: Path) -> None:
    scenario = short("auv-spiral-excited", "effects.motor_current.gain_nT_A=[20, -10, 40]")
    paths = [tmp_path / f"dive{seed}.parquet" for seed in (1, 2)]
    for seed, path in enumerate(paths, start=1):
        write_recording(magbench.simulate(scenario, seed=seed)[0], path)
    found = magbench.diagnose(paths, "auv-spiral-excited", out=tmp_path / "out")
    assert found.names == ("dive1", "dive2")
    assert (tmp_path / "out" / "01-dive1" / "report.html").is_file()
    assert found.to_frame()["effect"].eq("motor_current").all()


def test_every_public_name_is_there() -> None:
    assert all(getattr(magbench, name) is not None for name in magbench.__all__)
    assert set(magbench.__all__) <= set(dir(magbench))
    with pytest.raises(AttributeError, match="run_scenario"):
        _ = magbench.run_everything  # type: ignore[attr-defined]


def test_functions_are_there_before_numpy_is(run_python: Callable[[str], Any]) -> None:
    code = "import sys, magbench; magbench.calibrate; sys.exit('numpy' in sys.modules)"
    assert run_python(code).returncode == 0


UNUSED = {"mujoco", "matplotlib", "pandas", "scipy.signal", "scipy.stats", "sim.scenario", "sim.effects", "diagnosis"}
"""Costly imports that a calibration of a log and a first look at it have no use for."""


@pytest.mark.parametrize("command", ["calibrate", "inspect"])
def test_a_log_is_read_without_simulator_pictures_and_statistics(
    command: str, tmp_path: Path, run_python: Callable[[str], Any]
) -> None:
    columns = np.column_stack([0.01 * np.arange(60), measured()[:60]])
    np.savetxt(tmp_path / "log.csv", columns, "%.3f", ",", header="time_s,mag_x_nT,mag_y_nT,mag_z_nT", comments="")
    call = f"main([{command!r}, {str(tmp_path / 'log.csv')!r}, '--field-strength-nT', '48000'])"
    code = f"import sys; from magbench.cli import main; {call}; sys.exit(' '.join({UNUSED} & set(sys.modules)))"
    assert not run_python(code).stderr.split("\n")[-2:][0]


def test_a_diagnosis_without_files_loads_no_pictures(run_python: Callable[[str], Any]) -> None:
    code = "import sys; from magbench.api.diagnose import _write; _write(None, None, (), print)"
    assert not run_python(f"{code}; sys.exit(' '.join({{'matplotlib', 'rerun'}} & set(sys.modules)))").stderr.strip()


def test_several_calibrations_are_not_taken_for_one() -> None:
    several: Any = magbench.calibrate(measured(), STRENGTH_NT, with_=["sphere", "ellipsoid"])
    with pytest.raises(InputError, match="of several, one by its name"):
        magbench.apply(several, measured())
    assert [*magbench.calibrate(measured(), STRENGTH_NT, with_=[])] == ["sphere", "ellipsoid"]


def test_a_diagnosis_takes_times_and_a_policy() -> None:
    from magbench.diagnosis.policy import Policy

    with pytest.raises(InputError, match="501 are needed"):
        magbench.diagnose(
            measured(), field_strength_nT=STRENGTH_NT, time_s=0.1 * np.arange(500), policy=Policy(least_samples=501)
        )


def test_a_mistake_is_one_line_in_a_notebook() -> None:
    with pytest.raises(InputError) as refused:
        magbench.calibrate(measured(), with_=["elipsoid"])
    (line,) = refused.value._render_traceback_()
    assert line.startswith("InputError: ")
    assert "ellipsoid" in line
