"""Candidates that act in a part of the run only: those that explain more in a window than any does always."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.held_out import Evidence, judged_at
from diagnosis.evidence.windows import Span, Timeline
from diagnosis.library.candidates import Candidate, changes_of_iron
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.parameters import ACTIVE_WINDOW


def windowed(ground: Baseline, ranking: Sequence[Evidence], members: dict[str, list[Candidate]]) -> list[Evidence]:
    """Candidates with the window in which they explain most, the strongest first.

    Only where that is much more than the same candidate explains in the whole run. Iron is a candidate too: in a part
    of the run the base does not take it up. Listed settings are compared again in the window that was found.
    """
    problem = ground.problem
    timeline = _timeline(problem, ground)
    rows = timeline.rows
    settings = {name: several[0] for name, several in members.items()} | {e.name: e.candidate for e in ranking}
    iron = {name: several[0] for name, several in changes_of_iron().items()}
    spans = {
        name: (one, timeline.best(rows.taken(one.columns(problem))))
        for name, one in (settings | iron).items()
        if one.may_be_switched
    }
    worth = {name: pair for name, pair in spans.items() if _is_worth(pair[1], problem.policy)}
    best = sorted(worth, key=lambda name: -worth[name][1].gain)[: problem.policy.tried_coloured]
    found = [_judged(ground, timeline, members.get(name, []), *worth[name]) for name in best]
    return [one for one in found if one is not None]


def comes_again(ground: Baseline, with_it: Baseline, one: Candidate) -> bool:
    """Whether beside a candidate in its window as much is left for it in another that overlaps the first.

    What has a window leaves nothing of its own there; what comes and goes in pieces leaves as much as it explains.
    with_it : the ground with it in.
    """
    if one.window is None:
        return False
    problem = ground.problem
    begin_s, end_s = one.window
    before, after = (_timeline(problem, each) for each in (ground, with_it))
    columns = before.rows.taken(one.at({ACTIVE_WINDOW.name: None}).columns(problem))
    again = after.best(columns)
    first = before.gain(columns, Span(begin_s, end_s, 0.0, 0.0))
    overlaps = again.from_s < end_s and begin_s < again.to_s
    return overlaps and again.gain > problem.policy.window_share * first


def _timeline(problem: LinearProblem, ground: Baseline) -> Timeline:
    rows = BinnedRows.of(problem.state.time_s, problem.usable, problem.base, problem.target, problem.policy)
    return Timeline.of(rows, rows.all_taken(ground.inside))


def _is_worth(span: Span, policy: Policy) -> bool:
    return span.gain > policy.coloured_nats and span.whole_gain < policy.window_share * span.gain


def _judged(
    ground: Baseline, timeline: Timeline, several: Sequence[Candidate], one: Candidate, span: Span
) -> Evidence | None:
    """The evidence of a candidate in its window: the best of its listed settings there, then the window once more."""
    problem, policy = ground.problem, ground.problem.policy
    if one.effect.search and not one.effect.search_role():
        at_span = judged_at(ground, [_in(each, span, policy) for each in several])
        one = one if at_span is None else at_span.candidate
        plain = one.at({ACTIVE_WINDOW.name: None})
        span = timeline.best(timeline.rows.taken(plain.columns(problem)))
    if _is_one_sided(span, problem.state.time_s, policy) and _is_a_jump(timeline, problem, one, span):
        return None
    return judged_at(ground, [_in(one, span, policy)])


def _is_a_jump(timeline: Timeline, problem: LinearProblem, one: Candidate, span: Span) -> bool:
    """Whether a constant from a moment on, or up to it, explains most of what a candidate does: that is a jump."""
    iron = [several[0] for several in changes_of_iron().values() if several[0].effect.traits.constant]
    constant = max(timeline.gain(timeline.rows.taken(each.columns(problem)), span) for each in iron)
    return constant > problem.policy.window_share * span.gain


def _in(one: Candidate, span: Span, policy: Policy) -> Candidate:
    windows = policy.window_cells * (policy.window_cells + 1) // 2
    return one.at({ACTIVE_WINDOW.name: (span.from_s, span.to_s)}, max(one.tried, 1) * windows)


def _is_one_sided(span: Span, time_s: Array, policy: Policy) -> bool:
    """Whether a window ends so near an end of the run that no other window has room between."""
    begin_s, end_s = float(time_s[0]), float(time_s[-1])
    beside_s = min(span.from_s - begin_s, end_s - span.to_s)
    return bool(beside_s < policy.least_window * (end_s - begin_s))
