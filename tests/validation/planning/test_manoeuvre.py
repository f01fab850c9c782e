"""Legs as phases: the attitudes that are planned are those that the engine flies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scenarios.errors import InputError
from sim.scenario import Scenario
from sim.simulation import plan, true_motion
from sim.vehicles import VEHICLES
from validation.bound.limit import Tilts
from validation.planning.manoeuvre import HandHeld, Held, Leg, Pushed, manoeuvre_of

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
        phase, begin, end = manoeuvre.unit(LEGS[0])
        shown = manoeuvre.attitudes(phase, begin, end, 0.01)
        up, down = (
            half[0]
            for half in (manoeuvre.halves(Rotation.from_euler("ZYX", [LEGS[0].angles_deg], degrees=True)) * 2)[:2]
        )
        near = [np.mean((shown.inv() * one).magnitude() < 1e-6) for one in (up, down)]
        if isinstance(manoeuvre, Pushed):  # from the middle of a tilt over the opposite one to the middle of the next
            assert near[0] == pytest.approx(near[1], abs=0.01)
            assert sum(near) > 0.6
            assert [(one.inv() * down).magnitude() < 1e-6 for one in (shown[0], shown[-1])] == [True, True]
        else:
            assert near == [1.0, 1.0]


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


def test_a_turn_takes_its_largest_angle_at_the_peak_of_a_smoothstep() -> None:
    """15/8 of the mean rate; yaw the shorter way round; a second at least."""
    held = Held(20.0)
    assert held.move_s((170.0, 0.0, 0.0), (-150.0, 10.0, 0.0)) == pytest.approx(1.875 * 40.0 / 20.0)
    assert held.move_s((0.0, -20.0, 0.0), (30.0, 30.0, 0.0)) == pytest.approx(1.875 * 50.0 / 20.0)
    assert held.move_s((0.0, 0.0, 25.0), (0.0, 0.0, -35.0)) == pytest.approx(1.875 * 60.0 / 20.0)
    assert held.move_s((0.0, 0.0, 0.0), (2.0, 0.0, 0.0)) == 1.0


def test_a_flight_of_holds_begins_and_ends_level() -> None:
    """From level to roll 12 and yaw 30, to the next, and home from a roll of 24 at its heading."""
    legs = (Leg(30.0, 0.0, -12.0, 2.0), Leg(30.0, 8.0, 24.0, 1.0))
    phase = Held(20.0, yaw_deg=10.0).phase(legs)
    moves = [1.875 * angle / 20.0 for angle in (20.0, 36.0, 24.0)]
    assert [*(pose.move_s for pose in phase.poses), phase.home_s] == pytest.approx(moves, abs=0.06)
    assert [pose.hold_s for pose in phase.poses] == [2.0, 1.0]
    assert phase.duration_s == pytest.approx(sum(moves) + 3.0, abs=0.2)


def test_pushes_turn_from_the_heading_before_and_count_whole() -> None:
    legs = (Leg(60.0, 5.0, 0.0, 2.0), Leg(-20.0, 0.0, 5.0, 3.0))
    phase = Pushed(20.0, yaw_deg=20.0, drag_1_m=0.02).phase(legs)
    assert [push.turn_s for push in phase.pushes] == pytest.approx([1.875 * 2.0, 1.875 * 4.0], abs=0.06)
    assert [push.times for push in phase.pushes] == [2, 3]
    assert (phase.push_s, phase.switch_s, phase.drag_1_m, phase.run_in_s) == (1.5, 0.6, 0.02, 1.0)


def test_the_variants_are_quicker_turns_or_longer_pushes() -> None:
    assert [way.turning_deg_s for way in Held(20.0).ways] == [20.0, 30.0, 40.0]
    assert [way.push_s for way in Pushed(20.0).ways] == [1.5, 2.5, 4.0]
    assert HandHeld(20.0).ways == (HandHeld(20.0),)
    assert (HandHeld.least, HandHeld.whole, Pushed.least, Pushed.whole, Held.least, Held.whole) == (
        *(3.0, False, 1.0, True),
        *(0.0, False),
    )
    assert (Held.stays, Pushed.stays, Held.most_deg, Pushed.most_deg) == (False, True, 180.0, 45.0)


@pytest.mark.parametrize(("tilts", "most_m_s2"), [((0.0, 45.0), 9.81), ((30.0, 30.0), 9.81 * (7 / 9) ** 0.5)])
def test_wide_tilts_change_no_faster_than_a_vehicle_follows(tilts: tuple[float, float], most_m_s2: float) -> None:
    """From one acceleration to its opposite at a jerk of 40 m/s^3; cos 30 twice is 3/4: the tangent is root 7/9."""
    assert Pushed(20.0).within(Tilts(*tilts)).switch_s == pytest.approx(2 * 1.875 * most_m_s2 / 40.0, abs=0.006)
    assert Pushed(20.0).within(Tilts(5.0, 5.0)).switch_s == 0.6
    assert Held(20.0).within(Tilts(*tilts)) == Held(20.0)


def test_a_vehicle_that_tilts_by_thrust_has_its_z_along_thrust_and_its_x_on_the_heading() -> None:
    """Thrust balances gravity, acceleration and drag, which goes with the square of the speed."""
    reference = np.zeros((1, 18))
    reference[0, 3:10] = [3.0, -4.0, 0.0, 1.0, 2.0, -0.5, 0.7]
    R = Pushed(20.0, drag_1_m=0.02).seen(reference).as_matrix()[0]
    thrust = np.array([1.0 + 0.02 * 5 * 3, 2.0 - 0.02 * 5 * 4, 9.81 - 0.5])
    np.testing.assert_allclose(R[:, 2], thrust / np.linalg.norm(thrust), rtol=1e-6)
    assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(0.7)


def test_pushes_are_no_shorter_and_no_longer_than_they_may_be() -> None:
    manoeuvre = Pushed(20.0, push_s=4.0)
    assert manoeuvre.filling(LEGS, manoeuvre.phase(LEGS).duration_s + 1000.0).push_s == 10.0
    assert manoeuvre.filling(LEGS, manoeuvre.phase(LEGS).duration_s + 0.5).push_s > 4.0


def test_times_are_written_in_tenths_of_a_second() -> None:
    phase = Held(7.0).phase([Leg(31.3, 15.0, -12.0, 2.04), Leg(-44.7, 3.0, 8.0, 0.37)])
    assert [pose.hold_s for pose in phase.poses] == [2.0, 0.4]
    for time_s in (*(pose.move_s for pose in phase.poses), phase.home_s):
        assert time_s == round(time_s, 1)
    pushes = Pushed(7.0).phase([Leg(31.3, 5.0, 0.0, 2.0), Leg(-44.7, 3.0, 8.0, 1.0)]).pushes
    assert [push.turn_s for push in pushes] == [round(push.turn_s, 1) for push in pushes]
