"""Greedy selection of effects: accept the best candidate and refit, until the residual is clean or nothing gains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from diagnosis.decision.choice import (
    AcceptedEffect,
    Selection,
    accept_best,
    baseline_with,
    in_same_family,
    is_form_by_size,
    residual_tests,
)
from diagnosis.decision.coloured_choice import CandidateTest, choose_coloured
from diagnosis.decision.forms import complete_forms, first_form_evidence, split_by_motor
from diagnosis.evidence.along_field import within_stated_errors
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.field_pulsations import find_pulsations
from diagnosis.evidence.held_out import CandidateResult, judge_candidate, rank_candidates, with_outcomes, withdraw_names
from diagnosis.evidence.windowed_candidates import rank_windowed
from diagnosis.library.candidates import Candidate, propose_candidates
from diagnosis.problem.linear import LinearProblem
from sim.effects import EFFECTS
from sim.state import MOTION

Progress = Callable[[str], object]
SUPERSEDED = "nothing of it is left beside the effects found later"


def select(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Select effects in turn, each accepted on held-out evidence.

    without : names left out of the library (the bench's leave-one-out).
    """
    start = Baseline.of(problem)
    before = residual_tests(start, ())
    selection = Selection((), start, start, before, before, (), without)
    # slow errors stated by the model resemble effects
    if before.clean and within_stated_errors(problem, start.residual()):
        return selection
    candidates = propose_candidates(problem, without)
    for number in range(problem.policy.most_effects):
        if selection.accepted and selection.after.clean:
            break
        say(f"candidates, round {number + 1}")
        chosen, results = _choose(selection, candidates)
        selection = replace(selection, results=selection.results or results)
        if chosen is None:
            break
        if _is_form_of_accepted(chosen, selection) or _grows_with_time(chosen, selection):
            return replace(selection, accepted=tuple(_with_look_alike(selection.accepted, chosen)))
        accepted = _refit_settings(chosen, selection.accepted, candidates, start)
        accepted.append(_with_form_owner(chosen, accepted))
        selection = replace(selection, accepted=tuple(accepted), end=start)  # frees the columns of the last baseline
        selection = _without_superseded(complete_forms(split_by_motor(selection)))
    return selection


def _without_superseded(selection: Selection) -> Selection:
    """Drop effects that gain nothing beside those accepted later, where these leave a clean residual without them.

    A tone, as the only line of two motor currents, gains more than either; beside both nothing is left of it.
    """
    start, kept = selection.start, selection
    for effect in selection.accepted[:-1]:
        others = [one for one in kept.accepted if one is not effect]
        owned = (replace(one, form_of=None) if one.form_of == effect.name else one for one in others)
        beside = replace(kept, accepted=tuple(owned)).beside(baseline_with(others, start))
        if beside.after.clean and beside.end.evidence_of(effect.columns(start.problem)) < start.problem.policy.apart:
            first = effect is selection.accepted[0]
            kept = replace(beside, results=withdraw_names(kept.results, (SUPERSEDED,))) if first else beside
    return kept


def choose_windows_again(selection: Selection) -> Selection:
    """Choose each effect with a window again next to all others, which were in the residual at its own choice."""
    start, out = selection.start, list(selection.accepted)
    switched = [i for i, effect in enumerate(out) if effect.evidence.candidate.window is not None]
    if len(out) < 2 or not switched:
        return selection
    candidates = propose_candidates(start.problem, selection.without)
    for i in switched:
        others = replace(selection, accepted=(*out[:i], *out[i + 1 :]))
        beside = others.beside(baseline_with(others.accepted, start))
        out[i] = _choose(beside, candidates, alone=True)[0] or out[i]
    return _without_superseded(complete_forms(split_by_motor(replace(selection, accepted=tuple(out)))))


def _choose(
    selection: Selection, candidates: dict[str, list[Candidate]], *, alone: bool = False
) -> tuple[AcceptedEffect | None, tuple[CandidateResult, ...]]:
    """Choose the next effect, if any, in white noise or in coloured; with every candidate's result, strongest first.

    alone : do not look for a second effect that would justify a refused candidate.
    """
    baseline, policy = selection.end, selection.end.problem.policy
    ranking = rank_candidates(baseline, candidates)

    def find_next(with_effect: Baseline, name: str) -> AcceptedEffect | None:
        beside = selection.beside(with_effect, name)
        return None if beside.after.clean else _choose(beside, candidates, alone=True)[0]

    if selection.after.clean:
        chosen = accept_best(ranking, policy)
        results = [CandidateResult(one, one.nats, policy.accepted(len(EFFECTS)), "") for one in ranking]
    else:
        switched = rank_windowed(baseline, ranking, candidates)
        full = (*first_form_evidence(baseline, candidates, selection.is_clean), *find_pulsations(baseline, candidates))
        test = CandidateTest(selection, None if alone else find_next)
        chosen, results = choose_coloured(test, [*ranking, *full], switched)
    return chosen, with_outcomes(results, *((chosen.name, chosen.alternatives) if chosen else (None, ())))


def _with_look_alike(accepted: Sequence[AcceptedEffect], refused: AcceptedEffect) -> list[AcceptedEffect]:
    """Add a refused candidate to the look-alikes of accepted effects of its family, whose form error it fits."""
    names = (refused.name, *refused.alternatives)
    return [
        effect.listing(*names) if in_same_family(effect.evidence, refused.evidence) else effect for effect in accepted
    ]


def _grows_with_time(chosen: AcceptedEffect, selection: Selection) -> bool:
    """Whether an accepted effect driven by a channel gains more by growing or fading than the candidate gains.

    The growth is the effect's columns times time; the candidate must be useless once the growth is fitted. Evidence is
    taken on all data: held-out data do not determine an effect acting only at the start.
    """
    baseline, problem, policy = selection.end, selection.end.problem, selection.end.problem.policy
    columns = chosen.columns(problem)
    own = baseline.evidence_on_all(columns)
    clock = problem.state.time_s - problem.state.time_s.mean()
    driven = (one for one in selection.accepted if not MOTION.issuperset(one.evidence.candidate.effect.needs))
    grown = (effect.columns(problem) * clock[:, None, None] for effect in driven)
    better = (effect for effect in grown if baseline.evidence_on_all(effect) > max(own, 0.0) + policy.apart)
    return any(baseline.with_columns(effect).evidence_on_all(columns) < policy.half * own for effect in better)


def _is_form_of_accepted(chosen: AcceptedEffect, selection: Selection) -> bool:
    """Whether a candidate is a form error of accepted effects: far smaller, of one family, or at another setting."""
    accepted, candidate = selection.accepted, chosen.evidence.candidate
    same = [effect.evidence.candidate for effect in accepted if effect.name == chosen.name]
    alone = max((one.evidence.strength for one in selection.results if one.name == chosen.name), default=0.0)
    sizes = (chosen.evidence.strength, alone, accepted[0].evidence.strength if accepted else 0.0)
    return (
        any(in_same_family(effect.evidence, chosen.evidence) for effect in accepted)
        or any(_differs_by_setting(candidate, other) for other in same)
        or is_form_by_size(*sizes, selection.end.problem.policy, same=bool(same))
    )


def _refit_settings(
    chosen: AcceptedEffect, accepted: Sequence[AcceptedEffect], candidates: dict[str, list[Candidate]], start: Baseline
) -> list[AcceptedEffect]:
    """Choose the settings of accepted effects again next to the new one, which was in the residual at their own choice.

    A look-alike of the new effect keeps its strength. Neither forms nor windows and periods are searched again.
    """
    out = list(accepted)
    for i, effect in enumerate(accepted):
        candidate, period = effect.evidence.candidate, effect.evidence.candidate.effect.with_role("period")
        plain = not (candidate.forms or candidate.window or period in dict(candidate.nonlinear))
        others = baseline_with((*out[:i], *out[i + 1 :], chosen), start)
        again = judge_candidate(others, candidates[effect.name]) if plain and effect.name in candidates else None
        if again is not None:
            strength = effect.evidence.strength if chosen.name in effect.alternatives else again.strength
            out[i] = effect.refitted(replace(again, strength=strength))
    return out


def _with_form_owner(chosen: AcceptedEffect, accepted: Sequence[AcceptedEffect]) -> AcceptedEffect:
    """Mark an effect as the form of an accepted look-alike, if any."""
    owners = (effect for effect in accepted if chosen.name in effect.alternatives or effect.name in chosen.alternatives)
    return replace(chosen, form_of=next((effect.form_of or effect.name for effect in owners), None))


def _differs_by_setting(first: Candidate, second: Candidate) -> bool:
    """Whether two candidates of one effect differ only in listed settings: a lag, a threshold, a cutoff."""
    here, there = dict(first.nonlinear), dict(second.nonlinear)
    return bool(first.effect.search) and all(
        here.get(key) == there.get(key) for key in here.keys() | there.keys() if key not in first.effect.search
    )
