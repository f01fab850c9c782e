"""Selection, changes of the iron, and each doubt of what was found."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision import conclusion
from diagnosis.decision.choice import AcceptedEffect, Selection, accept_best
from diagnosis.decision.conclusion import (
    absorbed_effects,
    beyond_wander,
    conclude,
    iron_changes,
    is_form_error,
    slow_noise,
)
from diagnosis.decision.selection import _is_form_of_accepted, _with_form_owner, select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import NAMED, CandidateResult, Evidence
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.evidence.slow_noise import SlowNoise
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD, Policy
from sim.effects import BY_NAME, EFFECTS
from sim.effects.base import Effect
from sim.effects.iron import HardIron
from sim.effects.noise import WhiteNoise
from tests.diagnosis.synthetic import ALL_BUT_SEVEN, COSTLY, problem, recording

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
WARM = next(effect for effect in EFFECTS if any(p.unit == "nT/K" for p in effect.parameters()))
KIN = tuple(effect for effect in EFFECTS if effect.traits.family)
CLEAN, LEFT = ResidualTests(()), ResidualTests(("means",))
NOISE = SlowNoise(WhiteNoise((1.0, 1.0, 1.0)), (), 50.0, identified=True, mean_std=0.1)


def _evidence(effect: type[Effect], gain: float, width: int, policy: Policy = STANDARD) -> Evidence:
    c, covariance = np.zeros(width), np.zeros((width, width))
    return Evidence(Candidate(effect), gain, 1.0, 1.0, 1.0, gain, c, covariance, 0.0, 0)


@pytest.fixture(scope="module")
def driven() -> Selection:
    """A selection with a current's field in it."""
    return select(problem(hidden={DRIVEN.name: {DRIVEN.linear[0]: [2.0, -1.0, 4.0]}}), COSTLY)


@pytest.fixture(scope="module")
def nothing() -> Selection:
    """A selection of white noise."""
    return select(problem())


def test_one_of_its_kin_that_gains_less_by_an_error_of_form_is_listed() -> None:
    best, near, far = (_evidence(effect, gain, 9) for effect, gain in zip(KIN, (1000.0, 980.0, 900.0), strict=True))
    chosen = accept_best((best, near, far, _evidence(DRIVEN, 990.0, 9)), STANDARD)
    assert chosen is not None
    assert {chosen.name, *chosen.alternatives} == {best.name, near.name}


@pytest.mark.parametrize(("more", "name"), [(0.05, "latency"), (50.0, "bandwidth")])
def test_a_low_pass_is_named_before_a_delay_only_where_it_does_better(more: float, name: str) -> None:
    low_pass, delay = (next(one for one in KIN if one.name == kin) for kin in ("bandwidth", "latency"))
    chosen = accept_best((_evidence(low_pass, 2000.0 + more, 1), _evidence(delay, 2000.0, 1)), STANDARD)
    assert chosen is not None
    assert chosen.name == name


def test_what_the_best_of_a_whole_library_gains_by_chance_is_not_accepted() -> None:
    needed = STANDARD.accepted(len(EFFECTS))
    assert needed == pytest.approx(np.log(100 * len(EFFECTS)))


def test_one_effect_is_found_and_leaves_nothing(driven: Selection) -> None:
    assert [one.name for one in driven.accepted] == [DRIVEN.name]
    assert driven.after.clean
    assert not driven.before.clean
    assert driven.results[0].name == DRIVEN.name
    assert driven.results[0].outcome == NAMED


def test_two_effects_are_found_one_after_the_other() -> None:
    hidden = {DRIVEN.name: {DRIVEN.linear[0]: [2.0, -1.0, 4.0]}, WARM.name: {WARM.linear[0]: [6.0, -5.0, 4.0]}}
    selection = select(problem(hidden=hidden), ALL_BUT_SEVEN)
    assert {one.name for one in selection.accepted} == {DRIVEN.name, WARM.name}
    others = frozenset(BY_NAME) - {DRIVEN.name, WARM.name}
    alone = select(problem(hidden=hidden, policy=Policy(most_effects=1)), others)
    assert len(alone.accepted) == 1


def test_nothing_is_found_in_white_noise(nothing: Selection) -> None:
    assert nothing.accepted == ()
    assert nothing.after.clean
    assert conclude(nothing).clean


def test_what_shrinks_beside_the_first_or_could_stand_for_it_is_its_form() -> None:
    """Small by itself is a name of its own; small because the first took most of it is not."""
    one = AcceptedEffect(replace(_evidence(DRIVEN, 500.0, 3), strength=1.0), (HardIron.name,))
    small = AcceptedEffect(replace(_evidence(WARM, 50.0, 3), strength=0.25), ())
    alone = [CandidateResult(replace(small.evidence, strength=s), 50.0, 8.0, "") for s in (0.3, 0.9)]
    start = Baseline.of(problem(n=300))
    so_far = Selection((one,), start, start, LEFT, LEFT, (), frozenset())
    assert not _is_form_of_accepted(small, replace(so_far, results=tuple(alone[:1])))
    assert _is_form_of_accepted(small, replace(so_far, results=tuple(alone[1:])))
    large = replace(small, evidence=replace(small.evidence, strength=0.4))
    assert not _is_form_of_accepted(large, replace(so_far, results=tuple(alone[1:])))
    again = AcceptedEffect(replace(_evidence(HardIron, 200.0, 1), strength=0.8), ())
    assert not _is_form_of_accepted(again, so_far)
    assert _with_form_owner(again, [one]).form_of == one.name
    assert _with_form_owner(again, [replace(one, alternatives=())]).form_of is None


def _wandering(selection: Selection, monkeypatch: pytest.MonkeyPatch, noise: SlowNoise | None) -> SlowNoise | None:
    """What is concluded of a rest that is not clean, and wanders as told."""
    monkeypatch.setattr(conclusion, "find_slow_noise", lambda problem, left: noise)
    return slow_noise(replace(selection, after=LEFT))


def test_slow_noise_without_effects_needs_only_to_fit(nothing: Selection, monkeypatch: pytest.MonkeyPatch) -> None:
    vague = replace(NOISE, identified=False)
    assert _wandering(nothing, monkeypatch, vague) is vague
    assert slow_noise(nothing) is None


def test_slow_noise_beside_effects_must_be_told_and_be_no_form(
    driven: Selection, monkeypatch: pytest.MonkeyPatch
) -> None:
    loud = replace(driven, end=driven.start)
    assert _wandering(loud, monkeypatch, NOISE) is NOISE
    assert _wandering(loud, monkeypatch, replace(NOISE, identified=False)) is None
    large = replace(driven.accepted[0], evidence=replace(driven.accepted[0].evidence, strength=1e3))
    assert _wandering(replace(loud, accepted=(large,)), monkeypatch, NOISE) is None


def test_what_is_left_beside_as_many_effects_as_are_looked_for_is_no_slow_noise(
    driven: Selection, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody has asked whether it is a further effect."""
    most = driven.end.problem.policy.most_effects
    for number, noise in ((most - 1, NOISE), (most, None)):
        several = replace(driven, end=driven.start, accepted=driven.accepted * number)
        assert _wandering(several, monkeypatch, NOISE) is noise


@pytest.fixture(scope="module")
def moved() -> Selection:
    """A selection of white noise beside another hard iron than the model's."""
    given = recording()
    return select(problem(replace(given, mag_nT=given.mag_nT + np.array([300.0, -200.0, 100.0]))), COSTLY)


def test_iron_is_asked_only_where_the_model_knows_it(moved: Selection, nothing: Selection) -> None:
    found = conclude(moved).iron
    assert len(found) == 1
    assert "hard_iron" in (found[0].name, *found[0].alternatives)
    unknown = replace(moved.end, problem=replace(moved.end.problem, iron_known=False))
    assert conclude(replace(moved, end=unknown)).iron == ()
    assert conclude(nothing).iron == ()


@pytest.mark.parametrize("found", [True, False])
@pytest.mark.parametrize(("wander", "kept"), [(0.9, True), (1.1, False)])
def test_a_wander_takes_constants_with_it_that_are_not_far_larger(
    wander: float, kept: bool, found: bool, moved: Selection
) -> None:
    """A tenth of the change, more or less: the mean of a noise that is found, or a stated noise itself."""
    (one,) = iron_changes(moved).changes
    most = wander * one.evidence.strength / 10
    left = np.full(moved.start.problem.target.shape, np.hypot(1.0, 0.1 * most if found else most))
    end: Any = SimpleNamespace(problem=moved.end.problem, residual=lambda: left)
    wandering, noise = replace(moved, end=end), replace(NOISE, mean_std=most) if found else None
    turn = Candidate(next(effect for effect in EFFECTS if effect.traits.absorbed and not effect.traits.constant))
    alike = AcceptedEffect(replace(one.evidence, candidate=turn), (one.name,))
    apart = replace(alike, alternatives=())
    assert beyond_wander((one, alike, apart), wandering, noise) == ((one, alike, apart) if kept else (apart,))


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
    first, selection = AcceptedEffect(replace(_evidence(DRIVEN, 500.0, 3), strength=10.0), ()), SimpleNamespace(end=end)
    assert is_form_error(selection, first) is form  # type: ignore[arg-type]
