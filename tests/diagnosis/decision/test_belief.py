"""Selection, changes of the iron, and each doubt of what was found."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision import belief
from diagnosis.decision.belief import (
    DOUBTS,
    Belief,
    believed,
    iron_differs,
    slow_noise_is_left,
    wander_moves_the_mean,
)
from diagnosis.decision.iron import absorbed_effects, iron_changes
from diagnosis.decision.selection import (
    Selection,
    _as_form,
    _is_form,
    _with_earth_vector,
    _without_what_has_no_name,
    select,
)
from diagnosis.decision.white_choice import Accepted, accepted
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_result import NAMED, CandidateResult
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.evidence.slow_noise import SlowNoise
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.blocks import BlockFit
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.iron import HardIron
from sim.effects.noise import WhiteNoise
from sim.effects.offsets import SensorOffset
from tests.diagnosis.synthetic import problem, recording

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
WARM = next(effect for effect in EFFECTS if any(p.unit == "nT/K" for p in effect.parameters()))
KIN = tuple(effect for effect in EFFECTS if effect.traits.family)
CLEAN, LEFT = ResidualTests({}, (), 0.0, ()), ResidualTests({}, (), 0.0, ("means",))
NOISE = SlowNoise(WhiteNoise((1.0, 1.0, 1.0)), (), 50.0, -100.0, fits=True, identified=True)


def _evidence(effect: type[Effect], gain: float, width: int, policy: Policy = STANDARD) -> Evidence:
    nothing = BlockFit(np.zeros((1, 1)), np.zeros(width), np.zeros((width, width)))
    return Evidence(Candidate(effect), gain, 1.0, 1.0, 1.0, None, nothing, width)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def driven() -> Selection:
    """A selection with a current's field in it."""
    return select(problem(hidden={DRIVEN.name: {DRIVEN.linear[0]: [2.0, -1.0, 4.0]}}))


@pytest.fixture(scope="module")
def nothing() -> Selection:
    """A selection of white noise."""
    return select(problem())


def test_the_narrowest_of_those_as_good_is_accepted() -> None:
    wide, narrow, far = _evidence(DRIVEN, 100.0, 9), _evidence(WARM, 98.0, 3), _evidence(HardIron, 20.0, 1)
    chosen = accepted((wide, narrow, far), STANDARD)
    assert chosen is not None
    assert chosen.name == WARM.name
    assert chosen.alternatives == (DRIVEN.name,)


def test_one_of_its_kin_that_gains_less_by_an_error_of_form_is_listed() -> None:
    best, near, far = (_evidence(effect, gain, 9) for effect, gain in zip(KIN, (1000.0, 980.0, 900.0), strict=True))
    chosen = accepted((best, near, far, _evidence(DRIVEN, 990.0, 9)), STANDARD)
    assert chosen is not None
    assert {chosen.name, *chosen.alternatives} == {best.name, near.name}


@pytest.mark.parametrize(("more", "name"), [(0.05, "latency"), (50.0, "bandwidth")])
def test_a_low_pass_is_named_before_a_delay_only_where_it_does_better(more: float, name: str) -> None:
    low_pass, delay = (next(one for one in KIN if one.name == kin) for kin in ("bandwidth", "latency"))
    chosen = accepted((_evidence(low_pass, 2000.0 + more, 1), _evidence(delay, 2000.0, 1)), STANDARD)
    assert chosen is not None
    assert chosen.name == name


@pytest.mark.parametrize("last_bit", [-1e-9, 0.0, 1e-9])
def test_of_two_that_are_the_same_the_first_of_the_chain_is_named(last_bit: float) -> None:
    iron, offset = _evidence(HardIron, 100.0, 3), _evidence(SensorOffset, 100.0 + last_bit, 3)
    for ranking in ((iron, offset), (offset, iron)):
        chosen = accepted(ranking, STANDARD)
        assert chosen is not None
        assert (chosen.name, chosen.alternatives) == ("hard_iron", ("sensor_offset",))


def test_what_the_best_of_a_whole_library_gains_by_chance_is_not_accepted() -> None:
    needed = STANDARD.accepted(len(EFFECTS))
    assert needed == pytest.approx(np.log(100 * len(EFFECTS)))
    assert accepted((_evidence(DRIVEN, needed - 0.1, 3),), STANDARD) is None
    assert accepted((_evidence(DRIVEN, needed + 0.1, 3),), STANDARD) is not None
    assert accepted((), STANDARD) is None


def test_one_effect_is_found_and_leaves_nothing(driven: Selection) -> None:
    assert [one.name for one in driven.found] == [DRIVEN.name]
    assert driven.after.clean
    assert not driven.before.clean
    assert driven.judged[0].name == DRIVEN.name
    assert driven.judged[0].outcome == NAMED


def test_two_effects_are_found_one_after_the_other() -> None:
    hidden = {DRIVEN.name: {DRIVEN.linear[0]: [2.0, -1.0, 4.0]}, WARM.name: {WARM.linear[0]: [6.0, -5.0, 4.0]}}
    selection = select(problem(hidden=hidden))
    assert {one.name for one in selection.found} == {DRIVEN.name, WARM.name}
    alone = select(problem(hidden=hidden, policy=Policy(most_effects=1)))
    assert len(alone.found) == 1


def test_nothing_is_found_in_white_noise(nothing: Selection) -> None:
    assert nothing.found == ()
    assert nothing.after.clean
    assert believed(nothing).clean


def test_a_constant_vector_of_the_earth_that_is_left_is_told() -> None:
    """A constant error of the field cannot be taken up by the base where the vehicle turns."""
    given = recording()
    error = np.einsum("nji,j->ni", problem(given).state.R_wb, np.array([3.0, -2.0, 0.0]))
    off = Baseline.of(problem(replace(given, mag_nT=given.mag_nT + error)))
    assert _with_earth_vector(CLEAN, off).why == ("a constant vector in the earth's frame",)
    assert _with_earth_vector(CLEAN, Baseline.of(problem(given))).clean


def test_what_has_no_name_of_its_own_speaks_against_no_other_but_one_of_the_place() -> None:
    ground = Baseline.of(problem())
    placed = next(effect for effect in EFFECTS if effect.traits.field_source)
    for effect, clean in ((DRIVEN, True), (placed, False)):
        found = [Accepted(_evidence(effect, 100.0, 3), ())]
        assert _without_what_has_no_name(LEFT, ground, found).clean is clean
    assert _without_what_has_no_name(LEFT, ground, []) is LEFT


def test_what_shrinks_beside_the_first_or_could_stand_for_it_is_its_form() -> None:
    """Small by itself is a name of its own; small because the first took most of it is not."""
    one = Accepted(replace(_evidence(DRIVEN, 500.0, 3), strength=1.0), (HardIron.name,))
    small = Accepted(replace(_evidence(WARM, 50.0, 3), strength=0.25), ())
    alone = [CandidateResult(replace(small.evidence, strength=s), 50.0, 8.0, "") for s in (0.3, 0.9)]
    assert not _is_form(small, [one], alone[:1], STANDARD)
    assert _is_form(small, [one], alone[1:], STANDARD)
    large = replace(small, evidence=replace(small.evidence, strength=0.4))
    assert not _is_form(large, [one], alone[1:], STANDARD)
    again = Accepted(replace(_evidence(HardIron, 200.0, 1), strength=0.8), ())
    assert not _is_form(again, [one], [], STANDARD)
    assert _as_form(again, [one]).form_of == one.name
    assert _as_form(again, [replace(one, alternatives=())]).form_of is None


def _believed(selection: Selection, **changes: object) -> Belief:
    return replace(Belief(selection, selection.found), **changes)  # type: ignore[arg-type]


def _wandering(selection: Selection, monkeypatch: pytest.MonkeyPatch, noise: SlowNoise | None) -> Belief:
    """A belief whose rest is not clean, and wanders as told."""
    monkeypatch.setattr("diagnosis.decision.belief.wander", lambda problem, left: noise)
    return slow_noise_is_left(_believed(replace(selection, after=LEFT)))


def test_slow_noise_without_effects_needs_only_to_fit(nothing: Selection, monkeypatch: pytest.MonkeyPatch) -> None:
    vague = replace(NOISE, identified=False)
    assert _wandering(nothing, monkeypatch, vague).noise is vague
    assert _wandering(nothing, monkeypatch, replace(NOISE, fits=False)).noise is None
    assert slow_noise_is_left(_believed(nothing)).noise is None


def test_slow_noise_beside_effects_must_be_told_and_be_no_form(
    driven: Selection, monkeypatch: pytest.MonkeyPatch
) -> None:
    loud = replace(driven, end=driven.start)
    assert _wandering(loud, monkeypatch, NOISE).noise is NOISE
    assert _wandering(loud, monkeypatch, replace(NOISE, identified=False)).noise is None
    large = replace(driven.found[0], evidence=replace(driven.found[0].evidence, strength=1e3))
    assert _wandering(replace(loud, found=(large,)), monkeypatch, NOISE).noise is None


def test_what_is_left_beside_as_many_effects_as_are_looked_for_is_no_slow_noise(
    driven: Selection, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody has asked whether it is a further effect."""
    most = driven.end.problem.policy.most_effects
    for number, noise in ((most - 1, NOISE), (most, None)):
        several = replace(driven, end=driven.start, found=driven.found * number)
        assert _wandering(several, monkeypatch, NOISE).noise is noise


def test_iron_is_asked_only_where_the_model_knows_it() -> None:
    given = recording()
    moved = replace(given, mag_nT=given.mag_nT + np.array([30.0, -20.0, 10.0]))
    selection = select(problem(moved))
    found = iron_differs(_believed(selection)).iron
    assert len(found) == 1
    assert "hard_iron" in (found[0].name, *found[0].alternatives)
    ground = replace(selection.end, problem=replace(selection.end.problem, iron_known=False))
    assert iron_differs(_believed(replace(selection, end=ground))).iron == ()


def test_the_iron_of_the_model_itself_has_not_changed(nothing: Selection) -> None:
    assert iron_changes(nothing).found == ()


def test_a_wander_takes_constants_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("diagnosis.decision.belief._excess", lambda _: 2.0)
    given = recording()
    selection = select(problem(replace(given, mag_nT=given.mag_nT + np.array([30.0, -20.0, 10.0]))))
    belief = iron_differs(_believed(selection))
    assert wander_moves_the_mean(belief).iron == belief.iron
    assert wander_moves_the_mean(replace(belief, noise=NOISE)).iron == ()
    (one,) = belief.iron
    turn = Candidate(next(effect for effect in EFFECTS if effect.traits.absorbed and not effect.traits.constant))
    alike = Accepted(replace(one.evidence, candidate=turn), (one.name,))
    assert wander_moves_the_mean(replace(belief, iron=(alike,), noise=NOISE)).iron == ()
    apart = replace(alike, alternatives=())
    assert wander_moves_the_mean(replace(belief, iron=(apart,), noise=NOISE)).iron == (apart,)


@pytest.mark.parametrize(("excess", "kept"), [(0.9, True), (1.1, False)])
def test_a_constant_far_larger_than_a_wander_is_none_of_its(
    excess: float, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tenth of it, more or less."""
    given = recording()
    selection = select(problem(replace(given, mag_nT=given.mag_nT + np.array([300.0, -200.0, 100.0]))))
    told = replace(iron_differs(_believed(selection)), noise=NOISE)
    monkeypatch.setattr("diagnosis.decision.belief._excess", lambda _: excess * told.iron[0].evidence.strength / 10)
    assert bool(wander_moves_the_mean(told).iron) is kept


def test_doubts_are_asked_in_their_order(driven: Selection) -> None:
    assert believed(driven).found == driven.found
    assert DOUBTS.index(slow_noise_is_left) < DOUBTS.index(iron_differs) < DOUBTS.index(wander_moves_the_mean)


def test_on_a_still_vehicle_everything_looks_like_iron() -> None:
    given = recording()
    assert given.att_q is not None
    still = replace(given, att_q=np.tile(given.att_q[:1], (len(given), 1)), mag_nT=given.mag_nT[:1] + given.mag_nT * 0)
    still = replace(still, mag_nT=still.mag_nT + np.random.default_rng(0).normal(size=given.mag_nT.shape))
    assert len(absorbed_effects(problem(still))) > len(absorbed_effects(problem(given)))


@pytest.mark.parametrize(("left", "form"), [(2.4, True), (2.6, False)])
def test_slow_noise_of_a_quarter_of_the_first_effect_is_its_form(left: float, form: bool) -> None:
    """Of ten sigma; what is left is beyond the noise of a sample."""
    residual = np.full((9, 3), np.sqrt(1 + left**2))
    end = SimpleNamespace(residual=lambda: residual, problem=SimpleNamespace(policy=STANDARD))
    first = SimpleNamespace(evidence=SimpleNamespace(strength=10.0))
    one: Any = SimpleNamespace(selection=SimpleNamespace(end=end), found=[first])
    assert belief._is_form(one) is form
