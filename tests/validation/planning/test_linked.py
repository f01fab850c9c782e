"""Plans for a method with a gyro: what is meant is flown, and a gyro gains where tilts are small."""

from __future__ import annotations

import pytest

from scenarios.errors import InputError
from sim.scenario import load
from tests.validation.bound.experiments import of_motion
from validation.bound.bound import Bound
from validation.bound.files import scenario_experiment
from validation.bound.limit import Tilts
from validation.comparison.engine import Here
from validation.planning.linked import linked, meant
from validation.planning.manoeuvre import Leg
from validation.planning.plan import planned
from validation.planning.refine import fitted
from validation.planning.task import Task
from validation.planning.words import headline

LEVEL = Tilts(5.0, 5.0)


def task(tilts: Tilts = LEVEL) -> Task:
    return Task.of("auv", load("standard-full"), "norm+gyro", tilts=tilts, noise_std_nT=10.0)


def test_the_bound_of_what_is_meant_is_that_of_the_flight() -> None:
    asked = task()
    phase = asked.manoeuvre.phase([Leg(yaw, pitch, roll, 2.0) for yaw, pitch, roll in ((0, 5, 5), (90, -5, 5)) * 3])
    flown = scenario_experiment(asked.scenario([phase], "flown"), 10.0)
    bounds = [Bound.of(one, "norm+gyro").offset_rms_nT for one in (meant(asked, phase), flown)]
    assert bounds[0] == pytest.approx(bounds[1], rel=0.2)


def test_legs_after_a_recording_are_not_planned_for_a_gyro() -> None:
    with pytest.raises(InputError, match="no leg counts by itself"):
        task().after(of_motion("auv"))
    with pytest.raises(InputError, match="norm\\+gyro"):
        Task.of("auv", load("standard-full"), "norm+gyro+accel")


@pytest.mark.slow
def test_many_legs_tell_more_than_a_few_that_are_held() -> None:
    """The first four of them in the same time."""
    found = linked(task(), 200.0)
    few = fitted(found.task, found.legs[:4], 200.0)
    assert few is not None
    held = meant(found.task, found.task.manoeuvre.phase(few))
    assert found.error < 0.8 * Bound.of(held, "norm+gyro").offset_rms_nT


@pytest.mark.slow
def test_a_level_vehicle_s_plan_is_far_below_its_circles_and_is_flown_so() -> None:
    """The standard level motion of six minutes tells 68.5 nT with the same gyro and tilts."""
    found = planned(task(), 360.0).checked(100, Here())
    assert found.least.value < found.error < 0.7 * 68.5
    assert "no motion is below it" in headline(found)
    assert found.confirmed is not None
    assert found.confirmed.calibrator == "gyro_ml"
    assert found.confirmed.failures == 0
    assert found.confirmed.error == pytest.approx(found.error, rel=0.2)
