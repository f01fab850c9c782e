"""Candidates limited to a window: effects that explain more in a part of the run than any in the whole run."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.held_out import Evidence, judge_settings
from diagnosis.evidence.windows import Span, Timeline
from diagnosis.library.candidates import Candidate, iron_candidates
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.parameters import ACTIVE_WINDOW


def rank_windowed(
    baseline: Baseline, ranking: Sequence[Evidence], listed: dict[str, list[Candidate]]
) -> list[Evidence]:
    """Candidates with their best window, strongest first.

    Only candidates that gain far more in the window than in the whole run. Changes of iron are included: in a part of
    the run the base does not absorb them. Listed settings are compared again within the window.
    """
    problem = baseline.problem
    timeline = _timeline(problem, baseline)
    rows = timeline.rows
    settings = {name: several[0] for name, several in listed.items()} | {e.name: e.candidate for e in ranking}
    iron = {name: several[0] for name, several in iron_candidates().items()}
    spans = {
        name: (candidate, timeline.best(rows.bin(candidate.columns(problem))))
        for name, candidate in (settings | iron).items()
        if candidate.can_have_window
    }
    worth = {name: pair for name, pair in spans.items() if _is_worth(pair[1], problem.policy)}
    best = sorted(worth, key=lambda name: -worth[name][1].gain)[: problem.policy.tried_coloured]
    found = [_judged(baseline, timeline, listed.get(name, []), *worth[name]) for name in best]
    return [candidate for candidate in found if candidate is not None]


def _timeline(problem: LinearProblem, baseline: Baseline) -> Timeline:
    rows = BinnedRows.of(problem.state.time_s, problem.usable, problem.base, problem.target, problem.policy)
    return Timeline.of(rows, rows.bin_groups(baseline.accepted_columns))


def _is_worth(span: Span, policy: Policy) -> bool:
    return span.gain > policy.coloured_nats and span.whole_gain < policy.window_share * span.gain


def _judged(
    baseline: Baseline, timeline: Timeline, listed: Sequence[Candidate], candidate: Candidate, span: Span
) -> Evidence | None:
    """Evidence of a candidate in its window, with the best of its listed settings there and the window refined."""
    problem, policy = baseline.problem, baseline.problem.policy
    if candidate.effect.search and not candidate.effect.search_role():
        at_span = judge_settings(baseline, [_in(each, span, policy) for each in listed])
        candidate = candidate if at_span is None else at_span.candidate
        plain = candidate.at({ACTIVE_WINDOW.name: None})
        span = timeline.best(timeline.rows.bin(plain.columns(problem)))
    if _is_one_sided(span, problem.state.time_s, policy) and _is_a_jump(timeline, problem, candidate, span):
        return None
    return judge_settings(baseline, [_in(candidate, span, policy)])


def _is_a_jump(timeline: Timeline, problem: LinearProblem, candidate: Candidate, span: Span) -> bool:
    """Whether a constant in the window explains most of a candidate's gain: the signature of a jump."""
    iron = [several[0] for several in iron_candidates().values() if several[0].effect.traits.constant]
    constant = max(timeline.gain(timeline.rows.bin(each.columns(problem)), span) for each in iron)
    return constant > problem.policy.window_share * span.gain


def _in(candidate: Candidate, span: Span, policy: Policy) -> Candidate:
    windows = policy.window_cells * (policy.window_cells + 1) // 2
    return candidate.at({ACTIVE_WINDOW.name: (span.from_s, span.to_s)}, max(candidate.tried, 1) * windows)


def _is_one_sided(span: Span, time_s: Array, policy: Policy) -> bool:
    """Whether a window ends too near an end of the run to leave room for a further window."""
    begin_s, end_s = float(time_s[0]), float(time_s[-1])
    beside_s = min(span.from_s - begin_s, end_s - span.to_s)
    return bool(beside_s < policy.least_window * (end_s - begin_s))
