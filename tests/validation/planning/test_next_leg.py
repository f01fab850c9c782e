"""What to fly after a recording: each leg pays, the last does not, and the simulator confirms their sum."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reports.outputs.plan import write_plan
from scenarios.errors import InputError
from sim.dataset_writer import generate
from sim.scenario import load
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.files import recording_experiment, scenario_experiment
from validation.planning import refinement
from validation.planning.next_leg import LegSequence, next_legs
from validation.planning.next_leg_summary import headline, rows
from validation.planning.summary import times_s
from validation.planning.task import PlanningTask


@pytest.fixture(scope="module")
def spiral(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    place = tmp_path_factory.mktemp("spiral")
    generate(load("auv-spiral", ["phases.0.duration_s=600"]), place, runs=1, jobs=1)
    return recording_experiment(place, noise_std_nT=10.0)


@pytest.fixture(scope="module")
def found(spiral: Experiment) -> LegSequence:
    return next_legs(PlanningTask.of("auv", load("standard-full"), "vector", noise_std_nT=10.0).after(spiral), 130.0)


def test_the_first_leg_halves_the_error(found: LegSequence, spiral: Experiment) -> None:
    first = found.legs[0]
    assert first.before == pytest.approx(Bound.of(spiral, "vector").offset_rms_nT, rel=1e-6)
    assert first.after < first.before / 2


def test_each_leg_goes_on_from_the_one_before_and_pays(found: LegSequence) -> None:
    for one, other in zip(found.legs[:-1], found.legs[1:], strict=True):
        assert other.before == pytest.approx(one.after, rel=1e-3)
    assert all(leg.pays for leg in found.legs)
    assert found.idle is None or not found.idle.pays


def test_recording_and_flight_together_are_as_good_as_is_said(found: LegSequence, spiral: Experiment) -> None:
    """Their information added, the flight's from the simulator; no motion within the tilts is better."""
    assert found.scenario is not None
    assert found.least is not None
    assert found.error == pytest.approx(found.legs[-1].after, rel=0.1)
    assert found.least.value <= found.error * 1.001
    flown = scenario_experiment(found.scenario, 10.0)
    told = Bound.of(spiral, "vector").information.matrix + Bound.of(flown, "vector").information.matrix
    assert found.error == pytest.approx(np.sqrt(np.trace(np.linalg.inv(told)[:3, :3])), rel=0.05)


def test_in_words_and_on_disk(found: LegSequence, tmp_path: Path) -> None:
    told = write_plan(found, tmp_path / "out")
    assert json.loads((tmp_path / "out" / "plan.json").read_text()) == told
    assert load(told["scenario"]).phases[0].kind == "poses"
    assert [leg["gain_nT"] > 0 for leg in told["legs"]] == [True] * len(found.legs)
    assert headline(found).startswith("leg 1: in ")
    assert rows(found)[0][0] == "1.1"
    assert (tmp_path / "out" / "report.html").exists()


def test_after_a_good_recording_nothing_pays(tmp_path: Path) -> None:
    known = scenario_experiment(load("standard-full", ["phases.0.duration_s=3800"]), 10.0)
    found = next_legs(PlanningTask.of("auv", load("standard-full"), "vector", noise_std_nT=10.0).after(known), 120.0)
    assert found.legs == ()
    assert found.idle is not None
    assert "a further leg does not pay" in headline(found)
    assert write_plan(found, tmp_path / "out")["scenario"] is None


@pytest.mark.parametrize(
    ("steps_deg", "rounds", "most"),
    [((20.0,), 1, 14.0), pytest.param(refinement.STEPS_DEG, refinement.MOST_ROUNDS, 11.0, marks=pytest.mark.slow)],
    ids=["a round", "all rounds"],
)
def test_a_leg_is_searched_as_a_plan_is(
    steps_deg: tuple[float, ...], rounds: int, most: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the strength alone, after ten minutes of level circles: as good as the same minutes planned from the start.

    Four minutes planned without the recording end at 11.0 nT when their information is added.
    """
    monkeypatch.setattr(refinement, "STEPS_DEG", steps_deg)
    monkeypatch.setattr(refinement, "MOST_ROUNDS", rounds)
    generate(load("auv-spiral", ["phases.0.duration_s=600"]), tmp_path, runs=1, jobs=1)
    known = recording_experiment(tmp_path, noise_std_nT=10.0)
    asked = PlanningTask.of("auv", load("standard-full"), noise_std_nT=10.0).after(known)
    found = next_legs(asked, 240.0)
    assert found.least is not None
    assert found.error is not None
    assert found.least.value < found.error < most
    times = [length for leg in found.legs for _, length in times_s(leg.choice)]
    assert sum(length < 0.1 for length in times) < len(times) / 2


def test_a_leg_is_beaten_by_what_gains_faster(found: LegSequence) -> None:
    first = found.legs[0]
    length = first.choice.phase.duration_s
    assert first.beats(first.after * 1.01, length)
    assert not first.beats(first.after * 0.99, length)
    assert not first.beats(first.after, length * 0.99)
    unknown = replace(first, before=np.inf)
    assert unknown.beats(first.after * 1.01, 1.0)
    assert not unknown.beats(first.after * 0.99, 1000.0)


def test_a_recording_whose_field_has_no_direction_is_refused(spiral: Experiment) -> None:
    with pytest.raises(InputError, match="--field-enu-nT"):
        PlanningTask.of("auv", load("standard-full")).after(replace(spiral, field_enu_nT=None))
