"""Legs as phases: the attitudes that are planned are those that the engine flies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scenarios.errors import InputError
from sim.scenario import Scenario
from sim.simulation import plan, true_motion
from sim.vehicles import VEHICLES
from validation.planning.manoeuvre import Held, Leg, Pushed, manoeuvre_of

LEGS = (Leg(30.0, 15.0, -12.0, 2.0), Leg(-40.0, -10.0, 18.0, 1.0))
WITHIN_DEG = {"auv": 1.0, "quadrotor": 1.5, "turntable": 0.1}
"""Median angle between plan and flight."""


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_the_engine_flies_what_is_planned(vehicle: str) -> None:
    manoeuvre = manoeuvre_of(vehicle)
    phase = manoeuvre.phase(LEGS)
    table = {"name": "trial", "summary": "trial", "field": {"enu_nT": [0.0, 2e4, -4e4]}, "vehicle": {"kind": vehicle}}
    scenario = Scenario.model_validate(table | {"phases": [phase.model_dump(by_alias=True)]})
    q = np.concatenate([motion.kinematics.q for motion in true_motion(plan(scenario))])
    meant = manoeuvre.attitudes(phase, 0.0, phase.duration_s, 0.1)
    assert abs(len(q) - len(meant)) <= 1
    n = min(len(q), len(meant))
    apart = (Rotation.from_quat(q[:n], scalar_first=True).inv() * meant[:n]).magnitude()
    assert np.degrees(np.median(apart)) < WITHIN_DEG[vehicle]
    assert np.degrees(np.sqrt(np.mean(apart**2))) < 3 * WITHIN_DEG[vehicle]


@pytest.mark.parametrize("kind", [Held, Pushed])
def test_a_leg_is_shown_when_it_is_said_to_be(kind: type[Held] | type[Pushed]) -> None:
    manoeuvre = kind(20.0)
    phase = manoeuvre.phase(LEGS)
    named = Rotation.from_euler("ZYX", [leg.angles_deg for leg in LEGS], degrees=True)
    halves = manoeuvre.halves(named)
    for number, (begin, length) in enumerate(manoeuvre.times_s(phase)):
        shown = manoeuvre.attitudes(phase, begin, begin + length, 0.01)
        near = [np.mean((shown.inv() * half[number]).magnitude() < 1e-6) for half in halves]
        assert sum(near) > (0.6 if kind is Pushed else 0.98)
        assert min(near) > 0.4 * sum(near)


def test_a_unit_is_what_one_more_of_it_adds() -> None:
    for manoeuvre in (Held(20.0), Pushed(20.0)):
        few, more = (manoeuvre.phase([Leg(30.0, 15.0, -12.0, amount)]) for amount in (2.0, 3.0))
        _, begin, end = manoeuvre.unit(LEGS[0])
        assert more.duration_s - few.duration_s == pytest.approx(end - begin)


def test_pushes_are_stretched_so_that_nothing_is_left_of_a_time() -> None:
    manoeuvre = Pushed(20.0, drag_1_m=0.02, push_s=4.0)
    time_s = manoeuvre.phase(LEGS).duration_s + 5.0
    filled = manoeuvre.filling(LEGS, time_s).phase(LEGS)
    assert filled.duration_s == pytest.approx(time_s, abs=0.05)
    assert filled.duration_s <= time_s
    assert manoeuvre.filling(LEGS, time_s - 6.0) == manoeuvre
    assert Held(20.0).filling(LEGS, time_s) == Held(20.0)


def test_who_is_no_vehicle() -> None:
    with pytest.raises(InputError, match="quadrotor"):
        manoeuvre_of("quadrotr")
