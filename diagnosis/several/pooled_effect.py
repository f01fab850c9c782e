"""An effect in several recordings at once: coefficients, nats and presence, with a noise model for each recording."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from diagnosis.evidence.candidate_test import ColouredBaseline, inflation_by_chance
from diagnosis.evidence.held_out import search_price
from diagnosis.evidence.hypothesis import (
    Hypothesis,
    explained_nats,
    information_matrices,
    products,
    remaining,
    white_noise_model,
)
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.coefficients import (
    NOT_COMPARED,
    Agreement,
    CoefficientEstimate,
    agreement,
    cross_predicted_gain,
    pool_estimates,
    predicted_by_others,
    with_scatter,
)
from scenarios.arrays import Array
from validation.signals.amplitude import rms


class Presence(StrEnum):
    """Presence of an effect in one recording."""

    PRESENT = "present"
    ABSENT = "absent"
    UNDECIDED = "cannot tell"
    NOT_RECORDED = "causes not recorded"


@dataclass(frozen=True, eq=False)
class CandidateInRecording:
    """A candidate in one recording: its columns (n, q, k) in rows, and the hypothesis of its presence.

    parts: coefficients in parts of the recording. null_gain: nats by which the recording without the candidate is
    explained better by its own noise model than by the candidate's. held_out_gain: nats on held-out folds.
    """

    candidate: Candidate
    baseline: ColouredBaseline
    columns: Array
    hypothesis: Hypothesis
    parts: list[CoefficientEstimate]
    null_gain: float
    held_out_gain: float

    @classmethod
    def of(cls, candidate: Candidate, baseline: ColouredBaseline, columns: Array) -> CandidateInRecording:
        """Fit the candidate with its own noise model."""
        hypothesis, same, gain = baseline.fit_columns(columns)
        left = remaining(baseline.rows, baseline.accepted_columns, columns, hypothesis.noise_model)
        parts = np.array_split(left, baseline.rows.policy.scatter_parts)
        estimates = [CoefficientEstimate.of(products(part)) for part in parts]
        null_gain = max(baseline.hypothesis.log_likelihood - same.log_likelihood, 0.0)
        return cls(candidate, baseline, columns, hypothesis, estimates, null_gain, gain)

    @property
    def as_left(self) -> ColouredBaseline:
        """The baseline with the noise model that the candidate leaves."""
        return replace(self.baseline, hypothesis=self.hypothesis)

    @cached_property
    def inflation(self) -> float:
        """Inflation of nats by coloured noise, from the columns shifted in time as surrogates without an effect."""
        shifted = self.baseline.surrogate_products(self.candidate, self.columns, self.hypothesis)
        return inflation_by_chance(np.array(list(map(explained_nats, shifted))), self.columns.shape[2])

    @cached_property
    def estimate(self) -> CoefficientEstimate:
        """Estimate of the coefficients, with the error stated by the noise model."""
        return pool_estimates(self.parts)

    @cached_property
    def strength(self) -> float:
        """Rms of the effect at its own coefficients after the base is refitted, in units of the noise."""
        rows, q = self.baseline.rows, self.columns.shape[1]
        (N,) = information_matrices(rows, self.columns[:, :, :0], [self.columns], white_noise_model(q))
        squares = self.estimate.c @ N[:-1, :-1] @ self.estimate.c
        return float(np.sqrt(squares / (rows.count.sum() * q)))

    def beside(self, own: Sequence[Array]) -> CandidateInRecording:
        """The candidate beside columns (N, q, k) of its recording's own effects, where these explain more.

        An own cause of one recording must not support an effect of another name in the pool.
        """
        if not own:
            return self
        before, columns = self.baseline, self.baseline.rows.bin_groups(own)
        baseline = ColouredBaseline.in_rows(before.problem, before.rows, before.columns_with(columns))
        more = baseline.hypothesis.held_out_log_likelihood - self.hypothesis.held_out_log_likelihood
        explains_more = more > before.rows.policy.apart * self.inflation
        return CandidateInRecording.of(self.candidate, baseline, self.columns) if explains_more else self


@dataclass(frozen=True, eq=False)
class PooledEffect:
    """An effect at one setting in several recordings: `here` in those that hold its causes, by index.

    price: nats of the search. transfer: None unless accepted. gains: nats explained in each recording by coefficients
    of the others, over the inflation. agreement: pooled coefficients of these recordings. alternatives: look-alikes.
    """

    candidate: Candidate
    here: dict[int, CandidateInRecording]
    price: float
    transfer: Transfer | None = None
    gains: Sequence[float] = ()
    agreement: Agreement = NOT_COMPARED
    alternatives: tuple[str, ...] = ()

    @classmethod
    def of(cls, settings: Sequence[Candidate], baselines: Sequence[ColouredBaseline]) -> PooledEffect:
        """Test a candidate next to accepted effects, at the first setting or the likeliest in the noise it leaves."""
        first = cls._at(settings[0], settings, baselines)
        if len(settings) == 1:
            return first
        left = [first.here[i].as_left if i in first.here else one for i, one in enumerate(baselines)]
        likely = cross_predicted(settings, left)
        best = max(settings, key=lambda setting: likely[setting])
        found = first if best == settings[0] else cls._at(best, settings, baselines)
        return max(first, found, key=lambda effect: effect.gain)

    @classmethod
    def _at(
        cls, candidate: Candidate, settings: Sequence[Candidate], baselines: Sequence[ColouredBaseline]
    ) -> PooledEffect:
        """Test one of several settings, at the price of a search among all."""
        here = {}
        for i, baseline in enumerate(baselines):
            if (columns := columns_in(candidate, baseline.problem)) is not None:
                here[i] = CandidateInRecording.of(candidate, baseline, baseline.rows.bin(columns))
        found, tried = cls(candidate, here, 0.0), max(setting.tried for setting in settings) * len(settings)
        return replace(found, price=search_price(tried, found.width or 1, baselines[0].rows.policy))

    @classmethod
    def beside(
        cls, candidate: Candidate, others: Collection[Candidate], problems: Sequence[LinearProblem]
    ) -> PooledEffect:
        """Test a candidate as `of` does, next to other candidates in the recordings that hold their causes."""
        several = ([columns_in(other, problem) for other in others] for problem in problems)
        accepted = ([columns for columns in each if columns is not None] for each in several)
        return cls.of([candidate], list(map(ColouredBaseline.of, problems, accepted)))

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.candidate.name

    @property
    def scale_error(self) -> float:
        """Zero: each recording has tested the scale by itself."""
        return 0.0

    @property
    def width(self) -> int:
        """Number of columns."""
        return max((one.columns.shape[2] for one in self.here.values()), default=0)

    @property
    def policy(self) -> Policy:
        """The policy of the diagnosis."""
        return next(iter(self.here.values())).baseline.rows.policy

    @property
    def V(self) -> float:
        """Mean inflation of the nats of the recordings."""
        return float(np.mean([one.inflation for one in self.here.values()]))

    @cached_property
    def gain(self) -> float:
        """Nats over all recordings, not inflated: of common coefficients or, if larger, of each recording's own."""
        tested = self.here.values()
        common = cross_predicted_gain([one.estimate for one in tested]) - sum(one.null_gain for one in tested)
        return max(common, sum(one.held_out_gain for one in tested)) - self.price

    @cached_property
    def estimates(self) -> dict[int, CoefficientEstimate]:
        """Estimates of the coefficients by recording, with errors widened by their scatter."""
        tested = self.here.values()
        found = with_scatter([one.parts for one in tested], [one.inflation for one in tested]) if tested else []
        return dict(zip(self.here, found, strict=True))

    def predicted(self, which: Iterable[int]) -> PooledEffect:
        """The effect with the gains and the agreement of some recordings, by index."""
        some, gains = {i: self.estimates[i] for i in which}, list[float]()
        for i, c in predicted_by_others(some).items():
            gains.append((self.here[i].estimate.gain(c) - self.here[i].null_gain) / some[i].inflation(c))
        known = sum(len(one.parts) - 1 for one in self.here.values())
        return replace(self, gains=gains, agreement=agreement(list(some.values()), self.policy.same_coefficient, known))

    @property
    def nats(self) -> float:
        """Nats explained in all recordings, less the price of the search."""
        return sum(self.gains) - self.price

    @property
    def agrees(self) -> bool:
        """Whether the coefficients of the recordings agree."""
        return self.agreement.p > self.policy.not_transferred_alarm

    def is_borne_out(self, needed: float) -> bool:
        """Whether common coefficients explain enough, in more than one recording, and lie within the effect's bounds.

        In a strong recording a tenth of the correct size, predicted by chance, explains a fifth. Without the strongest
        recording, one recording's part of the whole is needed.
        """
        others = sum(self.gains) - max(self.gains, default=0.0)
        enough = self.nats > needed and others * len(self.gains) > needed
        return enough and self.candidate.within_bounds(self.agreement.c)

    def own_nats(self, i: int) -> float:
        """Nats on held-out folds of a recording's own coefficients, over the inflation of their error."""
        return self.here[i].held_out_gain / self.estimates[i].inflation(self.estimates[i].c)

    @cached_property
    def presence(self) -> dict[int, Presence]:
        """Presence in the recordings that hold the causes, by own coefficients or by those of the others with it."""
        apart, found = self.policy.apart, {}
        strong = [i for i in self.here if self.own_nats(i) > apart] or list(self.here)
        for i, estimate in self.estimates.items():
            c = predicted_by_others({j: self.estimates[j] for j in {i, *strong}})[i]
            gain = estimate.gain(c) / estimate.inflation(c)
            if max(self.own_nats(i), gain) > apart:
                found[i] = Presence.PRESENT
            else:
                found[i] = Presence.ABSENT if gain < -apart else Presence.UNDECIDED
        return found

    @property
    def present(self) -> list[int]:
        """Indices of the recordings that show the effect."""
        return [i for i, presence in self.presence.items() if presence is Presence.PRESENT]

    @property
    def shown(self) -> list[int]:
        """Indices of the recordings that show the effect; of all with its causes where together they alone show it."""
        return self.present or list(self.here)

    @property
    def possible(self) -> dict[int, CoefficientEstimate]:
        """Coefficients in the recordings that hold the causes and do not exclude the effect."""
        return {i: one for i, one in self.estimates.items() if self.presence[i] is not Presence.ABSENT}

    @property
    def strength(self) -> float:
        """Rms over the recordings with the effect, in units of the noise of each."""
        return rms(np.array([self.here[i].strength for i in self.shown]))


def estimates_of(
    candidates: Iterable[Candidate], baselines: Sequence[ColouredBaseline]
) -> dict[Candidate, list[CoefficientEstimate]]:
    """Coefficients of candidates in the recordings that hold their causes, in the noise of the baselines."""
    found: dict[Candidate, list[CoefficientEstimate]] = {candidate: [] for candidate in candidates}
    for baseline in baselines:
        held = ((candidate, columns_in(candidate, baseline.problem)) for candidate in found)
        rows = {candidate: baseline.rows.bin(columns) for candidate, columns in held if columns is not None}
        several, noise_model = list(rows.values()), baseline.hypothesis.noise_model
        N = information_matrices(baseline.rows, baseline.accepted_columns, several, noise_model) if rows else []
        for candidate, products_of in zip(rows, N, strict=True):
            found[candidate].append(CoefficientEstimate.of(products_of))
    return found


def cross_predicted(candidates: Iterable[Candidate], baselines: Sequence[ColouredBaseline]) -> dict[Candidate, float]:
    """Nats explained in each recording by the other recordings' coefficients, summed, in the noise of the baselines."""
    several = estimates_of(candidates, baselines).items()
    return {candidate: cross_predicted_gain(estimates) if estimates else -np.inf for candidate, estimates in several}


def columns_in(candidate: Candidate, problem: LinearProblem) -> Array | None:
    """Columns (N, q, k) of a candidate in a recording; None where causes, motor, channel or place are missing.

    A place found in another recording may lie on the path of this recording.
    """
    values, effect, state = dict(candidate.nonlinear), candidate.effect, problem.state
    motor, channel = (values.get(effect.with_role(role) or "") for role in ("motor", "channel"))
    holds = (not motor or motor in state.motors) and (not channel or channel in state.channels)
    if problem.missing_inputs(effect) or not holds:
        return None
    columns = candidate.columns(problem)
    return columns if np.isfinite(columns).all() and columns.any() else None
