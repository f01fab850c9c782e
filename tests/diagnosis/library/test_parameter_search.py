"""Moments, tones and places are found where they were put, on series whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.evidence.baseline import Baseline
from diagnosis.library.candidates import Candidate
from diagnosis.library.dipole_position import ThinnedPath
from diagnosis.library.parameter_search import SEARCHES, refine_between_neighbours, search_parameters, step_gains
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known, Level
from diagnosis.problem.linear import LinearProblem
from recordings import Recording
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.earth import RegionalField
from sim.effects.parameters import Role
from sim.rotation import matrix_from_q
from tests.diagnosis.synthetic import FIELD_ENU_NT, HZ, STRENGTH_NT, problem, recording, without_attitude


def _sought(role: Role) -> type[Effect]:
    return next(effect for effect in EFFECTS if effect.search_role() == role)


def _value(candidate: Candidate, role: Role) -> Array:
    name = candidate.effect.with_role(role)
    assert name is not None
    return np.asarray(dict(candidate.nonlinear)[name])


def _left(posed: LinearProblem) -> Array:
    return Baseline.of(posed).residual()


def _stepped(at: int, step_nT: tuple[float, float, float]) -> LinearProblem:
    given = recording()
    mag = given.mag_nT.copy()
    mag[at:] += step_nT
    return problem(replace(given, mag_nT=mag))


@pytest.mark.parametrize("at", [700, 2000, 3500])
def test_the_moment_of_a_step_is_its_sample(at: int) -> None:
    posed = _stepped(at, (8.0, -6.0, 4.0))
    (found,) = search_parameters(posed, _left(posed), [Candidate(_sought("moment"))])
    assert float(_value(found, "moment")) == pytest.approx(at / HZ, abs=1.5 / HZ)
    assert found.tried == 4000


def test_the_gain_of_a_moment_is_that_of_dense_least_squares() -> None:
    posed = _stepped(1500, (3.0, 2.0, -1.0))
    left = _left(posed)
    t = 1500
    step = np.r_[np.zeros(t), np.ones(len(left) - t)]
    step -= posed.base @ np.linalg.lstsq(posed.base, step, rcond=None)[0]
    dense = ((step @ left) ** 2).sum() / (step @ step)
    assert step_gains(posed, left, Candidate(_sought("moment")))[t] == pytest.approx(dense, rel=1e-6)


def test_a_step_is_found_through_the_strength_alone() -> None:
    given = recording()
    mag = given.mag_nT.copy()
    mag[1800:] += (30.0, -20.0, 25.0)
    posed = problem(without_attitude(replace(given, mag_nT=mag)))
    candidate = Candidate(_sought("moment"))
    (found,) = search_parameters(posed, _left(posed), [candidate])
    assert float(_value(found, "moment")) == pytest.approx(180.0, abs=5.0)


def _on_long_legs(at: int) -> LinearProblem:
    """A log without attitude of a vehicle that keeps its heading for long: iron takes up most of a small step."""
    rng = np.random.default_rng(5)
    t = np.arange(3000) / HZ
    yaw = np.repeat(rng.uniform(0, 2 * np.pi, 6), 500) + 0.05 * np.sin(0.4 * t)
    pitch = 0.45 * np.sign(np.sin(2 * np.pi * t / 170)) + 0.02 * np.sin(0.9 * t)
    turn = Rotation.from_euler("ZYX", np.column_stack([yaw, pitch, 0.2 * np.sin(0.021 * t)]))
    mag = turn.inv().apply(FIELD_ENU_NT) + 2.0 * rng.normal(size=(3000, 3))
    mag[at:] += (6.0, -4.0, 5.0)
    return problem(Recording(time_s=t, mag_nT=mag))


@pytest.mark.parametrize("at", [900, 1700, 2300])
def test_a_step_is_found_beside_iron_that_takes_up_most_of_it(at: int) -> None:
    posed = _on_long_legs(at)
    candidate = Candidate(_sought("moment"))
    (found,) = search_parameters(posed, _left(posed), [candidate])
    assert float(_value(found, "moment")) == pytest.approx(at / HZ, abs=5.0)


def test_noise_is_not_fitted_to_itself_where_a_sensor_rests() -> None:
    """Level and at rest the measured direction holds noise alone, which is that of the strength: 170 nats of none."""
    rng = np.random.default_rng(7)
    t = np.arange(4000) / HZ
    yaw = 0.3 * np.clip(t - 40, 0, None)
    tilt = 0.01 * rng.normal(size=(4000, 2)) * (t > 40)[:, None]
    turn = Rotation.from_euler("ZYX", np.column_stack([yaw, tilt]))
    uneven = np.diag([1.0, 1.1, 2.0])
    mag = turn.inv().apply([200.0, 41_300.0, 8_300.0]) @ uneven + [0.0, 0.0, 20_000.0] + 45 * rng.normal(size=(4000, 3))
    posed = pose(Recording(time_s=t, mag_nT=mag), Known(None, 42_100.0))
    assert step_gains(posed, _left(posed), Candidate(_sought("moment"))).max() / 2 < 15


def test_the_gain_along_the_field_is_that_of_dense_least_squares() -> None:
    """Summed in pieces, with samples left out."""
    whole = _on_long_legs(1700)
    posed = whole.without(np.arange(3000) % 7 == 0)
    _as_dense(posed, (1234, 1701))


def test_so_it_is_of_strength_and_dip() -> None:
    given = recording(hidden={"offset_jump": {"time_s": 170.0, "step_nT": [3.0, -5.0, 4.0]}})
    assert given.att_q is not None
    level = Level.of(matrix_from_q(given.att_q), FIELD_ENU_NT, STANDARD)
    posed = pose(without_attitude(given), Known(FIELD_ENU_NT, STRENGTH_NT, level=level))
    _as_dense(posed.without(np.arange(4000) % 7 == 0), (1234, 1701))
    (found,) = search_parameters(posed, _left(posed), [Candidate(_sought("moment"))])
    assert dict(found.nonlinear)["time_s"] == pytest.approx(170.0, abs=1.0)


def _as_dense(posed: LinearProblem, at: tuple[int, ...]) -> None:
    """Whether the gain at these samples is that of dense least squares over all outputs."""
    left, n = _left(posed), len(posed.target)
    E = Candidate(_sought("moment")).columns(posed)
    base = posed.base.reshape(left.size, -1)
    for t in at:
        step = np.where((np.arange(n) >= t)[:, None, None], E, 0.0).reshape(left.size, 3)
        step -= base @ np.linalg.lstsq(base, step, rcond=None)[0]
        y = step @ np.linalg.lstsq(step, left.ravel(), rcond=None)[0]
        assert step_gains(posed, left, Candidate(_sought("moment")))[t] == pytest.approx(y @ y, rel=1e-3)


@pytest.mark.parametrize("tone_hz", [0.3217, 1.2345, 3.9])
def test_a_tone_is_found_between_the_lines(tone_hz: float) -> None:
    given = recording()
    assert given.current_A is not None
    wave = given.current_A.sum(axis=1) * np.sin(2 * np.pi * tone_hz * given.time_s + 0.7)
    posed = problem(replace(given, mag_nT=given.mag_nT + wave[:, None] * np.array([0.8, 0.3, -0.5])))
    motor = _sought("frequency").with_role("motor")
    assert motor is not None
    (found,) = search_parameters(posed, _left(posed), [Candidate(_sought("frequency"), ((motor, 0),))])
    assert float(_value(found, "frequency")) == pytest.approx(tone_hz, abs=1e-3)


def test_the_frequency_of_a_ripple_is_found_across_gaps() -> None:
    """Taken one after the other the samples would be out of step after each gap."""
    given = recording()
    there = np.ones(len(given), bool)
    for first in (700, 1900, 2900):
        there[first : first + 37] = False
    wave = np.sin(2 * np.pi * 1.237 * given.time_s) * given.current_A[:, 0]
    waving = replace(given, mag_nT=given.mag_nT + wave[:, None] * np.array([0.8, 0.3, -0.5]))
    posed = problem(waving.taken(there))
    (found,) = search_parameters(posed, _left(posed), [Candidate(_sought("frequency"))])
    assert float(_value(found, "frequency")) == pytest.approx(1.237, abs=1e-3)


def test_a_ripple_along_a_field_that_turns_is_found_where_its_line_is_split() -> None:
    """One axis lies along the field and against it in turn: the strength shows two lines beside the ripple's own."""
    given = recording(noise_nT=1.0)
    wave = 2 * np.sin(2 * np.pi * 1.237 * given.time_s) * given.current_A.sum(axis=1)
    posed = problem(without_attitude(replace(given, mag_nT=given.mag_nT + wave[:, None] * np.array([1.0, 0.0, 0.0]))))
    (found,) = search_parameters(posed, _left(posed), [Candidate(_sought("frequency"))])
    assert float(_value(found, "frequency")) == pytest.approx(1.237, abs=1e-3)


def test_a_ripple_is_never_slower_than_the_policy_says() -> None:
    given = recording()
    slow = 20 * np.sin(2 * np.pi * 0.02 * given.time_s)
    posed = problem(replace(given, mag_nT=given.mag_nT + slow[:, None]))
    (found,) = search_parameters(posed, _left(posed), [Candidate(_sought("frequency"))])
    assert float(_value(found, "frequency")) > posed.policy.slowest_tone_hz - 1 / 400


def _with_dipole(place: Array) -> LinearProblem:
    effect = _sought("place")
    hidden = {effect.name: {effect.with_role("place"): place.tolist(), effect.linear[0]: [60.0, -40.0, 80.0]}}
    return problem(hidden=hidden)


def test_a_dipole_is_found_at_its_place() -> None:
    place = np.array([8.0, 14.0, -8.0])
    posed = _with_dipole(place)
    found = search_parameters(posed, _left(posed), [Candidate(_sought("place"))])
    assert found
    assert min(np.linalg.norm(_value(one, "place") - place) for one in found) < 0.5


@pytest.mark.parametrize(("up_m", "beside"), [(0.4, False), (0.6, True), (59.0, True), (61.0, False)])
def test_a_body_lies_beside_the_path_and_not_far_off(up_m: float, beside: bool) -> None:
    posed = problem()
    thin = ThinnedPath.of(posed, _left(posed))
    top = thin.path[np.argmax(thin.path[:, 2])]
    assert thin.is_beside(top + np.array([0.0, 0.0, up_m])) is beside


@pytest.mark.parametrize("scale", [0.04, 30.0], ids=["in a hand", "from the air"])
def test_a_dipole_is_found_at_the_scale_of_its_path(scale: float) -> None:
    """The same turns along a path of 1.6 m or 1200 m past a body as much nearer or farther, its field the same."""
    effect, given = _sought("place"), recording()
    assert given.pos_enu_m is not None
    near = effect.with_role("place")
    assert near is not None
    place, moment = np.array([8.0, 14.0, -8.0]) * scale, np.array([60.0, -40.0, 80.0]) * scale**3
    moved = replace(given, pos_enu_m=given.pos_enu_m * scale)
    body = effect(**{near: place.tolist(), effect.linear[0]: moment.tolist()})
    state = problem(moved).state
    added = body.contribution(state, state.field_nT, np.random.default_rng(0), {})
    posed = problem(replace(moved, mag_nT=moved.mag_nT + added))
    found = search_parameters(posed, _left(posed), [Candidate(effect)])
    assert min(np.linalg.norm(_value(one, "place") - place) for one in found) < 0.5 * scale


@pytest.mark.parametrize("origin", [(5.0, -8.0, 2.0), (200.0, 150.0, -120.0)])
def test_an_origin_is_found_but_for_what_a_scale_takes_up(origin: tuple[float, float, float]) -> None:
    """The found and the true origin give the same field across the earth's; no place is nearer to the path."""
    G = np.array([[0.4, -0.2, 0.1], [-0.2, 0.3, 0.5], [0.1, 0.5, -0.7]])
    posed = problem(hidden={"field_gradient": {"gradient_nT_m": G.tolist(), "origin_enu_m": list(origin)}})
    given, found = search_parameters(posed, _left(posed), [Candidate(_sought("origin"))])
    assert given.tried == 1 < found.tried
    F = posed.state.field_enu_nT / STRENGTH_NT
    constant_nT = G @ (np.array(origin) - _value(found, "origin"))
    assert constant_nT - F * (F @ constant_nT) == pytest.approx([0, 0, 0], abs=0.02 * np.linalg.norm(G @ origin) + 1)
    middle = posed.state.pos_enu_m.mean(axis=0)
    free = np.linalg.solve(G, F)  # along it an origin may move
    assert abs((_value(found, "origin") - middle) @ free) < 0.02 * np.linalg.norm(origin) * np.linalg.norm(free)


def test_no_origin_is_tried_beyond_its_bounds() -> None:
    """A constant of the earth's frame and next to no gradient: the origin would lie beyond all places."""
    sought = Candidate(_sought("origin"))
    G = np.diag([1.0, 1.0, -2.0]) * 1e-7
    posed = problem(hidden={"field_gradient": {"gradient_nT_m": G.tolist()}}, noise_nT=1e-9)
    constant = posed.whitened(posed.state.R_wb.transpose(0, 2, 1), RegionalField) @ np.array([9e3, 0.0, 0.0])
    assert [one.tried for one in search_parameters(posed, _left(posed) + constant, [sought])] == [1]


def test_unit_dipoles_are_the_effects_own() -> None:
    """What the search's kernel leaves of the effect's field at the true place is nothing."""
    effect, place = _sought("place"), np.array([8.0, 14.0, -8.0])
    posed = problem(noise_nT=1e-6)
    name = effect.with_role("place")
    assert name is not None
    columns = Candidate(effect, ((name, tuple(place)),)).columns(posed)
    thin = ThinnedPath.of(posed, columns @ np.array([1.0, -2.0, 0.5]))
    assert np.linalg.norm(thin.residual(place)) < 0.01 * np.linalg.norm(thin.y)


def test_every_role_that_must_be_sought_has_a_search() -> None:
    assert {effect.search_role() for effect in EFFECTS} - {None} == set(SEARCHES)


def test_what_has_no_search_stays_as_it_is() -> None:
    members = [Candidate(effect) for effect in EFFECTS if effect.search and not effect.search_role()][:1]
    assert search_parameters(problem(), np.zeros((4000, 3)), members) == members


@pytest.mark.parametrize(
    "effect", [e for e in EFFECTS if len(e.search) == 1 and not e.search_role()], ids=lambda e: e.name
)
def test_a_listed_number_moves_between_its_neighbours(effect: type[Effect]) -> None:
    """A misfit with its minimum between two listed values: it is found, to a percent, from there and from between."""
    ((name, listed),) = effect.search.items()
    low, high = listed[-2], listed[-1]
    truth = float(np.sqrt(max(low, 1e-2 * high) * high))

    def misfit(candidate: Candidate) -> float:
        return float(np.log(dict(candidate.nonlinear)[name] / truth) ** 2)

    for start in (high, 0.7 * low + 0.3 * high):
        found = refine_between_neighbours(Candidate(effect, ((name, start),)), misfit)
        assert found is not None
        assert dict(found.nonlinear)[name] == pytest.approx(truth, rel=0.03)
        assert found.tried == len(listed)


def _tone(frequency_hz: float, n: int) -> float:
    """The tone that is found in a ripple of one that the current drives."""
    posed = problem(n=n)
    wave = np.sin(2 * np.pi * frequency_hz * posed.state.time_s) * posed.state.current_of(0)
    (found,) = search_parameters(posed, wave[:, None] * np.ones(3), [Candidate(_sought("frequency"))])
    return float(_value(found, "frequency"))


@pytest.mark.parametrize(
    ("frequency_hz", "n", "found"), [(0.085, 4000, False), (0.115, 4000, True), (0.13, 200, False), (0.25, 200, True)]
)
def test_a_ripple_is_no_slower_than_motion_and_goes_round_four_times(frequency_hz: float, n: int, found: bool) -> None:
    """A tenth of a hertz; four cycles in 20 s are a fifth."""
    assert (_tone(frequency_hz, n) == pytest.approx(frequency_hz, abs=0.2 / (n / HZ))) is found


@pytest.mark.parametrize(("share", "found"), [(0.003, False), (0.012, True)])
def test_a_jump_at_an_end_is_not_told_from_iron(share: float, found: bool) -> None:
    """A step's own part of the constant is 4 s (1 - s) of the most: 2 % of that."""
    posed = problem(n=4000)
    at = round(4000 * (1 - share))
    jump = posed.target + 1e4 * (np.arange(4000) >= at)[:, None]
    (one,) = search_parameters(posed, jump, [Candidate(_sought("moment"))])
    assert (abs(float(_value(one, "moment")) - float(posed.state.time_s[at])) < 0.15) is found


def test_a_step_explains_no_more_than_there_is_where_iron_explains_all_to_rounding() -> None:
    """A sphere about a hard iron of 300 nT without noise: at its ends iron leaves rounding of a step's columns."""
    t = np.arange(1500) / HZ
    turn, height = 0.6 * t, np.sin(0.21 * t)
    wide = np.sqrt(1 - height**2)
    mag = 40_000.0 * np.column_stack([wide * np.cos(turn), wide * np.sin(turn), height]) + [300.0, 0.0, 0.0]
    posed = pose(Recording(time_s=t, mag_nT=mag), Known(None, 40_000.0))
    left = _left(posed)
    gain = step_gains(posed, left, Candidate(_sought("moment")))
    assert gain.min() >= 0.0
    assert gain.max() <= (left**2).sum()
