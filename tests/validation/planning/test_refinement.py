"""Amounts that fit a time, and angles that are moved one at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.scenario import load
from validation.bound.limit import Tilts
from validation.planning.manoeuvre import Leg
from validation.planning.refinement import _moved, fitted, refined
from validation.planning.task import HAND, PlanningTask

LEGS = (Leg(0.0, 10.0, 5.0, 2.0), Leg(90.0, -10.0, 0.0, 6.0), Leg(180.0, 0.0, -5.0, 4.0))


@pytest.fixture(scope="module")
def auv() -> PlanningTask:
    return PlanningTask.of("auv", load("standard-full"), tilts=Tilts(10.0, 20.0), noise_std_nT=10.0)


def test_holds_share_the_time_that_turns_leave(auv: PlanningTask) -> None:
    """In the proportion that they had."""
    turning_s = auv.manoeuvre.phase([Leg(*leg.angles_deg, 0.0) for leg in LEGS]).duration_s
    found = fitted(auv, LEGS, turning_s + 24.0)
    assert found is not None
    assert [leg.amount for leg in found] == pytest.approx([4.0, 12.0, 8.0])
    assert [leg.angles_deg for leg in found] == [leg.angles_deg for leg in LEGS]
    assert fitted(auv, LEGS, turning_s - 0.1) is None
    nothing = fitted(auv, tuple(Leg(*leg.angles_deg, 0.0) for leg in LEGS), turning_s + 24.0)
    assert nothing is not None
    assert [leg.amount for leg in nothing] == pytest.approx([8.0, 8.0, 8.0])


def test_a_person_s_holds_keep_the_least_time_and_share_the_rest() -> None:
    hand = PlanningTask.of(HAND, load("standard-full"), noise_std_nT=10.0)
    legs = tuple(Leg(*leg.angles_deg, 3.0 + leg.amount) for leg in LEGS)
    least_s = hand.manoeuvre.phase([Leg(*leg.angles_deg, 3.0) for leg in LEGS]).duration_s
    found = fitted(hand, legs, least_s + 6.0)
    assert found is not None
    assert [leg.amount for leg in found] == pytest.approx([4.0, 6.0, 5.0])


def test_pushes_are_whole_and_stay_as_they_are() -> None:
    task = PlanningTask.of("quadrotor", load("standard-full"), noise_std_nT=10.0)
    time_s = task.manoeuvre.phase(LEGS).duration_s
    assert fitted(task, LEGS, time_s + 0.01) == LEGS
    assert fitted(task, LEGS, time_s - 0.5) is None


def test_a_moved_angle_stays_within_the_tilts_and_a_turn(auv: PlanningTask) -> None:
    leg = Leg(170.0, 15.0, -8.0, 7.0)
    assert _moved(auv, leg, 0, 20.0) == Leg(-170.0, 15.0, -8.0, 7.0)
    assert _moved(auv, leg, 1, 3.0) == Leg(170.0, 18.0, -8.0, 7.0)
    assert _moved(auv, leg, 1, 40.0) == Leg(170.0, 20.0, -8.0, 7.0)
    assert _moved(auv, leg, 1, -40.0) == Leg(170.0, -20.0, -8.0, 7.0)
    assert _moved(auv, leg, 2, -40.0) == Leg(170.0, 15.0, -10.0, 7.0)
    assert _moved(auv, leg, 2, 40.0) == Leg(170.0, 15.0, 10.0, 7.0)
    narrow = replace(auv, tilts=Tilts(10.0, 12.34))  # a person reads tenths of a degree
    assert _moved(narrow, leg, 1, 40.0) == Leg(170.0, 12.3, -8.0, 7.0)


def test_legs_that_no_time_is_enough_for_are_returned_as_they_are(auv: PlanningTask) -> None:
    legs, error = refined(auv, LEGS, 2.0)
    assert error == np.inf
    assert legs == LEGS


def test_no_angle_of_refined_legs_can_be_moved_for_a_gain() -> None:
    """By five degrees, the least step, beyond half of a percent, for which a round is repeated; nor by larger ones."""
    task = PlanningTask.of(
        "auv", load("standard-full", ["sampling.rate_hz=1"]), "vector", tilts=Tilts(10.0, 20.0), noise_std_nT=10.0
    )
    begun = tuple(
        Leg(yaw, pitch, roll, 8.0) for yaw, pitch, roll in ((0, 5, 0), (80, -5, 5), (150, 0, -5), (200, 9, 3))
    )
    time_s = task.manoeuvre.phase(begun).duration_s
    legs, error = refined(task, begun, time_s)

    def error_of(tried: tuple[Leg, ...]) -> float:
        found = fitted(task, tried, time_s)
        if found is None:
            return float("inf")
        return task.error(task.phase_information(task.manoeuvre.phase(found)))

    assert error == pytest.approx(error_of(legs), rel=1e-2)
    assert error < 0.8 * error_of(begun)
    for place in range(len(legs)):
        for axis in range(3):
            for way_deg in (-5.0, 5.0):
                moved = _moved(task, legs[place], axis, way_deg)
                assert error_of((*legs[:place], moved, *legs[place + 1 :])) > 0.985 * error
