"""What a leg tells of two hypotheses, where searched effects and those with a window are among them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.library.candidates import Candidate, iron_candidates
from diagnosis.next_leg.advice import HypothesisPair, LegProblem, pairs_of
from diagnosis.policy import STANDARD
from diagnosis.result import EvidenceKind, NamedEffect
from sim.effects.base import Effect
from sim.effects.currents import CurrentRipple, EddyCurrent, MotorCurrent
from sim.effects.dynamics import Latency
from sim.effects.earth import AttitudeMisalignment, FieldGradient, RegionalField
from sim.effects.iron import HardIron, HardIronDrift, SoftIron
from sim.effects.offsets import OffsetJump
from sim.effects.sources import LocalDipole
from sim.effects.temperature import TemperatureOffset
from tests.diagnosis.synthetic import problem

BODY = LocalDipole(position_enu_m=(45.0, 5.0, -20.0), moment_A_m2=(3000.0, 2000.0, -4000.0))


@pytest.fixture(scope="module")
def flown() -> LegProblem:
    return LegProblem(problem(n=2000), (), iron=True)


def named(effect: Effect, *alternatives: str) -> NamedEffect:
    return NamedEffect(effect, alternatives, EvidenceKind.HELD_OUT, 100.0, 1.0)


def test_a_body_is_moved_before_another_is_told_from_it(flown: LegProblem) -> None:
    metres_off = Candidate.of(BODY).at({"position_enu_m": (37.0, 12.0, -14.0)})
    assert flown.missing_nats(BODY, [metres_off]) < 1e-3 * flown.total_nats(BODY)
    assert flown.missing_nats(BODY, [Candidate(FieldGradient)]) > 0.1 * flown.total_nats(BODY)


def test_a_body_and_a_gradient_are_told_apart_nearer_to_the_body(flown: LegProblem) -> None:
    (pair,) = pairs_of(flown, named(BODY, "field_gradient"))
    here = flown.problem
    state = replace(here.state, pos_enu_m=here.state.pos_enu_m + np.array([15.0, 0.0, -8.0]))
    near = replace(flown, problem=replace(here, state=state))
    assert pair.separation_nats(near) > 0
    assert near.missing_nats(pair.first, pair.second_candidates) > 5 * flown.missing_nats(
        pair.first, pair.second_candidates
    )


def test_a_body_that_fits_at_no_place_beside_the_path_is_no_rival(flown: LegProblem) -> None:
    nowhere = replace(STANDARD, farthest_place_m=1e-3, farthest_share=1e-6)
    narrow = replace(flown, problem=replace(flown.problem, policy=nowhere))
    gradient = FieldGradient(gradient_nT_m=((1.0, 0.5, 0.0), (0.5, -2.0, 0.3), (0.0, 0.3, 1.0)))
    assert [*pairs_of(narrow, named(gradient, "local_dipole"))] == []
    assert [pair.second.name for pair in pairs_of(flown, named(gradient, "local_dipole"))] == ["local_dipole"]


def test_a_ripple_has_another_phase_in_another_run(flown: LegProblem) -> None:
    ripple = CurrentRipple(amplitude_nT_A=(3.0, -2.0, 4.0), frequency_hz=1.3, phase_deg=20.0)
    later = CurrentRipple(ripple.amplitude_nT_A, ripple.frequency_hz, phase_deg=75.0)
    assert flown.missing_nats(later, [Candidate.of(ripple)]) < 1e-9 * flown.total_nats(later)
    assert [pair.second.name for pair in pairs_of(flown, named(ripple, "motor_current"))] == ["motor_current"]


def test_what_acted_in_a_window_acts_all_along_on_the_leg(flown: LegProblem) -> None:
    switched = HardIron(offset_nT=(5.0, -3.0, 4.0), active_s=(80.0, 95.0))
    (pair,) = pairs_of(flown, named(switched, "temperature_offset"))
    assert pair.first == HardIron(offset_nT=switched.offset_nT)
    assert pair.second.active_s is None
    assert {one.window for one in (*pair.first_candidates, *pair.second_candidates)} == {None}
    assert pair.separation_nats(replace(flown, iron=False)) > 0


def test_a_leg_tells_no_more_than_it_shows_of_the_name(flown: LegProblem) -> None:
    """A leg far from where a gradient is nought shows that one well, and next to nothing of a small constant."""
    error = RegionalField(error_enu_nT=(0.05, -0.03, 0.04))
    other = FieldGradient(((0.1, 0.0, 0.05), (0.0, -0.3, 0.0), (0.05, 0.0, 0.2)), (5.0, 3.0, -3.0))
    pair = HypothesisPair(error, other, (Candidate(RegionalField),), (Candidate.of(other),), listed=True)
    assert flown.missing_nats(other, pair.first_candidates) > 10 * flown.total_nats(error)
    assert pair.separation_nats(flown) == flown.total_nats(error)


def test_a_leg_at_rest_tells_changes_of_the_iron_apart_only_where_iron_is_fitted(flown: LegProblem) -> None:
    turning = replace(flown, iron=False)
    (pair,) = pairs_of(turning, named(HardIron((30.0, -20.0, 10.0)), "soft_iron"))
    assert pair.separation_nats(turning) > 0
    assert pair.separation_nats(replace(turning, problem=replace(flown.problem, still=True))) == 0


@pytest.mark.parametrize(
    ("one", "second", "listed", "iron", "lacked", "missing", "nats"),
    [
        (HardIron, EddyCurrent, True, True, (5.0, 1.0), (), 1.0),
        (HardIron, EddyCurrent, False, True, (5.0, 1.0), (), 5.0),
        (FieldGradient, RegionalField, True, True, (5.0, 1.0), (), 5.0),
        (RegionalField, FieldGradient, True, True, (1.0, 5.0), (), 5.0),
        (HardIron, EddyCurrent, True, True, (5.0, 1.0), ("position",), 0.0),
        (Latency, EddyCurrent, True, True, (4.0, 4.0), (), 4.0),
        (Latency, EddyCurrent, True, True, (2.0, 2.0), (), 0.0),
        (HardIronDrift, TemperatureOffset, True, True, (18.0, 18.0), (), 0.0),
        (TemperatureOffset, HardIronDrift, True, True, (18.0, 18.0), (), 0.0),
        (HardIronDrift, TemperatureOffset, True, True, (20.0, 20.0), (), 20.0),
        (HardIron, EddyCurrent, True, True, (0.05, 0.05), (), 0.05),
        (HardIron, EddyCurrent, True, False, (0.05, 0.05), (), 0.0),
        (HardIron, EddyCurrent, True, False, (0.2, 0.2), (), 0.2),
    ],
)
def test_what_a_leg_tells_of_two_is_what_the_wrong_one_lacks_beyond_an_error_of_form(  # type: ignore[no-untyped-def]
    one, second, listed, iron, lacked, missing, nats
) -> None:
    """Of 100 nats: whichever of look-alikes is true, but what one makes of the other; of a kin, a course, the iron."""
    pair = HypothesisPair(one(), second(), (), (), listed)
    leg: Any = SimpleNamespace(
        iron=iron,
        problem=SimpleNamespace(policy=STANDARD, turns=True, missing_inputs=lambda effect: missing),
        total_nats=lambda true: 100.0,
        missing_nats=lambda true, wrong: lacked[0] if true is pair.first else lacked[1],
    )
    assert pair.separation_nats(leg) == nats


def test_a_name_is_told_from_what_another_run_can_show(flown: LegProblem) -> None:
    """Neither from a twin nor from an event of one run; a change of the iron also from all others."""

    def rivals(cause: NamedEffect) -> list[tuple[str, bool]]:
        return [(pair.second.name, pair.listed) for pair in pairs_of(flown, cause)]

    iron = [name for name in iron_candidates() if name not in (HardIron.name, SoftIron.name)]
    changed = replace(named(HardIron((5.0, -3.0, 4.0)), SoftIron.name), kind=EvidenceKind.IRON)
    assert rivals(changed) == [(SoftIron.name, True), *((name, False) for name in iron)]
    field = named(
        RegionalField((50.0, -30.0, 40.0)), AttitudeMisalignment.name, OffsetJump.name, "no such", Latency.name
    )
    assert rivals(field) == [(Latency.name, True)]


def test_settings_are_sought_in_the_window_of_what_was_named(flown: LegProblem) -> None:
    for window in ((80.0, 95.0), None):
        some = flown.settings("motor_current", HardIron((5.0, -3.0, 4.0), active_s=window), window)
        assert {one.window for one in some} == {window}


def test_a_name_may_look_like_another_at_every_setting_that_is_listed_for_it(flown: LegProblem) -> None:
    """Found with both motors' current, it may be one's."""
    (pair,) = pairs_of(flown, named(MotorCurrent(gain_nT_A=(3.0, -2.0, 4.0)), "hysteresis"))
    assert {dict(one.nonlinear)["motor"] for one in pair.first_candidates} == {0, 1, 2}


def test_a_setting_is_sought_in_what_the_iron_leaves(flown: LegProblem) -> None:
    """The tone that comes nearest a current's field, whose mean the iron takes up."""
    current = MotorCurrent(gain_nT_A=(20.0, 10.0, -5.0))
    found = flown.settings(CurrentRipple.name, current, None)
    tones = [Candidate(CurrentRipple, (("frequency_hz", f),)) for f in np.arange(0.1, 0.6, 0.005)]
    assert flown.missing_nats(current, found) < 1.001 * min(flown.missing_nats(current, [one]) for one in tones)


def test_a_listed_number_lies_between_its_neighbours_where_that_is_nearer(flown: LegProblem) -> None:
    between = HardIronDrift(rate_nT_h=(900.0, 200.0, 300.0), time_constant_s=170.0)
    listed = Candidate(HardIronDrift, (("time_constant_s", 100.0),))
    assert flown.missing_nats(between, [listed]) < 1e-4 * flown.total_nats(between)


def test_what_an_effect_adds_passes_what_acts_always_where_samples_are(flown: LegProblem) -> None:
    error, bent = RegionalField(error_enu_nT=(50.0, -30.0, 40.0)), SoftIron(((0.3, 0.0, 0.1), (0.0,) * 3, (0.0,) * 3))
    usable = (np.arange(len(flown.problem.state)) % 3 > 0).astype(float)
    here = replace(flown, problem=replace(flown.problem, usable=usable))
    sigma_nT = flown.problem.sigma_nT
    added_nT = flown.target(error) * sigma_nT @ (np.eye(3) + bent.coefficients().reshape(3, 3)).T
    assert replace(here, permanent=(bent,)).target(error) * sigma_nT == pytest.approx(added_nT * usable[:, None])


def test_what_the_iron_takes_up_already_lacks_all_of_an_effect(flown: LegProblem) -> None:
    assert flown.missing_nats(BODY, [Candidate(HardIron)]) == pytest.approx(flown.total_nats(BODY))
