"""Which candidate stands: it beats the same base beside a rest of its own colour, by more than its surrogates do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.held_out import Evidence, search_price
from diagnosis.evidence.hypothesis import Hypothesis, gains, informations, white
from diagnosis.library.candidates import Candidate
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import strength_columns
from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class CandidateFit:
    """A candidate beside a rest of its own: its columns (n, q, k) in rows, and nats that it gains on their folds.

    within : those of them that it gains between the samples of a row.
    """

    evidence: Evidence
    columns: Array
    rows: BinnedRows
    hypothesis: Hypothesis
    gain: float
    within: float = 0.0


@dataclass(frozen=True, eq=False)
class ColouredBaseline:
    """The rows of a ground with the effects already in, and the hypothesis that they are all."""

    rows: BinnedRows
    inside: Array
    poorer: Hypothesis

    @classmethod
    def of(cls, problem: LinearProblem, inside: Sequence[Array]) -> ColouredBaseline:
        """The rows of a problem, with the columns (N, q, k) of effects in."""
        state, sigma = problem.state, problem.sigma_nT
        sight = None if problem.sight is None else problem.sight * (sigma[0] / sigma)[:, None]
        rows = BinnedRows.of(state.time_s, problem.usable, problem.base, problem.target, problem.policy, sight)
        return cls.in_rows(rows, rows.all_taken(inside))

    @classmethod
    def in_rows(cls, rows: BinnedRows, inside: Array) -> ColouredBaseline:
        """The same with rows that are there, inside (n, q, k).

        The rest is found again from itself: least squares give the base a part of a walk, and what they leave of it is
        another rest, beside which a drift would stand.
        """
        first = Hypothesis.of(rows, inside, (white(rows.target.shape[1]),))
        again = Hypothesis.of(rows, inside, (first.rest,))
        return cls(rows, inside, max(first, again, key=lambda one: one.whole))

    def joined(self, columns: Array) -> Array:
        """Columns (n, q, k) after those of the effects already in."""
        return np.concatenate([self.inside, columns], axis=2)

    def roughly(self, several: Sequence[Array]) -> Array:
        """Nats (m,) that groups of columns gain beside the rest as it is without them: no more than a first look."""
        width = np.array([columns.shape[2] for columns in several])
        return np.asarray(gains(self.rows, self.inside, several, self.poorer.rest) - width)

    def standing(self, evidence: Evidence, columns: Array, within: float = 0.0) -> CandidateFit:
        """A candidate's evidence beside a rest of its own, less the price of its search; `within`: nats within rows.

        Without it the rest is the likelier of the poorer hypothesis' and the candidate's own.
        """
        both, rows = self.joined(columns), self.rows.showing(columns)
        richer = Hypothesis.of(rows, both, (self.poorer.rest, white(both.shape[1])))
        price = search_price(evidence.candidate.tried, evidence.width, rows.policy)
        poorer = self.poorer if rows is self.rows else Hypothesis.given(rows, self.inside, self.poorer.rest)
        same = Hypothesis.given(rows, self.inside, richer.rest)
        gain = richer.held - max(poorer.held, same.held) + within - price
        return CandidateFit(evidence, columns, rows, richer, gain, within)

    def surrogates(self, one: CandidateFit, problem: LinearProblem) -> Array:
        """Nats that a candidate's columns, moved in time, gain in sample from what it leaves."""
        moved = moved_in_time(one.evidence.candidate, problem, self.rows)
        return gains(*self._without_effect(one.columns, one.hypothesis), moved, one.hypothesis.rest)

    def by_chance(self, columns: Array, hypothesis: Hypothesis, moved: Sequence[Array]) -> list[Array]:
        """Products (k + 1, k + 1) of columns moved in time and of what the candidate leaves."""
        return informations(*self._without_effect(columns, hypothesis), moved, hypothesis.rest)

    def _without_effect(self, columns: Array, hypothesis: Hypothesis) -> tuple[BinnedRows, Array]:
        """Rows whose target is what a hypothesis with an effect leaves, and nothing inside."""
        left = replace(self.rows, target=hypothesis.residual(self.rows, self.joined(columns)))
        return left, columns[:, :, :0]

    def left_of(self, rival: CandidateFit, best: CandidateFit) -> float:
        """Part of its own gain that a rival keeps once the best is in, with the best's rest."""
        both = self.joined(best.columns)
        rows, rest = best.rows, best.hypothesis.rest
        alone = Hypothesis.given(rows, self.joined(rival.columns), rest)
        joint = Hypothesis.given(rows, np.concatenate([both, rival.columns], axis=2), rest)
        without = Hypothesis.given(rows, self.inside, rest)
        return (joint.held - best.hypothesis.held) / max(alone.held - without.held, 1e-9)


def moved_in_time(candidate: Candidate, problem: LinearProblem, rows: BinnedRows) -> list[Array]:
    """Columns (n, q, k) of an effect that is none: what it adds, to and fro in time, begun at several shifts.

    So what only rises does not jump but comes back. Where only the strength is known they are moved in the frame of the
    sensor, and seen along the motion as it was: a wander of one axis comes and goes with the direction of the field,
    and so must they.
    """
    if problem.mode == "vector":
        return list(_to_and_fro(rows.taken(candidate.columns(problem)), problem.policy.surrogates))
    moved = _to_and_fro(candidate.contribution_nT(problem), problem.policy.surrogates)
    return [rows.taken(problem.whitened(one, candidate.effect)) for one in moved]


def _to_and_fro(columns: Array, times: int) -> Iterator[Array]:
    n, both = len(columns), np.concatenate([columns[::-1], columns, columns[::-1]])
    for t in range(times):
        begin = int((2 * t + 1) / times * n)
        yield both[begin : begin + n]


def gains_along_the_field(before: Baseline, after: Baseline, tried: int = 1) -> bool:
    """Whether what was taken in explains the part along the field too, where an error of the attitude has nothing.

    Nats less what the k columns taken in gain by chance, ``k / 2``, and the price of a search among `tried` settings.
    What is slow gains by chance as the slow noise has it: by the loudest of means as long as k columns can follow.
    """
    policy, k = before.problem.policy, after.sums.width - before.sums.width
    by_chance = k / 2 + search_price(tried, k, policy)
    return bool(gained_along_the_field(before, after, k) - by_chance > policy.apart)


def gained_along_the_field(before: Baseline, after: Baseline, least: int | None = None) -> float:
    """Nats of means over `slow_mean_s` of the part along the field, ``(b - a) / 2``, over what is still coloured.

    least : the longest means of which so many are left count as well; None: none longer.
    """
    poorer, richer = (along_the_field(ground) for ground in (before, after))
    loudest = max(_variances_of_means(richer, least or len(richer)))
    return float((poorer**2).sum() - (richer**2).sum()) / 2 / max(1.0, loudest)


def share_along_the_field(before: Baseline, after: Baseline) -> float:
    """Share of what means along the field have beyond white noise that is gone; 0 where they have none."""
    poorer, richer = (along_the_field(ground) for ground in (before, after))
    excess = float((poorer**2).sum()) - len(poorer)
    return 1 - (float((richer**2).sum()) - len(richer)) / excess if excess > 0 else 0.0


def _variances_of_means(course: Array, least: int) -> Iterator[float]:
    """Variance of means over 1, 2, 4, ... values of a course, each times their number: white noise's stays the same."""
    length = 1
    while len(course) >= least * length:
        sums = course[: len(course) // length * length].reshape(-1, length).sum(axis=1)
        yield float((sums**2).mean()) / length
        length *= 2


def along_the_field(ground: Baseline) -> Array:
    """Means (m,) of what a ground leaves along the field, over `slow_mean_s`; white noise has a variance of one.

    The nine columns of a strength fit are taken off: a matrix that was fitted to a turn of the field leaves them there.
    """
    problem = ground.problem
    along, unit = _along(ground)
    length = max(1, min(round(problem.policy.slow_mean_s / problem.state.interval_s), len(along) // 2))
    cut = Cut(length, len(along) // length)
    base, means = cut.means(strength_columns(problem.direction) * (problem.usable / unit)[:, None]), cut.means(along)
    return np.asarray(np.sqrt(length) * (means - base @ np.linalg.lstsq(base, means, rcond=1e-9)[0]))


def _along(ground: Baseline) -> tuple[Array, Array]:
    """What a ground leaves (n,) along the field over its noise, and that noise (n,) in nT."""
    problem, left = ground.problem, ground.residual()
    if problem.sight is not None:
        return left[:, 0], np.full(len(left), problem.sigma_nT[0])
    back = problem.sees_along * problem.sigma_nT
    unit = np.linalg.norm(back, axis=1)
    return np.einsum("ni,ni->n", back, left) / unit, unit


def look_alikes(
    best: CandidateFit, others: Sequence[CandidateFit], beside: ColouredBaseline, chance: float, share: float
) -> list[CandidateFit]:
    """Those that are within a number of nats or a share of the best, and of no use once it is in."""
    within = max(chance, share * best.gain)
    near = [one for one in others if best.gain - one.gain < within]
    return [one for one in near if beside.left_of(one, best) < beside.rows.policy.look_alike_left]
