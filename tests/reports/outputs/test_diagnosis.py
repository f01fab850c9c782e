"""What a diagnosis leaves on disk: whole or not at all, the same numbers when read back, a page that answers first."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

import reports.outputs.diagnosis as outputs
import reports.viewer.diagnosis as diagnosis_recording
from diagnosis.repair.new_model import lines_of_diff
from diagnosis.result import Diagnosis
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from magbench.cli import Terminated
from magbench.diagnosis_tables import show_answer
from reports.outputs.diagnosis import FILES, write_diagnosis
from reports.pages.diagnosis import diagnosis_page
from reports.presentation.diagnosis import PresentedDiagnosis
from reports.presentation.series import DiagnosisSeries, block_means
from reports.viewer import read_series, verify
from scenarios.errors import InputError
from sim.scenario import ModelSpec, load_model
from tests.diagnosis.own_compass import with_own_compass
from tests.diagnosis.synthetic import FIELD_ENU_NT
from tests.reports.page import plain, read, without_scripts

GAIN = [2.0, -1.0, 4.0]
_made: dict[str, Diagnosis] = {}


@pytest.fixture
def found(flight, model) -> Diagnosis:  # type: ignore[no-untyped-def]
    """A hidden motor current, found."""
    if "motor" not in _made:
        _made["motor"] = diagnose(flight({"motor_current": {"gain_nT_A": GAIN}}), model())
    return _made["motor"]


@pytest.fixture
def strength(flight, model) -> Diagnosis:  # type: ignore[no-untyped-def]
    """A jump, found from the field's strength alone."""
    if "strength" not in _made:
        jump = {"offset_jump": {"time_s": 100.0, "step_nT": [6.0, -9.0, 5.0]}}
        _made["strength"] = diagnose(replace(flight(jump), att_q=None), model(), fitted_base=True)
    return _made["strength"]


@pytest.fixture
def page_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty page: drawing takes longer than all else that is written."""
    monkeypatch.setattr(outputs, "diagnosis_page", lambda *_: "")


def recorded(found: Diagnosis, folder: Path) -> Path:
    """The recording alone, on disk."""
    content = diagnosis_recording.diagnosis_recording(PresentedDiagnosis.of(found), "Diagnosis")
    (folder / "recording.rrd").write_bytes(content)
    return folder / "recording.rrd"


def test_every_file_is_written_and_the_recording_is_valid(found: Diagnosis, tmp_path: Path) -> None:
    write_diagnosis(PresentedDiagnosis.of(found), tmp_path, "Diagnosis")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(FILES)
    verify(tmp_path / "recording.rrd")
    assert len(RrdReader(tmp_path / "recording.rrd").blueprints()) == 1
    assert load_model(tmp_path / "model.toml").chain() == found.model.chain()


@pytest.mark.usefixtures("page_left_out")
def test_the_summary_is_json_even_where_a_figure_is_none(found: Diagnosis, tmp_path: Path) -> None:
    unknown = replace(found.ranking[0], nats=np.nan, needed=np.inf)
    write_diagnosis(PresentedDiagnosis.of(replace(found, ranking=(unknown,))), tmp_path, "Diagnosis")
    summary = json.loads((tmp_path / "diagnosis.json").read_text(), parse_constant=pytest.fail)
    assert (summary["candidates"][0]["evidence_nats"], summary["candidates"][0]["needed_nats"]) == (None, None)
    assert summary["model_out"] == "model.toml"


def test_the_recording_holds_both_sides_and_the_gap(found: Diagnosis, tmp_path: Path) -> None:
    path = recorded(found, tmp_path)
    series = {name: read_series(path, name)[1] for name in ("mag", "simulated/before", "simulated/after")}
    assert np.array_equal(series["mag"], found.problem.recording.mag_nT)
    assert series["simulated/before"] == pytest.approx(found.problem.predicted_nT)
    noise = [float((series["mag"] - series[f"simulated/{side}"]).std()) for side in ("before", "after")]
    assert noise[0] > 2.5
    assert noise[1] == pytest.approx(2.0, rel=0.02)
    hidden = found.problem.recording.current_A
    assert hidden is not None
    added = series["simulated/after"] - series["simulated/before"]
    assert added == pytest.approx(hidden.sum(axis=1)[:, None] * GAIN, abs=0.2, rel=0.02)
    residual = read_series(path, "residual/after")[1]
    used = found.problem.usable > 0
    assert np.array_equal(residual[used], found.after_nT[used])
    assert np.isnan(residual[~used]).all()


def test_a_spike_stays_in_what_was_measured_and_out_of_the_gap(flight, model, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    found = diagnose(flight({"spikes": {"rate_hz": 0.2, "amplitude_nT": 300.0}}), model())
    path = recorded(found, tmp_path)
    out = found.problem.usable == 0
    assert out.any()
    assert np.array_equal(read_series(path, "mag")[1], found.problem.recording.mag_nT)
    assert np.isnan(read_series(path, "residual/before")[1][out]).all()


def test_space_and_the_channels_it_goes_with_are_there(found: Diagnosis, tmp_path: Path) -> None:
    entities = {c.entity_path for c in RrdReader(recorded(found, tmp_path)).stream().to_chunks()}
    world = ("path", "gap/before", "gap/after", "place", "place/vehicle", "place/vehicle/gap/before")
    assert {f"/world/{name}" for name in world} <= entities
    assert {f"/channel/{name}" for name, _, _ in found.where} <= entities


@pytest.mark.usefixtures("undrawn")
def test_without_position_or_attitude_the_recording_has_what_there_is(strength: Diagnosis, tmp_path: Path) -> None:
    bare = replace(strength.problem.recording, pos_enu_m=None)
    found = replace(strength, problem=replace(strength.problem, recording=bare))
    path = recorded(found, tmp_path)
    verify(path)
    assert not [c for c in RrdReader(path).stream().to_chunks() if c.entity_path.startswith("/world/")]
    measured, after = (read_series(path, f"strength/{name}")[1] for name in ("measured", "after"))
    used = found.problem.usable > 0
    assert (measured - after)[used] == pytest.approx(found.after_nT[used, 0], abs=1e-6)
    assert "along the path" not in diagnosis_page(PresentedDiagnosis.of(found), "Diagnosis")


def test_strength_and_dip_stand_beside_each_other(tmp_path: Path) -> None:
    given = with_own_compass(0.05, np.eye(3), gain_nT_A=30.0)
    found = diagnose(given, ModelSpec(), field_enu_nT=FIELD_ENU_NT, fitted_base=True)
    path = recorded(found, tmp_path)
    verify(path)
    _, north, up = FIELD_ENU_NT
    dip_nT = np.arctan2(-up, np.hypot(FIELD_ENU_NT[0], north)) * np.linalg.norm(FIELD_ENU_NT)
    for a, (name, size_nT) in enumerate((("strength", np.linalg.norm(FIELD_ENU_NT)), ("dip", dip_nT))):
        measured, after = (read_series(path, f"{name}/{side}")[1] for side in ("measured", "after"))
        used = found.problem.usable > 0
        assert measured[used].mean() == pytest.approx(size_nT, rel=2e-3)
        assert (measured - after)[used] == pytest.approx(found.after_nT[used, a], abs=1e-6)
    assert read_series(path, "residual/after")[1].shape == (len(given), 2)
    assert "strength and dip were compared" in without_scripts(
        diagnosis_page(PresentedDiagnosis.of(found), "Diagnosis")
    )


def test_long_recordings_are_thinned_by_block_means(
    found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(diagnosis_recording, "MOST_ROWS", 1000)
    path = recorded(found, tmp_path)
    time_s, mag = read_series(path, "mag")
    length = -(-len(found.problem.recording) // 1000)
    assert len(mag) <= 1000
    assert mag[7] == pytest.approx(found.problem.recording.mag_nT[7 * length : 8 * length].mean(axis=0))
    assert time_s[7] == pytest.approx(found.problem.state.time_s[7 * length : 8 * length].mean())
    chunks = {c.entity_path: c.to_record_batch() for c in RrdReader(path).stream().to_chunks()}
    assert f"mean of {length} samples" in chunks["/notes"].column("TextDocument:text").to_pylist()[0][0]


def test_block_means_leave_out_what_is_no_measurement() -> None:
    values, usable = np.array([1.0, 3.0, 100.0, 5.0, 7.0]), np.array([1.0, 1.0, 0.0, 1.0, 1.0])
    assert block_means(values, 2, usable).tolist() == [2.0, 5.0, 7.0]
    assert np.isnan(block_means(values, 1, usable)[2])


def test_places_begin_at_zero_and_keep_large_coordinates(found: Diagnosis) -> None:
    recording = found.problem.recording
    assert recording.pos_enu_m is not None
    far = replace(recording, pos_enu_m=recording.pos_enu_m + np.array([5e5, 5e6, 0.0]))
    moved, series = (DiagnosisSeries.of(replace(found, problem=replace(found.problem, recording=one)))
                     for one in (far, recording))  # fmt: skip
    assert moved.path.pos_m is not None
    assert moved.path.pos_m == pytest.approx(series.path.pos_m, abs=1e-6)
    assert moved.pos_m == pytest.approx(series.pos_m, abs=1e-6)


def test_a_difference_of_the_iron_shows_as_the_models_stand(flight, model) -> None:  # type: ignore[no-untyped-def]
    """The base takes a hard iron up whole: only measured minus simulated without refitting can show it."""
    found = diagnose(flight({"sensor_offset": {"offset_nT": [40.0, 0.0, 0.0]}}), model())
    series = DiagnosisSeries.of(found)
    before_nT, after_nT = (gap.mean(axis=0) for gap in series.difference.sides.values())
    assert np.abs(before_nT) == pytest.approx([40, 0, 0], abs=0.3)
    assert np.abs(after_nT).max() < 0.3
    assert np.linalg.norm(np.nanmean(series.path.gap.before_nT, axis=0)) == pytest.approx(40, abs=0.5)


@pytest.mark.usefixtures("page_left_out")
@pytest.mark.parametrize("failure", [Terminated(15), InputError("no", where="here", do="that"), MemoryError()])
def test_what_ends_early_leaves_the_old_files_as_they_were(
    failure: BaseException, found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> bytes:
        raise failure

    for name in FILES:
        (tmp_path / name).write_text("old")
    monkeypatch.setattr(outputs, "diagnosis_recording", fail)
    with pytest.raises(type(failure)):
        write_diagnosis(PresentedDiagnosis.of(found), tmp_path, "Diagnosis")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == dict.fromkeys(FILES, "old")


@pytest.mark.usefixtures("page_left_out")
def test_a_place_that_cannot_be_written_is_told_and_nothing_is_left(found: Diagnosis, tmp_path: Path) -> None:
    (tmp_path / "recording.rrd").mkdir()
    with pytest.raises(InputError, match=r"recording\.rrd"):
        write_diagnosis(PresentedDiagnosis.of(found), tmp_path, "Diagnosis")
    assert [path.name for path in tmp_path.iterdir()] == ["recording.rrd"]


def test_the_diff_is_what_was_added(found: Diagnosis, flight, model) -> None:  # type: ignore[no-untyped-def]
    lines = lines_of_diff(found.given, found.model)
    added = [line for line in lines if line.startswith("+") and not line.startswith("+++")]
    assert "+[effects.motor_current]" in added
    cut = [line for line in lines if line.startswith("-") and not line.startswith("---")]
    assert [line.split(" = ")[0] for line in cut] == ["-effect_order"]
    none = diagnose(flight({}), model())
    assert not lines_of_diff(none.given, none.model)


def test_the_page_answers_before_it_draws(found: Diagnosis) -> None:
    page = diagnosis_page(PresentedDiagnosis.of(found), "Diagnosis <of> a log")
    text = read(page.partition("<img")[0])
    assert "Diagnosis &lt;of&gt; a log" in text
    for answer in (
        found.verdict,
        found.named[0].name,
        "nats",
        "could also be",
        "removed on held-out data",
        *found.advice,
    ):
        assert plain(answer) in text
    assert "along the path" in page
    assert not re.search(r"(src|href)=\"(?!data:|#)", without_scripts(page))


@pytest.mark.usefixtures("undrawn")
def test_a_class_is_told_plainly(
    found: Diagnosis, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    named = (replace(found.named[0], alternatives=("latency", "bandwidth")),)
    several = replace(found, named=named, verdict=Verdict.CLASS)
    text = diagnosis_page(PresentedDiagnosis.of(several), "Diagnosis").partition("<img")[0]
    assert "<b>latency, bandwidth</b><span>could also be</span>" in text
    show_answer(PresentedDiagnosis.of(several))
    assert "latency, bandwidth" in capsys.readouterr().out


def test_the_terminal_tells_all_of_it(found: Diagnosis, capsys: pytest.CaptureFixture[str]) -> None:
    long = replace(found, sentence="word " * 100 + "end.", advice=("Fly circles.", "Log currents."))
    show_answer(PresentedDiagnosis.of(long))
    told = capsys.readouterr().out
    for text in ("end.", "1. Fly circles.", "2. Log currents.", "+[effects.motor_current]", "models without refit"):
        assert text in told


@pytest.mark.slow
def test_a_command_that_is_ended_leaves_nothing_half_written(flight, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """A signal at any moment: either all four files or no directory at all."""
    recording = flight({"motor_current": {"gain_nT_A": GAIN}})
    rows = np.column_stack([recording.time_s, recording.mag_nT])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header="time_s,mag_x_nT,mag_y_nT,mag_z_nT", comments="")
    asked = ["diagnose", str(tmp_path / "log.csv"), "--field-strength-nT", "52219", "-o", str(tmp_path / "out")]
    ended = set()
    for delay_s in np.linspace(1.0, 12.0, 12):
        process = subprocess.Popen([sys.executable, "-m", "magbench", *asked], stderr=-1, stdout=-1, text=True)
        time.sleep(delay_s)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=120)
        ended.add(process.returncode)
        left = sorted(path.name for path in (tmp_path / "out").iterdir()) if (tmp_path / "out").exists() else []
        assert left in ([], sorted(FILES))
        shutil.rmtree(tmp_path / "out", ignore_errors=True)
    assert 128 + signal.SIGTERM in ended
