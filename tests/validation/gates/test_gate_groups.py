"""What a gate names: found, or refused at its place; baselines of the same scenario and seed alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.simulation import plan
from tests.validation.gates.conftest import Scripted, gate_text, row
from validation.bound.sensor_noise import stated_noise_nT
from validation.gates.gate_groups import GateGroup
from validation.gates.gate_outcome import GateOutcome
from validation.gates.runner import decide_gates, record_scores
from validation.gates.score_baseline import write_baseline

Groups = Callable[..., tuple[GateGroup, ...]]


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"scenario": "nowhere"}, r"gate\.0\.scenario: nowhere: no such file"),
        ({"set": ["sampling.rate_hz=7"]}, r"gate\.0\.scenario: --set sampling\.rate_hz=7: sampling: rate_hz must"),
        ({"calibrator": "elipsoid"}, r"gate\.0\.calibrator: .*no calibrator is called 'elipsoid'"),
        ({"limit": None, "ratio": 2.0, "reference": "spere"}, r"gate\.0\.reference: .*no calibrator is called 'spere'"),
        ({"scenario": "gradiometer-turntable"}, r"'ellipsoid' is none of the trial's rows .*ellipsoid@2"),
        (
            {"limit": None, "ratio": 2.0, "reference": "bound", "calibrator": "uncorrected"},
            r"gate\.0\.reference: no bound is known on offset_error of uncorrected in tumble",
        ),
        ({"max_trials": 3}, r"gate\.0\.max_trials: within 3 trials nothing fails"),
        ({"limit": None, "baseline": "there.parquet"}, r"gate\.0\.baseline: .*there\.parquet: no such file"),
    ],
)
def test_a_name_that_stands_for_nothing_is_refused_at_its_place(
    keys: dict[str, object], says: str, groups_of: Groups
) -> None:
    table = {"limit": 2.0} | keys
    with pytest.raises(InputError, match=says):
        groups_of(gate_text("a", **{key: value for key, value in table.items() if value is not None}))


def test_a_limit_is_a_multiple_of_what_any_method_can_reach(groups_of: Groups) -> None:
    keys = {"scenario": "standard-full", "score": "offset_error_nT", "ratio": 1.2, "reference": "bound"}
    one, other = groups_of(gate_text("a", "ellipsoid", **keys), gate_text("b", "vector_least_squares", **keys))[
        0
    ].entries
    assert one.read_trial(0, {"ellipsoid": row("ellipsoid", 0.6)}).reference_score == pytest.approx(0.539, rel=0.02)
    assert other.read_trial(
        0, {"vector_least_squares": row("vector_least_squares", 0.3)}
    ).reference_score == pytest.approx(0.2938, rel=0.05)


def test_the_limit_is_of_what_is_possible_in_the_same_run(groups_of: Groups) -> None:
    """The noise is drawn for each run, and the error that any method can reach is as large as the noise."""
    keys = {"scenario": "standard-full", "score": "offset_error_nT", "ratio": 1.2, "reference": "bound"}
    vary = 'vary."effects.white_noise.std_nT".uniform=[1, 30]'
    (group,) = groups_of(gate_text("a", "ellipsoid", set=[vary], **keys))
    for run in range(3):
        drawn = plan(group.design.points[0].scenario, run, group.design.seed)
        least = group.entries[0].read_trial(run, {"ellipsoid": row("ellipsoid", 0.6)}).reference_score
        assert least / stated_noise_nT(drawn.effects[0]) == pytest.approx(0.0539, rel=0.02)


def test_a_scenario_is_found_beside_the_file(tmp_path: Path, groups_of: Groups) -> None:
    text = Path("scenarios/catalogue/tumble.toml").read_text()
    (tmp_path / "mine.toml").write_text(text.replace('name = "tumble"', 'name = "mine"'))
    (group,) = groups_of(gate_text("a", scenario="mine.toml", limit=2.0))
    assert group.design.points[0].scenario.name == "mine"


def test_the_sensor_of_an_array_is_named(groups_of: Groups) -> None:
    (group,) = groups_of(gate_text("a", "ellipsoid@2", "gradiometer-turntable", limit=2.0))
    assert group.entries[0].calibrator == "ellipsoid@2"
    assert [one.name for one in group.design.candidates] == ["ellipsoid"]


HANG = "sh hang.sh {recording.csv} {result}"


def test_a_program_has_the_time_limit_of_the_file_or_of_the_command(groups_of: Groups) -> None:
    gate = gate_text("a", "mine", exec=HANG, limit=2.0)
    for options, limit_s in (({}, 3.5), ({"time_limit_s": 0.5}, 0.5)):
        (group,) = groups_of("time_limit_s = 3.5", gate, **options)
        assert vars(group.design.candidates[0].method)["time_limit_s"] == limit_s


def test_a_name_stands_for_one_program_in_all_gates_and_sensors(groups_of: Groups) -> None:
    scenario = "gradiometer-turntable"
    one = gate_text("a", "mine@2", scenario, exec=HANG, limit=2.0)
    (group,) = groups_of(one, gate_text("b", "mine@3", scenario, limit=2.0))
    assert [entry.calibrator for entry in group.entries] == ["mine@2", "mine@3"]
    assert [one.name for one in group.design.candidates] == ["mine"]
    with pytest.raises(InputError, match=r"gate\.1\.exec: 'mine' is another command in a gate before"):
        groups_of(one, gate_text("b", "mine", exec=HANG.replace("sh ", "sh -x "), limit=2.0))


def test_a_program_is_held_to_the_bound_of_what_it_is_said_to_need(groups_of: Groups) -> None:
    """With a gyro the least error of level circles is a sixth of that of the strength alone."""
    keys = {"scenario": "standard-auv", "score": "offset_error_nT", "ratio": 1.2, "reference": "bound", "exec": HANG}
    least = []
    for needs in ([], ["gyro"]):
        (group,) = groups_of(gate_text("a", "mine", needs=needs, **keys))
        assert group.design.candidates[0].needs == tuple(needs)
        least.append(group.entries[0].read_trial(0, {"mine": row("mine", 1.0)}).reference_score)
    assert least[1] < least[0] / 4
    with pytest.raises(InputError, match=r"gate\.1\.exec: 'mine' is another command in a gate before"):
        groups_of(gate_text("a", "mine", **keys), gate_text("b", "mine", needs=["gyro"], **keys))


@pytest.fixture
def baseline(tmp_path: Path, groups_of: Groups) -> Path:
    """Scores of ellipsoid on tumble in 60 trials."""
    path = tmp_path / "base.parquet"
    groups = groups_of(gate_text("a", limit=2.0, max_trials=60))
    write_baseline(path, record_scores(groups, Scripted(lambda group, run: [row("ellipsoid", 1.0 + run)])))
    return path


def held_to(baseline: Path, **keys: object) -> str:
    return gate_text("a", **({"baseline": baseline.name, "max_trials": 60} | keys))


def test_an_unchanged_calibrator_keeps_its_baseline_and_one_that_got_worse_does_not(
    baseline: Path, groups_of: Groups
) -> None:
    def scaled(factor: float) -> GateOutcome:
        engine = Scripted(lambda group, run: [row("ellipsoid", factor * (1.0 + run))])
        return decide_gates(groups_of(held_to(baseline)), engine)[0]

    unchanged, worse = scaled(1.0), scaled(1.2)
    assert (unchanged.verdict, unchanged.measured) == ("pass", 1.0)
    assert unchanged.factor_seen == pytest.approx(1.1)
    assert worse.verdict == "fail"
    assert worse.measured == pytest.approx(1.2)


@pytest.mark.parametrize(
    ("keys", "options", "says"),
    [
        ({"set": ["sampling.rate_hz=5"]}, {}, "holds nothing of this scenario"),
        ({}, {"seed": 99}, "holds nothing of seed 99"),
        ({"calibrator": "sphere"}, {}, "holds nothing of calibrator sphere"),
        ({"score": "heading_rms"}, {}, "holds nothing of score heading_rms"),
        ({"max_trials": 61}, {}, "holds no run 60; the gate may take 61 trials"),
    ],
)
def test_a_baseline_of_something_else_is_refused(
    keys: dict[str, object], options: dict[str, int], says: str, baseline: Path, groups_of: Groups
) -> None:
    with pytest.raises(InputError, match=says):
        groups_of(held_to(baseline, **keys), **options)


def test_a_file_that_is_no_baseline_is_refused(tmp_path: Path, groups_of: Groups) -> None:
    (tmp_path / "base.parquet").write_bytes(b"PAR1")
    with pytest.raises(InputError, match=r"base\.parquet"):
        groups_of(held_to(tmp_path / "base.parquet"))
    assert np.isfinite(groups_of(held_to(tmp_path / "base.parquet"), baselines=False)[0].max_trials)
