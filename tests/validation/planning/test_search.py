"""Routes and their times: narrower tilts, thinning, the shortest flight for a target, what a longer time gives."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.scenario import load
from validation.bound.limit import Tilts
from validation.planning.manoeuvre import Leg
from validation.planning.plan import planned
from validation.planning.search import (
    LegSelection,
    RouteSearch,
    _route,
    _shortest_way,
    _without_one,
    design_error,
    few,
    merged,
    selections,
)
from validation.planning.task import HAND, PlanningTask

TIME_S = 120.0


@pytest.fixture(scope="module")
def hand() -> PlanningTask:
    return PlanningTask.of(HAND, load("standard-full"), noise_std_nT=10.0)


@pytest.fixture(scope="module")
def auv() -> PlanningTask:
    """Sampled twice a second, for tests that take little time."""
    like = load("standard-full", ["sampling.rate_hz=2"])
    return PlanningTask.of("auv", like, tilts=Tilts(12.0, 20.0), noise_std_nT=10.0)


@pytest.fixture(scope="module")
def of_five(auv: PlanningTask) -> RouteSearch:
    """Routes of five attitudes at most, for 80 s; see `copied`."""
    return RouteSearch(auv, 80.0, (5,))


def copied(search: RouteSearch) -> RouteSearch:
    """A search that has the routes, and adds more to itself alone."""
    other = copy(search)
    other.routes = list(search.routes)
    return other


@pytest.fixture(scope="module")
def by_hand(hand: PlanningTask) -> RouteSearch:
    return RouteSearch(hand, TIME_S)


def widest(search: RouteSearch) -> list[float]:
    """Largest tilt over its limit in each route."""
    tilts = search.task.tilts
    limits = np.array([tilts.pitch_deg, tilts.roll_deg])
    return [float(np.max(np.abs(route.angles_deg[:, 1:]) / limits)) for route in search.routes]


def test_routes_within_narrower_tilts_are_tried_by_a_vehicle_that_starts_anew(
    auv: PlanningTask, hand: PlanningTask, of_five: RouteSearch
) -> None:
    np.testing.assert_allclose(widest(of_five), [1.0, 0.6, 0.35], atol=0.03)
    for route in of_five.routes:  # and headings are as wide as ever, of the limits' grid and in tenths of a degree
        assert np.isin(route.angles_deg[:, 0], np.round(auv.angles_deg[:, 0], 1)).all()
        np.testing.assert_array_equal(route.angles_deg, np.round(route.angles_deg, 1))
    np.testing.assert_allclose(widest(RouteSearch(hand, TIME_S, (5,))), [1.0])
    known = auv.going_on(1e-4 * np.eye(len(auv.wanted)), 0.0)
    np.testing.assert_allclose(widest(RouteSearch(known, TIME_S, (5,))), [1.0], atol=0.03)


def test_without_counts_more_are_tried_from_the_start_and_fewer_after_a_recording(hand: PlanningTask) -> None:
    """A leg after a recording may be a single attitude; a plan from the start is of four or more."""
    anew = {len(route.angles_deg) for route in RouteSearch(hand, TIME_S).routes}
    after = {len(route.angles_deg) for route in RouteSearch(hand.going_on(np.eye(9), 0.0), TIME_S).routes}
    assert min(anew) >= 3
    assert min(after) == 1


def test_the_optimal_design_halves_its_error_in_four_times_the_time(
    auv: PlanningTask, hand: PlanningTask, by_hand: RouteSearch
) -> None:
    for task in (auv, hand):
        assert design_error(task, 400.0) == pytest.approx(design_error(task, 100.0) / 2, rel=1e-3)
    assert by_hand.least(TIME_S) == pytest.approx(design_error(hand, TIME_S))
    assert by_hand.least(4 * TIME_S) == pytest.approx(by_hand.least(TIME_S) / 2)
    assert by_hand.best(TIME_S).error > by_hand.least(TIME_S)


def test_what_is_promised_is_the_error_of_the_phase_within_the_time(by_hand: RouteSearch) -> None:
    for time_s in (70.0, TIME_S, 500.0):
        found = by_hand.best(time_s)
        assert found.time_s == time_s
        assert found.phase.duration_s == pytest.approx(time_s, abs=0.2)
        assert found.error == pytest.approx(found.task.error(found.information), rel=0.02)
    assert by_hand.best(20.0).error == np.inf


def test_no_leg_is_kept_that_hardly_lasts_and_can_be_spared(auv: PlanningTask) -> None:
    """What thinning takes away costs less than is allowed, and what is left is needed or long enough."""
    time_s = 300.0
    search = RouteSearch(auv, time_s, (12,))
    raw = min((route.best(time_s) for route in search.routes), key=lambda one: one.error)
    routes = len(search.routes)
    found = search.best(time_s)
    assert found.error <= 1.002 * raw.error
    assert len(found.legs) < len(raw.legs)
    assert len(search.routes) == routes + 1  # and serves the times that are asked next
    assert all(leg.amount >= 0.5 for leg in found.legs)
    assert found.error < raw.error  # two turns that are not made leave time for the others
    assert search.best(time_s).error <= found.error * (1 + 1e-9)


@pytest.mark.parametrize("close_s", [1.0, 8.0])
def test_the_shortest_flight_meets_its_target_and_a_shorter_one_does_not(by_hand: RouteSearch, close_s: float) -> None:
    target = 1.3 * by_hand.best(TIME_S).error
    found = by_hand.shortest(target, TIME_S, close_s)
    assert found.error <= target
    assert by_hand.best(found.time_s - close_s).error > target
    assert found.time_s < 0.8 * TIME_S
    usual = by_hand.shortest(target, TIME_S)
    assert by_hand.best(usual.time_s - 1.0).error > target >= usual.error


def test_a_leg_is_dropped_that_costs_up_to_two_thousandths(auv: PlanningTask) -> None:
    """The shortest of those that can be spared first, as many as can."""
    legs = tuple(Leg(yaw, 15.0, 0.0, amount) for yaw, amount in ((0.0, 30.0), (90.0, 0.4), (180.0, 0.2), (270.0, 30.0)))
    choice = LegSelection(auv, legs, 120.0, 1.0)
    fewer = _without_one(choice, np.inf)
    assert fewer is not None
    assert [leg.yaw_deg for leg in fewer.legs] == [0.0, 90.0, 270.0]
    assert _without_one(choice, fewer.error) is not None
    assert fewer.error == pytest.approx(_route(auv, np.array([leg.angles_deg for leg in fewer.legs])).best(120.0).error)


def test_a_target_out_of_reach_gives_the_best_of_the_whole_time(by_hand: RouteSearch) -> None:
    found = by_hand.shortest(1e-9, TIME_S)
    assert found.time_s == TIME_S
    assert found.error == pytest.approx(by_hand.best(TIME_S).error, rel=1e-3)


def test_a_plan_for_a_target_ends_when_it_is_met(hand: PlanningTask) -> None:
    best = planned(hand, TIME_S)
    met = planned(hand, TIME_S, 1.3 * best.error)
    assert met.met
    assert met.error == pytest.approx(1.3 * best.error, rel=0.02)
    assert met.time_s < 0.8 * TIME_S
    missed = planned(hand, TIME_S, 0.5 * best.error)
    assert not missed.met
    assert missed.time_s == pytest.approx(TIME_S, abs=0.5)
    assert missed.error == pytest.approx(best.error, rel=0.02)
    with pytest.raises(InputError, match=r"no manoeuvre in this time.*give more --time"):
        planned(hand, 20.0, 10.0)


def test_a_person_s_attitudes_are_in_steps_and_not_refined(hand: PlanningTask) -> None:
    search = RouteSearch(hand, 60.0, (4,))
    routes = len(search.routes)
    search.improve(60.0)
    assert len(search.routes) == routes


@pytest.mark.parametrize(("ratio", "is_refined"), [(1.09, False), (1.11, True)])
def test_a_route_is_refined_that_is_a_tenth_from_the_optimal_design(
    of_five: RouteSearch, ratio: float, is_refined: bool
) -> None:
    search = copied(of_five)
    before = search.best(80.0).error
    routes = len(search.routes)
    search.least_in_a_second = np.sqrt(80.0) * before / ratio
    search.improve(80.0)
    assert (len(search.routes) > routes) is is_refined
    assert search.best(80.0).error <= before


def test_a_time_that_no_route_fits_into_is_given_up(of_five: RouteSearch) -> None:
    search = copied(of_five)
    search.improve(20.0)
    assert search.routes == of_five.routes
    assert search.best(20.0).error == np.inf


def test_seconds_of_holding_take_all_the_time_that_turns_leave(of_five: RouteSearch, by_hand: RouteSearch) -> None:
    for search in (by_hand, of_five):
        for found in (route.best(300.0) for route in search.routes):
            assert sum(leg.amount for leg in found.legs) == pytest.approx(300.0 - turning_s(found), abs=1e-3)
            assert any(0.01 < leg.amount % 1.0 < 0.99 for leg in found.legs)


def turning_s(found: LegSelection) -> float:
    """How long the phase lasts beyond its holds."""
    least = found.task.manoeuvre.least
    still = found.task.manoeuvre.phase([replace(leg, amount=least) for leg in found.legs])
    return still.duration_s - least * len(found.legs)


def test_only_a_hold_of_less_than_half_a_second_is_dropped(auv: PlanningTask) -> None:
    legs = [Leg(yaw, pitch, 0.0, amount) for yaw, pitch, amount in ((0, 15, 9.0), (90, -15, 0.3), (180, 15, 0.7))]
    choice = LegSelection(auv, tuple(legs), 60.0, 1.0)
    fewer = _without_one(choice, np.inf)
    assert fewer is not None
    assert [leg.yaw_deg for leg in fewer.legs] == [0.0, 180.0]
    assert _without_one(replace(choice, legs=(legs[0], legs[2])), np.inf) is None
    assert _without_one(replace(choice, legs=legs[1:2]), np.inf) is None
    assert _without_one(choice, 1e-9) is None


def test_a_person_s_hold_and_a_push_are_long_enough(hand: PlanningTask) -> None:
    """Three seconds and one push, the least there are, are not dropped however little they tell."""
    quadrotor = PlanningTask.of("quadrotor", load("standard-full"), noise_std_nT=10.0)
    for task, amount in ((hand, 3.0), (quadrotor, 1.0)):
        legs = tuple(Leg(yaw, 15.0, 0.0, amount) for yaw in (0.0, 90.0, 180.0))
        assert _without_one(LegSelection(task, legs, 60.0, 1.0), np.inf) is None


def test_a_flight_begins_level_and_goes_the_shorter_way(auv: PlanningTask) -> None:
    """Of two attitudes as far from level the first that is given; of others the nearer."""
    for one in ([0.0, -15.0, 0.0], [0.0, 15.0, 0.0], [0.0, 0.0, -12.0], [0.0, 0.0, 12.0]):
        angles = np.array([one, np.negative(one)])
        np.testing.assert_array_equal(_shortest_way(auv, angles), angles)
    far = np.array([[0.0, 20.0, 0.0], [0.0, -15.0, 0.0]])
    np.testing.assert_array_equal(_shortest_way(auv, far), far[::-1])
    np.testing.assert_array_equal(_route(auv, far).angles_deg, far)


def test_a_route_is_the_sum_of_a_flight_with_the_least_and_units_of_its_legs(auv: PlanningTask) -> None:
    """What is known before is in what no amount changes; a person's least is not counted twice."""
    angles = np.array([[0.0, 15.0, 5.0], [90.0, -15.0, 0.0], [180.0, 0.0, -10.0]])
    quadrotor = PlanningTask.of("quadrotor", load("standard-full", ["sampling.rate_hz=5"]), noise_std_nT=10.0)
    hand = PlanningTask.of(HAND, load("standard-full", ["sampling.rate_hz=5"]), noise_std_nT=10.0)
    for task in (auv, quadrotor, hand):
        known = np.eye(len(task.wanted))
        amounts = task.manoeuvre.least + np.array([1.0, 2.0, 3.0])
        phase = task.manoeuvre.phase([Leg.at(*leg) for leg in zip(angles, amounts, strict=True)])
        for asked, more in ((task, 0.0), (task.going_on(known, 0.0), known)):
            route = _route(asked, angles)
            whole = route.legs.fixed + np.tensordot(amounts, route.legs.each, 1) - more
            assert route.moving_s + amounts.sum() * route.legs.unit_s == pytest.approx(phase.duration_s, abs=0.11)
            flown = task.information(phase, 0.0, phase.duration_s)
            np.testing.assert_allclose(whole, flown, atol=0.03 * np.abs(flown).max())


def test_the_remaining_time_is_filled_where_that_is_better() -> None:
    """Pushes are whole: what is left of the time goes into longer ones."""
    task = PlanningTask.of("quadrotor", load("standard-full"), noise_std_nT=10.0)
    time_s = 205.0
    found = RouteSearch(task, time_s, (6,)).best(time_s)
    filled = found.filled
    a_push_s = 4.0 * 1.5
    assert time_s - a_push_s <= found.phase.duration_s < time_s - 1.0  # no leg is flown once more in what is left
    assert filled.phase.duration_s == pytest.approx(time_s, abs=0.1)
    assert filled.error < found.error
    assert filled.legs == found.legs
    assert replace(found, error=0.9 * filled.error).filled.error == 0.9 * filled.error


def test_every_way_of_the_manoeuvre_is_offered(hand: PlanningTask) -> None:
    ((choice, least),) = selections(hand, TIME_S)
    assert least < choice.error < 1.2 * least
    unable = next(iter(selections(hand, 20.0)))
    assert unable[0].error == np.inf


def test_thinning_leaves_the_candidates_that_the_optimum_needs() -> None:
    """Three orthogonal directions and a hundred weak ones between them: the three suffice."""
    rng = np.random.default_rng(4)
    weak = rng.standard_normal((100, 3))
    weak *= 0.05 / np.linalg.norm(weak, axis=1)[:, None]
    rows = np.concatenate([weak[:50], np.eye(3), weak[50:]])[:, None, :]
    many, least = few(rows, np.eye(3), (3, 10))
    assert sorted(least) == [50, 51, 52]
    assert 3 <= len(many) <= 10


def test_counts_bound_the_candidates_from_above() -> None:
    rows = np.random.default_rng(8).standard_normal((60, 1, 4))
    found = few(rows, np.eye(4), (5, 12, 8))
    assert [len(places) <= count for places, count in zip(found, (12, 8, 5), strict=True)] == [True] * 3
    assert all(set(fewer) <= set(more) for more, fewer in pairwise(found))
    assert len(found[-1]) >= 4


def test_attitudes_that_differ_by_half_a_degree_are_two() -> None:
    angles = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_array_equal(merged(angles), angles[[0, 2]])
    np.testing.assert_array_equal(merged(angles[:1]), angles[:1])
