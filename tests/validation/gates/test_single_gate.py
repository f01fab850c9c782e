"""A gate of one calibrator, run in this process: its limit, its reference, its sensor, what is wrong by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calib import Reference
from recordings import Recording
from scenarios.errors import InputError
from sim.scenario import Scenario
from tests.short import short
from validation.calibrating.processes import TIME_LIMIT_S
from validation.calibrating.selection import select_calibrator
from validation.comparison.design import Design
from validation.comparison.trial import run_trial
from validation.gates.gate_outcome import GateOutcome
from validation.gates.score_baseline import rows_of, write_baseline
from validation.gates.single_gate import LONGEST_NAME, GateSubject, decide_single_gate

SCENARIO = Scenario.model_validate(
    {
        "name": "on-the-table",
        "summary": "Hard iron and noise alone",
        "seed": 3,
        "field": {"enu_nT": [1000.0, 20000.0, -40000.0]},
        "vehicle": {"kind": "turntable"},
        "phases": [{"kind": "tumble", "duration_s": 20.0}],
        "sampling": {"rate_hz": 2.0},
        "effects": {"hard_iron": {"offset_nT": [300.0, -150.0, 200.0]}, "white_noise": {"std_nT": 5.0}},
    }
)
QUICK = {"false_fail_rate": 0.3}
"""Some trials decide."""


def off_by_7(recording: Recording, reference: Reference) -> tuple[list[float], np.ndarray]:
    """The hard iron, 7 nT too large along z."""
    return [300.0, -150.0, 207.0], np.eye(3)


def decided(
    calibrator: object, reference: object | None = None, options: dict[str, Any] = QUICK, **keys: Any
) -> GateOutcome:
    """A gate on the offset error, of twelve trials at most."""
    table = {"score": "offset_error", "max_trials": 12} | keys
    return decide_single_gate(calibrator, reference, SCENARIO, table, options)


def test_an_error_of_7_nT_keeps_a_limit_of_8_and_no_limit_of_6() -> None:
    kept, broken = decided(off_by_7, limit=8.0), decided(off_by_7, limit=6.0)
    assert (kept.verdict, broken.verdict) == ("pass", "fail")
    assert kept.measured == pytest.approx(7.0, rel=1e-9)
    assert kept.plan.gate.name == "off_by_7 on on-the-table"
    assert kept.plan.test.false_fail_rate == 0.3


@pytest.mark.parametrize("seed", [None, 11])
def test_runs_are_those_of_the_scenario_s_seed_or_of_another(seed: int | None) -> None:
    found = decided("sphere", options=QUICK | {"seed": seed}, limit=1e-3)
    design = Design.of(SCENARIO, [select_calibrator("sphere")], seed=3 if seed is None else seed)
    runs = range(found.decision.trials)
    rows = [run_trial(design, 0, run).rows[0] for run in runs]
    scores = [row.scores["offset_error_nT"] if row.status == "ok" else np.inf for row in rows]
    assert len(set(scores)) == len(scores) > 1
    np.testing.assert_array_equal(found.scores, scores)


def test_a_reference_multiplies_the_limit_in_each_trial(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also one of the same name."""
    monkeypatch.setattr(off_by_7, "name", "sphere", raising=False)
    found, alone = decided(off_by_7, "sphere", ratio=1e6), decided("sphere", limit=1e6)
    np.testing.assert_allclose(found.scores, 7.0)
    np.testing.assert_array_equal(found.reference_scores[:2], alone.scores[:2])
    raw = decided(off_by_7, "uncorrected", ratio=0.5)
    assert raw.measured == pytest.approx(7.0 / np.linalg.norm([300.0, -150.0, 200.0]), rel=1e-9)
    assert decided("sphere", "sphere", ratio=1.01).measured == 1.0


def test_a_baseline_multiplies_the_limit(tmp_path: Path) -> None:
    design, path = Design.of(SCENARIO, [select_calibrator(off_by_7)]), tmp_path / "base.parquet"
    write_baseline(path, [rows_of(design, "off_by_7", "offset_error", np.full(12, 3.5))])
    found = decided(off_by_7, baseline=str(path))
    assert (found.verdict, found.measured) == ("fail", pytest.approx(2.0))
    with pytest.raises(InputError, match="holds no run 12"):
        decided(off_by_7, baseline=str(path), max_trials=13)


def test_a_sensor_of_an_array_is_named_after_its_calibrator() -> None:
    assert GateSubject.of("sphere@2").row == "sphere@2"
    assert GateSubject.of("uncorrected@3").row == "uncorrected@3"
    assert GateSubject.of("sphere").row == "sphere"
    array = short("gradiometer-turntable", "sampling.rate_hz=2")
    table = {"score": "offset_error", "max_trials": 8, "limit": 1e9}
    found = decide_single_gate("sphere@2", None, array, table, QUICK)
    assert found.plan.gate.calibrator == "sphere@2"
    with pytest.raises(InputError, match=r"calibrator: 'sphere' is none of the trial's rows"):
        decide_single_gate("sphere", None, array, table, QUICK)


def test_a_program_has_the_time_that_is_given() -> None:
    command = "sh fit.sh {recording.csv} {result}"
    limits = [vars(GateSubject.of(command, *given).entry.method)["time_limit_s"] for given in ((), (0.5,))]  # type: ignore[union-attr]
    assert limits == [TIME_LIMIT_S, 0.5]
    with pytest.raises(InputError, match=r"time_limit_s: "):
        decided(off_by_7, options=QUICK | {"time_limit_s": -1.0}, limit=1.0)


def uncorrected(recording: Recording, reference: Reference) -> tuple[list[float], np.ndarray]:
    """Of a name that is taken."""
    return [0.0, 0.0, 0.0], np.eye(3)


@pytest.mark.parametrize(
    ("calibrator", "reference", "keys", "says"),
    [
        ("sfere", None, {"limit": 1.0}, r"^calibrator: no calibrator is called 'sfere'"),
        ("sphere", "sfere", {"ratio": 1.0}, r"^reference: no calibrator is called 'sfere'"),
        (uncorrected, None, {"limit": 1.0}, r"^calibrator: 'uncorrected' is the raw measurement's name"),
        ("sphere", None, {"limitt": 1.0}, r"^limitt: unknown key"),
        ("sphere", None, {"limit": None}, "found none"),
        ("sphere", None, {"limit": 1.0, "max_trials": 1}, r"^assert_accuracy\.max_trials: within 1 trials nothing"),
        ("sphere", "ellipsoid@2", {"ratio": 1.0}, r"^reference: 'ellipsoid@2' is none of the trial's rows"),
    ],
)
def test_what_is_wrong_is_named_by_the_argument(
    calibrator: object, reference: object | None, keys: dict[str, Any], says: str
) -> None:
    with pytest.raises(InputError, match=says):
        decided(calibrator, reference, **keys)


def test_a_name_is_cut_to_what_a_gate_may_have(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(off_by_7, "name", "x" * 120, raising=False)
    assert decided(off_by_7, limit=8.0).plan.gate.name == "x" * LONGEST_NAME
