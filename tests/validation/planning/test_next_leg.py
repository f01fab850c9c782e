"""What to fly after a recording: each leg pays, the last does not, and the simulator confirms their sum."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reports.outputs.plan import write_plan
from scenarios.errors import InputError
from scenarios.paths.poses import nearest
from sim.dataset_writer import generate
from sim.scenario import load
from tests.results import check_printed
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.files import recording_experiment, scenario_experiment
from validation.planning.next_leg import LEGS_S, LegSequence, next_legs
from validation.planning.next_leg_summary import headline, rows
from validation.planning.search import selections
from validation.planning.summary import times_s
from validation.planning.task import HAND, PlanningTask

LIKE = load("standard-full", ["phases.0.duration_s=60", "sampling.rate_hz=2"])
"""A minute of the standard motion, and few samples, for tests that take little time."""


@pytest.fixture(scope="module")
def minute() -> Experiment:
    return scenario_experiment(LIKE, 10.0)


@pytest.fixture(scope="module")
def asked(minute: Experiment) -> PlanningTask:
    """A person turns the vehicle after the recording."""
    return PlanningTask.of(HAND, LIKE, noise_std_nT=10.0).after(minute)


@pytest.fixture(scope="module")
def found(asked: PlanningTask) -> LegSequence:
    return next_legs(asked, 130.0)


def test_the_first_leg_halves_the_error(found: LegSequence, minute: Experiment) -> None:
    first = found.legs[0]
    assert first.before == pytest.approx(Bound.of(minute, "norm").offset_rms_nT, rel=1e-6)
    assert first.after < first.before / 2


def test_each_leg_goes_on_from_the_one_before_and_pays(found: LegSequence) -> None:
    for one, other in zip(found.legs[:-1], found.legs[1:], strict=True):
        assert other.before == pytest.approx(one.after, rel=1e-3)
    assert all(leg.pays for leg in found.legs)
    assert found.idle is None or not found.idle.pays


def test_recording_and_flight_together_are_as_good_as_is_said(found: LegSequence, minute: Experiment) -> None:
    """Their information added, the flight's from the simulator; no motion within the tilts is better."""
    assert found.scenario is not None
    assert found.least is not None
    assert found.error == pytest.approx(found.legs[-1].after, rel=0.1)
    assert found.least.value <= found.error * 1.001
    flown = scenario_experiment(found.scenario, 10.0)
    told = Bound.of(minute, "norm").information.matrix + Bound.of(flown, "norm").information.matrix
    assert found.error == pytest.approx(np.sqrt(np.trace(np.linalg.inv(told)[:3, :3])), rel=0.05)


def test_in_words_and_on_disk(found: LegSequence, tmp_path: Path) -> None:
    told = write_plan(found, tmp_path / "out")
    assert json.loads((tmp_path / "out" / "plan.json").read_text()) == told
    check_printed(["plan", "--after"], told)
    assert load(told["scenario"]).phases[0].kind == "poses"
    assert [leg["gain_nT"] > 0 for leg in told["legs"]] == [True] * len(found.legs)
    assert headline(found).startswith("leg 1: in ")
    assert rows(found)[0][0] == "1.1"
    assert (tmp_path / "out" / "report.html").exists()


def test_after_a_good_recording_nothing_pays(asked: PlanningTask, tmp_path: Path) -> None:
    assert asked.before is not None
    good = asked.going_on(1e6 * asked.before, 0.0)  # of a recording a million times as long
    told = next_legs(good, 120.0)
    assert told.legs == ()
    assert told.idle is not None
    assert told.idle.before == pytest.approx(asked.error_before / 1000, rel=1e-6)
    assert "a further leg does not pay" in headline(told)
    assert write_plan(told, tmp_path / "out")["scenario"] is None


def test_a_leg_begins_at_the_heading_of_the_one_before(found: LegSequence, asked: PlanningTask) -> None:
    headings = [leg.choice.task.manoeuvre.yaw_deg for leg in found.legs]
    ends = [nearest(leg.choice.legs[-1].yaw_deg) for leg in found.legs]
    assert headings == [asked.manoeuvre.yaw_deg, *ends[:-1]]
    assert any(leg.choice.legs[-1].yaw_deg != leg.choice.legs[-2:][0].yaw_deg for leg in found.legs[:-1])


def test_legs_fill_the_time_and_no_more(found: LegSequence, asked: PlanningTask) -> None:
    """Of 130 s two minutes hold legs; a leg lasts a minute at least."""
    assert 119.0 < sum(leg.choice.phase.duration_s for leg in found.legs) <= 120.5
    with pytest.raises(InputError, match="no leg in this time"):
        next_legs(asked, 59.0)
    assert [round(leg.choice.phase.duration_s / 60.0) for leg in next_legs(asked, 61.0).legs] == [1]


def test_legs_end_when_the_target_is_met(found: LegSequence, asked: PlanningTask) -> None:
    first = found.legs[0].after
    assert [leg.after for leg in next_legs(asked, 130.0, 1.01 * first).legs] == [first]
    assert len(next_legs(asked, 130.0, 0.99 * first).legs) == 2


def test_the_leg_of_the_fastest_gain_is_flown(asked: PlanningTask) -> None:
    """Of one and two minutes, each planned for itself."""
    before, rates = asked.error_before, []
    for leg_s in LEGS_S[:2]:
        choice = min((choice for choice, _ in selections(asked, leg_s)), key=lambda one: one.error)
        rates.append(60.0 * np.log(before / choice.error) / choice.phase.duration_s)
    assert next_legs(asked, 120.0, 0.99 * before).legs[0].rate == pytest.approx(max(rates))


@pytest.mark.slow
def test_a_leg_is_searched_as_a_plan_is(tmp_path: Path) -> None:
    """By the strength alone, after ten minutes of level circles: as good as the same minutes planned from the start.

    Four minutes planned without the recording end at 11.0 nT when their information is added.
    """
    generate(load("auv-spiral", ["phases.0.duration_s=600"]), tmp_path, runs=1, jobs=1)
    known = recording_experiment(tmp_path, noise_std_nT=10.0)
    asked = PlanningTask.of("auv", load("standard-full"), noise_std_nT=10.0).after(known)
    found = next_legs(asked, 240.0)
    assert found.least is not None
    assert found.error is not None
    assert found.least.value < found.error < 11.0
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


def test_a_recording_whose_field_has_no_direction_is_refused(minute: Experiment) -> None:
    with pytest.raises(InputError, match="--field-enu-nT"):
        PlanningTask.of(HAND, LIKE).after(replace(minute, field_enu_nT=None))
