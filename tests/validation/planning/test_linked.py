"""Plans for a method with a gyro: what is meant is flown, and a gyro gains where tilts are small."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.scenario import load
from tests.calib import conftest as standard
from tests.validation.bound.experiments import of_motion
from validation.bound.bound import Bound
from validation.bound.files import scenario_experiment
from validation.bound.knowledge import PLACES
from validation.bound.limit import Tilts
from validation.comparison.engine import SerialEngine
from validation.planning.linked import GUIDES, _carried, linked, shortest
from validation.planning.manoeuvre import Leg
from validation.planning.next_leg import next_legs
from validation.planning.next_leg_summary import headline as after_words
from validation.planning.plan import planned
from validation.planning.refinement import fitted
from validation.planning.summary import headline
from validation.planning.task import HAND, PlanningTask

LEVEL = Tilts(5.0, 5.0)


def task(tilts: Tilts = LEVEL) -> PlanningTask:
    return PlanningTask.of("auv", load("standard-full"), "norm+gyro", tilts=tilts, noise_std_nT=10.0)


def test_the_bound_of_what_is_meant_is_that_of_the_flight() -> None:
    asked = task()
    phase = asked.manoeuvre.phase([Leg(yaw, pitch, roll, 2.0) for yaw, pitch, roll in ((0, 5, 5), (90, -5, 5)) * 3])
    flown = scenario_experiment(asked.scenario([phase], "flown"), 10.0)
    bounds = [Bound.of(one, "norm+gyro").offset_rms_nT for one in (asked.meant(phase), flown)]
    assert bounds[0] == pytest.approx(bounds[1], rel=0.2)


def test_a_leg_after_a_recording_adds_to_what_it_tells() -> None:
    """As the bounds of both flights by themselves do, the leg's from the simulator."""
    before = replace(of_motion("auv"), field_enu_nT=np.array(standard.FIELD_ENU_NT))
    found = next_legs(task().after(before), 60.0)
    assert found.scenario is not None
    assert found.error is not None
    flown = scenario_experiment(found.scenario, 10.0)
    told = sum(Bound.of(one, "norm+gyro").information.matrix for one in (before, flown))
    assert found.error == pytest.approx(np.sqrt(np.trace(np.linalg.inv(told)[:3, :3])), rel=1e-6)
    assert found.legs[0].before == pytest.approx(68.5, rel=0.01)
    assert found.error < 0.9 * found.legs[0].before
    assert found.error == pytest.approx(found.legs[0].after, rel=0.1)
    assert "no motion is below the limit" in after_words(found)


def test_what_a_gyro_does_not_link_is_not_planned_for() -> None:
    with pytest.raises(InputError, match="norm\\+gyro"):
        PlanningTask.of("auv", load("standard-full"), "norm+gyro+accel")


@pytest.fixture(scope="module")
def hand() -> PlanningTask:
    """A person, and few samples, for tests that take little time."""
    return PlanningTask.of(HAND, load("standard-full", ["sampling.rate_hz=2"]), "norm+gyro", noise_std_nT=10.0)


def test_the_shortest_by_hand_meets_its_target_and_a_shorter_one_does_not(
    hand: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within three per cent of the time; none is shorter than a hundred seconds, for the gyro's bias."""
    once = cache(linked)
    monkeypatch.setattr("validation.planning.linked.linked", once)
    whole = once(hand, 108.0)
    found = shortest(hand, 1.1 * whole.error, 108.0)
    assert 100.0 < found.time_s < 103.0
    assert found.error <= 1.1 * whole.error
    assert found.error == pytest.approx(linked(hand, found.time_s).error)
    missed = shortest(hand, 1.0001 * whole.error, 108.0)
    assert (missed.time_s, missed.error) == (108.0, whole.error)
    assert shortest(hand, 0.9 * whole.error, 108.0).error == whole.error


def test_what_is_promised_is_the_bound_of_the_attitudes_meant(hand: PlanningTask) -> None:
    found = linked(hand, 100.0)
    assert found.phase.duration_s == pytest.approx(100.0, abs=0.6)
    assert found.error == pytest.approx(Bound.of(hand.meant(found.phase), "norm+gyro").offset_rms_nT, rel=1e-6)
    assert linked(hand, 12.0).error == np.inf


@pytest.mark.slow
def test_many_legs_tell_more_than_a_few_that_are_held() -> None:
    """The first four of them in the same time."""
    found = linked(task(), 200.0)
    few = fitted(found.task, found.legs[:4], 200.0)
    assert few is not None
    held = found.task.meant(found.task.manoeuvre.phase(few))
    assert found.error < 0.8 * Bound.of(held, "norm+gyro").offset_rms_nT


@pytest.mark.slow
def test_a_level_vehicle_s_plan_is_far_below_its_circles_and_is_flown_so() -> None:
    """The standard level motion of six minutes tells 68.5 nT with the same gyro and tilts."""
    found = planned(task(), 360.0).checked(100, SerialEngine())
    assert found.least.value < found.error < 0.7 * 68.5
    assert "no motion is below the limit" in headline(found)
    assert found.confirmed is not None
    assert found.confirmed.calibrator == "gyro_ml"
    assert found.confirmed.failures == 0
    assert found.confirmed.error == pytest.approx(found.error, rel=0.2)


def matrix_at(values: Array, places: tuple[tuple[int, int], ...]) -> Array:
    """The matrix with some entries, zero elsewhere."""
    found = np.zeros((3, 3))
    for value, place in zip(values, places, strict=True):
        found[place] = value
    return found


@pytest.mark.parametrize("guide", GUIDES)
def test_what_a_recording_tells_is_carried_to_the_entries_of_the_guide(guide: str) -> None:
    """Of a symmetric S: entries across the diagonal stand for their mean, by the same square of their errors."""
    rng = np.random.default_rng(1)
    upper = tuple((i, j) for i in range(3) for j in range(i, 3))
    before = np.cov(rng.normal(size=(9, 30)))
    carried = _carried(before, guide)
    offset, entries = rng.normal(size=3), rng.normal(size=len(PLACES[guide]))
    S = matrix_at(entries, PLACES[guide])
    S = S + S.T - np.diag(np.diag(S)) if guide == "norm" else (S + S.T) / 2
    of_guide, symmetric = np.r_[offset, entries], np.r_[offset, [S[place] for place in upper]]
    assert of_guide @ carried @ of_guide == pytest.approx(symmetric @ before @ symmetric)
