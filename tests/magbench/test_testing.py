"""`assert_accuracy`: calibrators whose error is known, whatever they are, against limits above and below it."""

from __future__ import annotations

import json
import unittest
from pathlib import Path

import numpy as np
import pytest

from calib import Reference, get
from magbench.testing import LISTENERS, assert_accuracy
from recordings import Recording
from scenarios.errors import InputError
from sim.scenario import load
from validation.calibrating.selection import select_calibrator
from validation.comparison.design import Design
from validation.gates.score_baseline import rows_of, write_baseline

HARD_IRON = (3000.0, -1500.0, 2000.0)
MISS_NT = 7.0
SCENARIO = f"""
name = "on-the-table"
summary = "Hard iron and noise alone"
[field]
latitude_deg = 50.0
longitude_deg = 10.0
date = 2024-01-01
[vehicle]
kind = "turntable"
[[phases]]
kind = "tumble"
duration_s = 40.0
[sampling]
rate_hz = 5.0
[effects.hard_iron]
offset_nT = {list(HARD_IRON)}
[effects.white_noise]
std_nT = 5.0
"""
OWN_MODULE = f"""
def fit(recording, reference):
    return {[HARD_IRON[0], HARD_IRON[1], HARD_IRON[2] + MISS_NT]}, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
"""


def missing_by(miss_nT: float) -> tuple[list[float], np.ndarray]:
    """Offset and matrix, the offset wrong by that much."""
    return [*HARD_IRON[:2], HARD_IRON[2] + miss_nT], np.eye(3)


def always(recording: Recording, reference: Reference) -> tuple[list[float], np.ndarray]:
    """Wrong by MISS_NT in every trial."""
    return missing_by(MISS_NT)


def by_turns(recording: Recording, reference: Reference) -> tuple[list[float], np.ndarray]:
    """Wrong by 1 or 3 times MISS_NT, as the noise decides."""
    noise = float(np.abs(recording.mag_nT[0]).sum()) % 1.0
    return missing_by(MISS_NT * (1.0 if noise < 0.5 else 3.0))


def uncorrected(recording: Recording, reference: Reference) -> tuple[list[float], np.ndarray]:
    """Of a name that is taken."""
    return missing_by(0.0)


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    Path("on-the-table.toml").write_text(SCENARIO)
    Path("their_own.py").write_text(OWN_MODULE)
    offset_nT, matrix = missing_by(MISS_NT)
    Path("known.json").write_text(json.dumps({"offset_nT": offset_nT, "matrix": matrix.tolist()}))
    return "on-the-table.toml"


def test_the_known_error_is_measured_and_decides(scenario: str) -> None:
    found = assert_accuracy(always, scenario, score="offset_error", limit=7.1)
    assert found.verdict == "pass"
    assert found.measured == pytest.approx(MISS_NT, rel=1e-9)
    assert found.smallest_seen == pytest.approx(7.1, rel=1e-9), "the score hardly varies: whatever is over the limit"
    with pytest.raises(AssertionError) as failed:
        assert_accuracy(always, load(Path(scenario)), score="offset_error", limit=6.9)
    verdict, seen, advice = str(failed.value).splitlines()
    assert verdict.startswith(
        "always on on-the-table: fail: median offset_error is 7 nT, the limit 6.9 nT, exceeded in"
    )
    assert seen.startswith("smallest defect that this gate catches (99 %")
    assert advice.startswith("find what changed")


@pytest.mark.parametrize("form", ["their_own:fit", "sh -c 'cp {here}/known.json \"$1\"' {{recording.csv}} {{result}}"])
def test_a_module_and_a_command_are_calibrators_too(form: str, scenario: str, tmp_path: Path) -> None:
    text = form.format(here=tmp_path) if "{{" in form else form
    found = assert_accuracy(text, scenario, score="offset_error_nT", limit=8.0)
    assert found.measured == pytest.approx(MISS_NT, rel=1e-9)


def test_a_calibrator_in_memory_is_scored_as_the_registered_one(scenario: str) -> None:
    own = get("ellipsoid")
    found = assert_accuracy(own, scenario, score="heading_rms", ratio=1.01, reference="ellipsoid")
    assert np.all(found.values == 1.0)
    assert assert_accuracy(type(own), scenario, score="failure", limit=0.5).verdict == "pass"


def test_two_of_one_name_are_told_apart(scenario: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(always, "name", "ellipsoid", raising=False)
    found = assert_accuracy(always, scenario, score="offset_error", ratio=1e6, reference="ellipsoid")
    alone = assert_accuracy("ellipsoid", scenario, score="offset_error", limit=1e6)
    np.testing.assert_allclose(found.scores, MISS_NT)
    np.testing.assert_array_equal(found.reference_scores, alone.scores)


def test_the_raw_measurement_is_a_reference_and_has_the_whole_hard_iron(scenario: str) -> None:
    found = assert_accuracy(always, scenario, score="offset_error", ratio=0.5, reference="uncorrected")
    assert found.measured == pytest.approx(MISS_NT / np.linalg.norm(HARD_IRON), rel=1e-9)


def test_a_baseline_is_kept_or_not(scenario: str) -> None:
    design = Design.of(load(Path(scenario)), [select_calibrator(always)])
    for was, verdict in ((MISS_NT, "pass"), (MISS_NT / 2, "fail")):
        write_baseline(Path("base.parquet"), [rows_of(design, "always", "offset_error", np.full(60, was))])

        def again() -> object:
            return assert_accuracy(always, scenario, score="offset_error", baseline="base.parquet", max_trials=60)

        if verdict == "pass":
            again()
        else:
            with pytest.raises(AssertionError, match=r"is 2 x baseline, the limit 1\.1 x baseline"):
                again()


def test_what_is_left_undecided_fails_or_skips_and_says_how_many_more(scenario: str) -> None:
    def undecided(**keys: object) -> object:
        limits = {"limit": 2 * MISS_NT, "max_trials": 30}
        return assert_accuracy(by_turns, scenario, score="offset_error", **limits, **keys)  # type: ignore[arg-type]

    with pytest.raises(AssertionError, match=r"inconclusive: median.*\n.*\n.*(more trial|farther from the score)"):
        undecided()
    with pytest.raises(unittest.SkipTest, match="inconclusive"):
        undecided(inconclusive="skip")


def test_what_a_calibrator_raises_is_told(scenario: str) -> None:
    def broken(recording: Recording, reference: Reference) -> object:
        raise ZeroDivisionError("by nothing")

    with pytest.raises(AssertionError, match=r"failed in .* not_converged: ZeroDivisionError: by nothing"):
        assert_accuracy(broken, scenario, score="offset_error", limit=100.0)


def test_a_listener_is_told_of_every_gate(scenario: str, monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[dict[str, object]] = []
    monkeypatch.setattr("magbench.testing.LISTENERS", [*LISTENERS, heard.append])
    assert_accuracy(always, scenario, score="offset_error", limit=7.1)
    with pytest.raises(AssertionError):
        assert_accuracy(always, scenario, score="offset_error", limit=6.9, false_fail_rate=1e-3)
    assert [(one["verdict"], one["false_fail_rate"]) for one in heard] == [("pass", 1e-4), ("fail", 1e-3)]


@pytest.mark.parametrize(
    ("calibrator", "keys", "told"),
    [
        ("elipsoid", {"limit": 1.0}, "calibrator: no calibrator is called 'elipsoid' .did you mean ellipsoid"),
        (uncorrected, {"limit": 1.0}, "calibrator: 'uncorrected' is the raw measurement's name"),
        (5, {"limit": 1.0}, "calibrator: is of type int, no calibrator"),
        ("ellipsoid@3", {"limit": 1.0}, "calibrator: 'ellipsoid@3' is none of the trial's rows"),
        ("ellipsoid", {}, "one limit is wanted, found none"),
        ("ellipsoid", {"limit": -1.0}, "^limit: "),
        ("ellipsoid", {"limit": 1.0, "score": "offset"}, "^score: "),
        ("ellipsoid", {"limit": 1.0, "false_fail_rate": 2.0}, "^false_fail_rate: "),
        ("ellipsoid", {"limit": 1.0, "max_trials": 3}, "assert_accuracy.max_trials: within 3 trials nothing fails"),
        ("ellipsoid", {"ratio": 1.0, "reference": "spere"}, "reference: no calibrator is called 'spere'"),
        ("ellipsoid", {"baseline": "none.parquet"}, "none.parquet: no such file"),
        ("ellipsoid", {"limit": 1.0, "inconclusive": "pass"}, 'inconclusive: .*"fail" or "skip"'),
    ],
)
def test_wrong_use_is_refused(calibrator: object, keys: dict[str, object], told: str, scenario: str) -> None:
    with pytest.raises(InputError, match=told):
        assert_accuracy(calibrator, scenario, **{"score": "offset_error", **keys})  # type: ignore[arg-type]
