"""The file of gates that a comparison begins: what is in it, what its comments say, and that it can be read."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.scenario import Scenario, load
from tests.short import short
from tests.validation.comparison.conftest import small
from tests.validation.comparison.example import table_of
from validation.calibrating.invocation import Invocation
from validation.calibrating.processes import TIME_LIMIT_S
from validation.comparison.design import Design
from validation.comparison.journal import JOURNAL, Journal
from validation.comparison.sealed_lines import sealed
from validation.comparison.trial import Trial, TrialRow
from validation.comparison.trial_table import TrialTable
from validation.gates.gate_file import load_gates
from validation.gates.proposal import gate_proposals
from validation.gates.proposal_file import FinishedComparison, gates_toml
from validation.scoring.definitions import SCORE_DEFINITIONS

SCORE = SCORE_DEFINITIONS["offset_error"]
GOOD = 2.0 * np.random.default_rng(4).lognormal(0.0, 0.3, 40)
TUMBLE = load("tumble")
"""Of seed 5."""
BUILT_IN = Invocation("sphere")
PROGRAM = Invocation("mine", ("sh", "my fit.sh", "{recording.csv}", "{result}"), 7.5, ("gyro",))


def compared(
    scores: Mapping[str, Any], asked: Mapping[str, Invocation | None], seed: int = 5, scenario: Scenario = TUMBLE
) -> FinishedComparison:
    return FinishedComparison(table_of(scores), scenario, seed, asked)


def text_of(comparison: FinishedComparison) -> str:
    return gates_toml(comparison, gate_proposals(comparison.table, SCORE), SCORE)


def test_each_gate_has_what_its_calibrator_was_asked_by(tmp_path: Path) -> None:
    scores = {"sphere": GOOD, "mine": 2.9 * GOOD, "uncorrected": 100.0 * GOOD}
    text = text_of(compared(scores, {"sphere": BUILT_IN, "mine": PROGRAM}))
    (tmp_path / "gates.toml").write_text(text)
    first, second = load_gates(tmp_path / "gates.toml").gate
    assert (first.name, first.scenario, first.calibrator, first.score) == (
        *("sphere offset_error", "tumble", "sphere"),
        "offset_error_nT",
    )
    assert first.ratio is first.reference is first.exec_ is None
    assert first.limit is not None
    assert 1.0 < first.limit / np.median(GOOD) < 2.5
    assert (second.calibrator, second.reference, second.needs) == ("mine", "sphere", ("gyro",))
    assert second.exec_ == "sh 'my fit.sh' {recording.csv} {result}"
    assert second.limit is None
    assert second.ratio == 3.0  # the lowest of 1.1, 1.25, 1.5, 2, 3, ... above
    told = tomllib.loads(text)
    assert told["time_limit_s"] == 7.5
    assert "seed" not in told
    assert all(gate["max_trials"] >= 20 for gate in told["gate"])


def test_a_seed_and_a_scenario_of_its_own_are_written() -> None:
    scores = {"sphere": GOOD, "uncorrected": 100.0 * GOOD}
    told = tomllib.loads(text_of(compared(scores, {"sphere": BUILT_IN}, seed=6, scenario=short("tumble"))))
    assert (told["seed"], told["gate"][0]["scenario"]) == (6, "tumble.toml")
    assert "time_limit_s" not in told
    assert told["false_fail_rate"] == 1e-4


def test_comments_say_what_was_measured_and_what_a_gate_catches() -> None:
    text = text_of(compared({"sphere": GOOD, "uncorrected": 100.0 * GOOD}, {"sphere": BUILT_IN}))
    (found,) = gate_proposals(table_of({"sphere": GOOD, "uncorrected": GOOD}), SCORE).gates
    median = np.median(GOOD)
    assert "# Begun from a comparison of 40 trials" in text
    assert f"# Measured {median:.3g} nT. Passing takes {found.limit.usually} trials in half of the runs" in text
    assert f"{found.limit.trials} at most in 99 % of them." in text
    assert f"# Catches {found.caught * median:.3g} nT, {found.caught:.3g} times what was measured." in text
    assert found.stricter is not None
    assert f"# Costly: a limit of {found.stricter.value:.3g}. Passing takes" in text
    assert "No better than the raw" not in text
    assert "object in memory" not in text


def test_comments_warn_of_a_calibrator_no_better_than_nothing_and_of_one_in_memory() -> None:
    text = text_of(compared({"mine": GOOD, "uncorrected": GOOD}, {"mine": None}))
    assert f"# No better than the raw measurement ({np.median(GOOD):.3g} nT): guards against worse alone." in text
    assert 'calibrator = "mine"' in text
    assert "# To do: it was an object in memory" in text


def test_who_is_left_out_is_said_on_one_line() -> None:
    scores = {"sphere": GOOD, "never": np.full(40, np.inf), "uncorrected": GOOD}
    told = compared(scores, {"sphere": BUILT_IN, "never": BUILT_IN})
    found = gate_proposals(told.table, SCORE)
    text = gates_toml(told, replace(found, left_out={"never": "fails:\nit\tbroke"}), SCORE)
    assert "# Left out: never fails: it broke\n" in text
    assert len(tomllib.loads(text)["gate"]) == 1


def test_the_largest_time_limit_of_the_programs_is_that_of_the_file() -> None:
    slow = replace(PROGRAM, time_limit_s=30.0)
    limits = [compared({"uncorrected": GOOD}, asked).time_limit_s for asked in ({"a": PROGRAM, "b": slow}, {"a": None})]
    assert limits == [30.0, TIME_LIMIT_S]


def test_a_sensor_of_an_array_keeps_its_calibrator_s_words() -> None:
    told = compared({"uncorrected": GOOD}, {"sphere": BUILT_IN, "mine": PROGRAM, "object": None})
    assert told.invocation_of("sphere@2").calibrator == "sphere@2"
    assert told.invocation_of("mine@3") == replace(PROGRAM, calibrator="mine@3")
    assert told.invocation_of("object") == Invocation("object")


def finished(out: Path, points: int) -> Design:
    """The directory of a comparison whose trials are told."""
    design = small()
    design = replace(design, points=design.points[:points])
    rows = [TrialRow(name, "ok", "", {"offset_error_nT": 2.0}, 0.1, 0.1) for name in design.calibrators]
    Journal.open(out, design.identity())
    told = [Trial(point, run, tuple(rows)) for point in range(points) for run in range(3)]
    TrialTable.of(design, told).write(out)
    return design


def test_a_finished_comparison_is_read_with_its_scenario_seed_and_calibrators(tmp_path: Path) -> None:
    design = finished(tmp_path, 1)
    found = FinishedComparison.read(tmp_path)
    assert found.scenario == design.points[0].scenario
    assert (found.seed, set(found.invocations)) == (design.seed, {"sphere", "ellipsoid"})
    assert found.invocations["ellipsoid"] == Invocation("ellipsoid")
    assert not found.of_the_catalogue
    assert compared({"uncorrected": GOOD}, {}).of_the_catalogue
    assert found.table.runs().tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("points", "first_line", "says"),
    [
        (2, None, "compares at 2 points of a sweep"),
        (1, "[1]", "first line is damaged"),
        (1, '{"comparison":{"format":-1}}', "first line is damaged"),
        (1, sealed('{"comparison":{"format":-1}}').decode(), "is of another version's comparison"),
        (1, "{", "journal"),
    ],
)
def test_what_is_no_comparison_of_one_point_is_refused(
    points: int, first_line: str | None, says: str, tmp_path: Path
) -> None:
    finished(tmp_path, points)
    if first_line is not None:
        (tmp_path / JOURNAL).write_text(first_line + "\n")
    with pytest.raises(InputError, match=says):
        FinishedComparison.read(tmp_path)
