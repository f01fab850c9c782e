"""The loop: the best candidate goes in, the rest are judged beside it, until nothing gains or what is left is clean."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from diagnosis.decision.coloured_choice import beside_colour
from diagnosis.decision.first_forms import fuller
from diagnosis.decision.forms import in_full
from diagnosis.decision.motors import each_by_itself
from diagnosis.decision.white_choice import Accepted, Round, are_kin, beside_white_noise
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_result import CandidateResult
from diagnosis.evidence.field_pulsations import pulses
from diagnosis.evidence.held_out import Evidence, judge, ranked
from diagnosis.evidence.model_noise import as_stated
from diagnosis.evidence.residual_tests import ResidualTests, battery
from diagnosis.evidence.windowed_candidates import windowed
from diagnosis.library.candidates import Candidate, proposed
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from sim.effects import BY_NAME
from sim.effects.earth import RegionalField
from sim.state import MOTION

Progress = Callable[[str], object]


@dataclass(frozen=True)
class Selection:
    """What the loop found: effects in order, the ground with all of them in, and the tests before and after.

    without: names that were left out of the library; judged: every candidate of the first round, the strongest first.
    """

    found: tuple[Accepted, ...]
    start: Baseline
    end: Baseline
    before: ResidualTests
    after: ResidualTests
    judged: tuple[CandidateResult, ...]
    without: frozenset[str]


def select(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Effects one after the other, each accepted on held-out evidence.

    without : names left out of the library (the bench's leave-one-out).
    """
    start = ground = Baseline.of(problem)
    before = after = residual_tests(ground, ())
    if before.clean and as_stated(problem, ground.residual()):  # slow errors that the model states look like effects
        return Selection((), start, start, before, before, (), without)
    members = proposed(problem, without)
    found: list[Accepted] = []
    first: tuple[CandidateResult, ...] = ()
    for number in range(problem.policy.most_effects):
        if found and after.clean:
            break
        say(f"candidates, round {number + 1}")
        this = _round(ground, members, found, start, after)
        first, chosen = first or this.judged, this.chosen
        if chosen is None:
            after = _without_what_has_no_name(after, ground, found)
            break
        if _has_no_name(chosen, found, first, ground):
            form, chosen = chosen, _beyond_form(ground, members, found, start, chosen, first)
            if chosen is None:
                found = _with_kin(found, form)
                break
        found = _settled_beside(chosen, found, members, start)
        found.append(_as_form(chosen, found))
        ground = start  # the columns of the last one are let go before others are made
        found, ground, after = _with_forms(found, start)
    return Selection(tuple(found), start, ground, before, after, first, without)


def _with_forms(found: Sequence[Accepted], start: Baseline) -> tuple[list[Accepted], Baseline, ResidualTests]:
    """Effects as single motors and in their fuller forms, with the ground and the tests of what is left."""
    tests = partial(tests_beside, found=names_of(found))
    return in_full(each_by_itself(found, start, tests), start, tests)


def _round(
    ground: Baseline,
    members: dict[str, list[Candidate]],
    found: Sequence[Accepted],
    start: Baseline,
    tests: ResidualTests,
    *,
    alone: bool = False,
) -> Round:
    """The next effect: beside white noise where what is left is clean, else beside a rest with its own colour.

    alone : no other effect is looked for beside one that is doubted.
    """
    ranking = ranked(ground, members)
    if tests.clean:
        return beside_white_noise(ranking, ground.problem.policy)
    before = names_of(found)

    def is_clean(after: Baseline, name: str) -> bool:
        return residual_tests(after, [*before, name]).clean

    def beyond(with_it: Baseline, one: Evidence) -> Accepted | None:
        left = tests_beside(with_it, [*before, one.name])
        return None if left.clean else _round(with_it, members, found, start, left, alone=True).chosen

    switched = windowed(ground, ranking, members)
    full = (*fuller(ground, members, is_clean), *pulses(ground, members))
    return beside_colour(ground, ranking, start, is_clean, switched, full, None if alone else beyond)


def names_of(found: Sequence[Accepted]) -> list[str]:
    """Names of accepted effects."""
    return [one.name for one in found]


def residual_tests(ground: Baseline, found: Sequence[str]) -> ResidualTests:
    """The tests of what a ground leaves; slow errors that the model itself states pass them.

    After a low-pass or a delay the noise has a memory of some samples.
    """
    problem, left = ground.problem, ground.residual()
    fitted = problem.fitted + ground.sums.width
    filtered = any(BY_NAME[name].traits.correlates_noise for name in found)
    samples = problem.policy.filter_memory if filtered else 1
    tests = battery(left, problem.usable, problem.state.time_s, fitted, problem.policy, samples)
    return tests if tests.clean or not as_stated(problem, left) else replace(tests, why=())


def tests_beside(ground: Baseline, found: Sequence[str]) -> ResidualTests:
    """The tests of what a ground leaves that has effects in."""
    return _with_earth_vector(residual_tests(ground, found), ground)


def _without_what_has_no_name(tests: ResidualTests, ground: Baseline, found: Sequence[Accepted]) -> ResidualTests:
    """The tests of what a ground leaves where nothing more stands: a constant error of the field was no name.

    Beside an effect that depends on the place it stays a doubt.
    """
    if not found or any(one.evidence.candidate.effect.traits.field_source for one in found):
        return tests
    return residual_tests(ground, names_of(found))


def _with_kin(found: Sequence[Accepted], chosen: Accepted) -> list[Accepted]:
    """Effects, those of another's kin with it among their look-alikes: what it takes is their form."""
    out = []
    for one in found:
        if are_kin(one.evidence, chosen.evidence):
            names = dict.fromkeys((*one.alternatives, chosen.name, *chosen.alternatives))
            one = replace(one, alternatives=tuple(name for name in names if name != one.name))
        out.append(one)
    return out


def _has_no_name(
    chosen: Accepted, found: Sequence[Accepted], first: Sequence[CandidateResult], ground: Baseline
) -> bool:
    """Whether an effect is only the form of what is in, is undone by it, or takes what it leaves by its growth."""
    form = _is_form(chosen, found, first, ground.problem.policy)
    return form or _is_undone(chosen, found, ground) or _grows_with_time(chosen, found, ground)


def _is_undone(chosen: Accepted, found: Sequence[Accepted], ground: Baseline) -> bool:
    """Whether what is in undoes nearly all of an effect, as a body that moves away does a constant of the field.

    One that could stand for what is in shares its course, and both are one cause.
    """
    alike = any(chosen.name in one.alternatives or one.name in chosen.alternatives for one in found)
    kept = ground.problem.policy.absorbed_survival * chosen.evidence.strength
    return bool(found) and not alike and chosen.evidence.taken_from(ground) < kept


def _grows_with_time(chosen: Accepted, found: Sequence[Accepted], ground: Baseline) -> bool:
    """Whether an effect explains less than one that is in, and that a channel drives, would by growing or fading.

    That is its columns times the time; and of no use beside them. Both by all data: what an effect adds at the start
    alone is not determined by what is held out there.
    """
    problem, policy = ground.problem, ground.problem.policy
    columns = chosen.columns(problem)
    own = ground.evidence_on_all(columns)
    clock = problem.state.time_s - problem.state.time_s.mean()
    driven = [one for one in found if not MOTION.issuperset(one.evidence.candidate.effect.needs)]
    grown = (one.columns(problem) * clock[:, None, None] for one in driven)
    better = (one for one in grown if ground.evidence_on_all(one) > max(own, 0.0) + policy.apart)
    return any(ground.beside(one).evidence_on_all(columns) < policy.look_alike_left * own for one in better)


def _is_form(chosen: Accepted, found: Sequence[Accepted], first: Sequence[CandidateResult], policy: Policy) -> bool:
    """Whether an effect is only the form of what is in: smaller by far, of its kin, or the same at another setting.

    So is what is left of one that looked like what is in.
    """
    if not found:
        return False
    if any(are_kin(one.evidence, chosen.evidence) for one in found):
        return True
    same = [one.evidence.candidate for one in found if one.name == chosen.name]
    if any(_differs_by_setting(chosen.evidence.candidate, one) for one in same):
        return True
    alone = max((one.evidence.strength for one in first if one.name == chosen.name), default=0.0)
    like = chosen.evidence.strength < policy.shrunk_form * alone
    share = policy.same_form_share if same or like else policy.form_share
    return chosen.evidence.strength < share * found[0].evidence.strength


def _beyond_form(
    ground: Baseline,
    members: dict[str, list[Candidate]],
    found: Sequence[Accepted],
    start: Baseline,
    form: Accepted,
    first: Sequence[CandidateResult],
) -> Accepted | None:
    """The next effect beside what is only the form of one that is in, if there is one that is no form itself.

    What a form leaves is coloured, and hides what is slow.
    """
    with_form = ground.beside(form.columns(ground.problem))
    tests = tests_beside(with_form, names_of(found))
    if tests.clean:
        return None
    chosen = _round(with_form, members, found, start, tests).chosen
    return None if chosen is None or _has_no_name(chosen, found, first, with_form) else chosen


def _settled_beside(
    chosen: Accepted, found: Sequence[Accepted], members: dict[str, list[Candidate]], start: Baseline
) -> list[Accepted]:
    """Effects at the settings that fit best beside another: they were found with that one in what they leave.

    What it could stand for is as strong as it was alone.
    """
    problem, out = start.problem, list(found)
    for i, one in enumerate(found):
        plain = not one.evidence.candidate.forms and not _found_beside_colour(one.evidence.candidate)
        others = start.with_all(each.columns(problem) for each in (*out[:i], *out[i + 1 :], chosen))
        again = judge(others, members[one.name]) if plain and one.name in members else None
        if again is not None:
            strength = one.evidence.strength if chosen.name in one.alternatives else again.strength
            as_found = replace(again, gain=one.evidence.gain, V=one.evidence.V, strength=strength)
            out[i] = replace(one, evidence=as_found)
    return out


def _found_beside_colour(one: Candidate) -> bool:
    """Whether it acts in a window, or swings at a period: `judge` looks for neither."""
    given, period = dict(one.nonlinear), one.effect.with_role("period")
    return bool(one.window) or period in given


def _as_form(chosen: Accepted, found: Sequence[Accepted]) -> Accepted:
    """An effect, said to be the form of one that is in for which it could stand, or that could stand for it."""
    owners = (one for one in found if chosen.name in one.alternatives or one.name in chosen.alternatives)
    return replace(chosen, form_of=next((one.form_of or one.name for one in owners), None))


def _differs_by_setting(one: Candidate, other: Candidate) -> bool:
    """Whether two candidates of one effect differ in what its class lists alone: a lag, a threshold, a cutoff."""
    here, there = dict(one.nonlinear), dict(other.nonlinear)
    return bool(one.effect.search) and all(
        here.get(key) == there.get(key) for key in here.keys() | there.keys() if key not in one.effect.search
    )


def _with_earth_vector(tests: ResidualTests, ground: Baseline) -> ResidualTests:
    """The tests, failed where a constant vector of the earth's frame is left.

    An effect that depends on the place imitates such an error of the field.
    """
    problem = ground.problem
    if not tests.clean:
        return tests
    constant = problem.whitened(problem.state.R_wb.transpose(0, 2, 1), RegionalField)
    if ground.evidence_of(constant) <= problem.policy.apart:
        return tests
    return replace(tests, why=("a constant vector in the earth's frame",))
