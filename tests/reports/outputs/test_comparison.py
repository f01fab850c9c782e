"""A comparison's files: what they say agrees, an earlier one is extended, and the rule to stop by is kept."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from reports.outputs import comparison
from reports.outputs.comparison import compare, comparison_question, summary
from scenarios.errors import InputError
from scenarios.toml import as_dict
from sim.scenario import Scenario, load
from tests.reports.page import plain, read
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design
from validation.comparison.engine import SerialEngine
from validation.comparison.trial_table import TrialTable

SHORT = ["phases.0.duration_s=120"]


@pytest.fixture(scope="module")
def design() -> Design:
    return Design.of(load("standard-full", SHORT), select_calibrators(["ellipsoid", "vector_least_squares"]), seed=3)


@pytest.fixture(scope="module")
def out(design: Design, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("comparison")
    compare(design, 6, place, SerialEngine())
    return place


def test_files_say_the_same(out: Path, design: Design):
    told = json.loads((out / "comparison.json").read_text())
    table = TrialTable.read(out)
    rows = {(row["calibrator"], row["score"]): row for row in told["table"]}
    for name in ("ellipsoid", "vector_least_squares", "uncorrected"):
        row = rows[name, "offset_error"]
        assert row["median"] == pytest.approx(np.median(table.values("offset_error", name)))
        assert row["low"] <= row["median"] <= row["high"]
        assert (row["trials"], row["unit"]) == (6, "nT")
    assert told["trials"] == 6
    assert plain(told["answer"]) in read((out / "report.html").read_text()).replace("Use ", "use ", 1)
    assert rows[told["reference"], "offset_error"]["reference_ratio"]["value"] == 1.0


def test_scores_are_ratios_to_the_bound_of_what_a_method_is_told(out: Path):
    """Six trials of methods that nearly reach it: within chance of one; no bound on what is not corrected."""
    told = json.loads((out / "comparison.json").read_text())
    ratios = {(row["calibrator"], row["score"]): row["bound_ratio"] for row in told["table"]}
    for name in ("ellipsoid", "vector_least_squares"):
        assert 0.5 < ratios[name, "offset_error"] < 1.7
    assert ratios["uncorrected", "offset_error"] is None


def test_each_trial_is_over_the_bound_of_its_own_run(tmp_path: Path):
    """Noise between 1 and 100 nT: over the first run's bound, six trials would be off by whatever that run drew."""
    vary = {"effects.white_noise.std_nT": {"uniform": [1.0, 100.0]}}
    scenario = Scenario.model_validate(as_dict(load("standard-full", SHORT)) | {"vary": vary})
    found = compare(Design.of(scenario, select_calibrators(["ellipsoid"]), seed=3), 6, tmp_path, SerialEngine())
    least = found.least[0, "ellipsoid", "offset_error_nT"]
    assert least.max() / least.min() > 1.5
    (ratio,) = [
        row["bound_ratio"]
        for row in summary(found, 3)["table"]
        if row["score"] == "offset_error" and row["calibrator"] == "ellipsoid"
    ]
    assert 0.5 < ratio < 1.7
    assert ratio == pytest.approx(np.sqrt(np.mean((found.table.values("offset_error", "ellipsoid") / least) ** 2)))


def test_three_trials_are_recorded_to_look_at(out: Path):
    assert {path.name for path in (out / "recordings").iterdir()} == {"best.rrd", "median.rrd", "worst.rrd"}


def test_a_trial_that_is_shown_twice_is_fitted_once(design: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    scored: list[object] = []
    score = comparison.calibrate_and_score
    monkeypatch.setattr(
        comparison, "calibrate_and_score", lambda *given, **more: (scored.append(1), score(*given, **more))[1]
    )
    compare(design, 1, tmp_path, SerialEngine())
    assert len(scored) == 1
    assert len(list((tmp_path / "recordings").iterdir())) == 3


def test_a_repeat_makes_changed_and_missing_recordings_alone(
    out: Path, design: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    scored: list[object] = []
    score = comparison.calibrate_and_score
    monkeypatch.setattr(
        comparison, "calibrate_and_score", lambda *given, **more: (scored.append(1), score(*given, **more))[1]
    )
    place = Path(shutil.copytree(out, tmp_path / "copy"))
    best, listed = place / "recordings" / "best.rrd", place / "recordings.jsonl"
    whole = best.read_bytes()
    for change, fitted in (
        (lambda: None, 0),
        (lambda: best.write_bytes(whole[:-1] + b"?"), 3),
        (lambda: listed.write_text(listed.read_text().replace('"run":', '"run":1')), 3),
        (best.unlink, 3),
    ):
        change()
        scored.clear()
        compare(design, 6, place, SerialEngine())
        assert len(scored) == fitted
        assert best.read_bytes()[-1:] == whole[-1:]


def test_a_larger_number_extends_and_a_smaller_one_reads_less(out: Path, design: Design):
    before = TrialTable.read(out).values("offset_error", "ellipsoid")
    assert summary(compare(design, 4, out, SerialEngine()), 3)["trials"] == 4
    after = compare(design, 8, out, SerialEngine()).table.values("offset_error", "ellipsoid")
    np.testing.assert_array_equal(after[:6], before)
    assert len(after) == 8


def test_it_ends_when_the_medians_are_known(design: Design, tmp_path: Path):
    seen: list[tuple[float, int]] = []
    asked = comparison_question(until="median holdout_sphere_component_rms +-60%")
    found = compare(design, 200, tmp_path, SerialEngine(), lambda *told: seen.append(told), asked)
    assert 20 <= found.answers[0].trials < 200
    trials = found.answers[0].trials
    assert {total for _, total in seen} == {203}, "two hundred trials, three recordings"
    assert [done for done, _ in seen] == [*range(trials + 1), *range(200, 204)]


def test_questions_that_cannot_be_answered_are_refused(design: Design, tmp_path: Path):
    with pytest.raises(InputError, match="choose among ellipsoid, vector_least_squares"):
        compare(design, 2, tmp_path, SerialEngine(), question=comparison_question(reference="sphere"))
    with pytest.raises(InputError, match="offset_error_nT"):
        comparison_question(rank_by="offset_eror")
    assert not list(tmp_path.iterdir())
