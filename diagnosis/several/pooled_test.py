"""A candidate asked of every recording at once, each beside a rest with its own colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.evidence.candidate_test import ColouredBaseline, moved_in_time
from diagnosis.evidence.held_out import search_price
from diagnosis.evidence.hypothesis import Hypothesis, information_by_part, white
from diagnosis.library.candidates import Candidate, missing_channels
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.several.coefficients import CoefficientEstimate, left_out_gains, with_scatter
from scenarios.arrays import Array
from sim.state import State


@dataclass(frozen=True, eq=False)
class CandidateInRecording:
    """A candidate in one recording: its columns (n, q, k) in rows, and the hypothesis that it is there.

    parts: products (k + 1, k + 1) of the whitened columns and the target over parts of the recording; without: by how
    many nats the rest alone explains more with a colour of its own than with this one; held: nats on held-out folds.
    """

    candidate: Candidate
    problem: LinearProblem
    beside: ColouredBaseline
    columns: Array
    hypothesis: Hypothesis
    parts: tuple[Array, ...]
    without: float
    held: float

    @classmethod
    def of(
        cls, candidate: Candidate, problem: LinearProblem, beside: ColouredBaseline, columns: Array
    ) -> CandidateInRecording:
        """The candidate with a rest of its own, the likelier of those that begin white and with the poorer's colour."""
        both = beside.joined(columns)
        richer = Hypothesis.of(beside.rows, both, (beside.poorer.rest, white(both.shape[1])))
        same = Hypothesis.given(beside.rows, beside.inside, richer.rest)
        several = beside.rows.policy.scatter_parts
        parts = information_by_part(beside.rows, beside.inside, columns, richer.rest, several)
        without = max(beside.poorer.whole - same.whole, 0.0)
        held = richer.held - max(beside.poorer.held, same.held)
        return cls(candidate, problem, beside, columns, richer, tuple(parts), without, held)

    @cached_property
    def chance(self) -> list[Array]:
        """Products (k + 1, k + 1) of the columns moved to and fro in time, as effects of none."""
        moved = moved_in_time(self.candidate, self.problem, self.beside.rows)
        return self.beside.by_chance(self.columns, self.hypothesis, moved)

    @cached_property
    def inflation(self) -> float:
        """By how much what is left in colour inflates nats: mean gain of an effect of none over half a column each."""
        gains = [one.gain(one.c) for one in map(estimate, self.chance)]
        return max(1.0, float(2 * np.mean(gains) / self.columns.shape[2]))

    @cached_property
    def estimate(self) -> CoefficientEstimate:
        """What the recording says of the coefficients, with the error that its rest states."""
        return estimate(np.sum(self.parts, axis=0))

    def nats_of(self, c: Array) -> float:
        """Nats that coefficients (k,) as they are gain beside a rest of their own, over the same rows without them."""
        given = self.estimate.gain(c) - self.without
        return max(given, self._beside_own_rest(c) - self.alone)

    @cached_property
    def alone(self) -> float:
        """Log-likelihood of the rows without the effect."""
        return self._beside_own_rest(np.zeros(self.columns.shape[2]))

    def _beside_own_rest(self, c: Array) -> float:
        """Log-likelihood of the rows less the effect at coefficients (k,), beside the likelier rest of two starts."""
        rows = self.beside.rows
        left = replace(rows, target=rows.target - np.einsum("nqk,k->nq", self.columns, c))
        return Hypothesis.of(left, self.beside.inside, (self.hypothesis.rest, self.beside.poorer.rest)).whole

    @property
    def strength(self) -> float:
        """Rms of what its own coefficients add after the base is refitted, in units of the noise."""
        rows = self.beside.rows
        added = np.einsum("nqk,k->nq", self.columns, self.estimate.c)
        by_output = zip(rows.base.transpose(1, 0, 2), added.T, strict=True)
        each = [(rows.base.reshape(added.size, -1), added.ravel())] if rows.common else by_output
        left = [y - B @ np.linalg.lstsq(B, y, rcond=None)[0] for B, y in each]
        squares = sum((float(one @ one) for one in left), 0.0)
        return float(np.sqrt(squares / (rows.count.sum() * added.shape[1])))


def estimate(products: Array, inflation: float = 1.0) -> CoefficientEstimate:
    """Information and score of products (k + 1, k + 1) of columns and target."""
    return CoefficientEstimate(products[:-1, :-1] / inflation, products[:-1, -1] / inflation)


@dataclass(frozen=True, eq=False)
class PooledCandidate:
    """A candidate at one setting in n recordings; None where a recording lacks its causes."""

    candidate: Candidate
    asked: tuple[CandidateInRecording | None, ...]
    price: float

    @classmethod
    def of(
        cls, candidate: Candidate, besides: Sequence[ColouredBaseline], problems: Sequence[LinearProblem], tried: int
    ) -> PooledCandidate:
        """The candidate, found among so many settings, beside the effects that are in already."""
        columns = [columns_in(candidate, problem) for problem in problems]
        asked = tuple(
            None if each is None else CandidateInRecording.of(candidate, problem, beside, beside.rows.taken(each))
            for problem, beside, each in zip(problems, besides, columns, strict=True)
        )
        width = next((one.columns.shape[2] for one in asked if one), 1)
        return cls(candidate, asked, search_price(tried, width, problems[0].policy))

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.candidate.name

    @property
    def off_size(self) -> float:
        """Not asked: each recording on its own has told it."""
        return 0.0

    @property
    def width(self) -> int:
        """The number of its columns."""
        return self.there[0].columns.shape[2] if self.there else 0

    @property
    def there(self) -> list[CandidateInRecording]:
        """The recordings that hold its causes."""
        return [one for one in self.asked if one is not None]

    @property
    def columns(self) -> list[Array | None]:
        """Its columns (n, q, k) in rows of each recording."""
        return [None if one is None else one.columns for one in self.asked]

    @property
    def policy(self) -> Policy:
        """What evidence goes by."""
        return self.there[0].problem.policy

    @property
    def chance(self) -> float:
        """Nats within which another is as good."""
        return self.policy.apart * self.inflation

    @property
    def gain(self) -> float:
        """Nats over all recordings before the inflation: of common coefficients, or where it is more of their own."""
        common = float(left_out_gains([one.estimate for one in self.there]).sum())
        own = sum(one.held for one in self.there)
        return max(common - sum(one.without for one in self.there), own) - self.price

    @cached_property
    def estimates(self) -> tuple[CoefficientEstimate | None, ...]:
        """What each recording says of the coefficients, with the whole width of their error."""
        parts = [[estimate(one) for one in asked.parts] for asked in self.there]
        found = iter(with_scatter(parts, [one.inflation for one in self.there]) if parts else ())
        return tuple(None if one is None else next(found) for one in self.asked)

    @property
    def known(self) -> int:
        """Degrees of freedom that the errors of the coefficients are known with."""
        return sum(len(one.parts) - 1 for one in self.there)

    def nats(self, i: int, c: Array) -> float:
        """Nats that coefficients (k,) explain in a recording, over the inflation of their error."""
        one, wide = self.asked[i], self.estimates[i]
        return 0.0 if one is None or wide is None else one.nats_of(c) / wide.inflation(c)

    def own(self, i: int) -> float:
        """Nats on held-out folds of a recording's own coefficients, over the inflation of their error."""
        one, wide = self.asked[i], self.estimates[i]
        return 0.0 if one is None or wide is None else one.held / wide.inflation(wide.c)

    @cached_property
    def inflation(self) -> float:
        """The mean inflation of the recordings."""
        return float(np.mean([one.inflation for one in self.there])) if self.there else 1.0


def beside_own(one: CandidateInRecording, own: Sequence[Array]) -> CandidateInRecording:
    """The same beside columns (N, q, k) that its recording alone has, where these take it up and explain more.

    A cause that one recording alone has is none that another of the lot could lend its name.
    """
    if not own:
        return one
    rows, policy = one.beside.rows, one.problem.policy
    beside = ColouredBaseline.in_rows(rows, one.beside.joined(rows.all_taken(own)))
    with_own, rest = beside.poorer, beside.poorer.rest
    if with_own.held - one.hypothesis.held <= policy.apart * one.inflation:
        return one
    alone = Hypothesis.given(rows, one.beside.joined(one.columns), rest).held
    alone -= Hypothesis.given(rows, one.beside.inside, rest).held
    kept = Hypothesis.given(rows, beside.joined(one.columns), rest).held - with_own.held
    useless = kept < policy.look_alike_left * max(alone, 1e-9)
    return CandidateInRecording.of(one.candidate, one.problem, beside, one.columns) if useless else one


def columns_in(candidate: Candidate, problem: LinearProblem) -> Array | None:
    """A candidate's columns (N, q, k) in a recording; None where it lacks the causes, down to the motor, or the place.

    A place that another recording gave may lie on this one's path.
    """
    if missing_channels(candidate.effect, problem) or not _holds(candidate, problem.state):
        return None
    columns = candidate.columns(problem)
    return columns if np.isfinite(columns).all() and columns.any() else None


def _holds(candidate: Candidate, state: State) -> bool:
    """Whether a recording has the motor and the channel that a setting names."""
    values, effect = dict(candidate.nonlinear), candidate.effect
    motor, channel = (values.get(effect.with_role(role) or "") for role in ("motor", "channel"))
    return (not motor or motor in state.motors) and (not channel or channel in state.channels)
