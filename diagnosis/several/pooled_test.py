"""The test of a candidate in several recordings at once, with a noise model for each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.evidence.candidate_test import ColouredBaseline, surrogate_columns
from diagnosis.evidence.held_out import search_price
from diagnosis.evidence.hypothesis import Hypothesis, information_matrices, remaining, white_noise_model
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.evidence.projections import products
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.several.coefficients import CoefficientEstimate, cross_predicted_gain, with_scatter
from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class CandidateInRecording:
    """A candidate in one recording: its columns (n, q, k) in rows, and the hypothesis of its presence.

    parts: products (k + 1, k + 1) of whitened columns and target over parts of the recording. null_gain: nats by which
    the recording without the candidate is explained better by its own noise model than by the candidate's.
    held_out_gain: nats on held-out folds.
    """

    candidate: Candidate
    problem: LinearProblem
    baseline: ColouredBaseline
    columns: Array
    hypothesis: Hypothesis
    parts: tuple[Array, ...]
    null_gain: float
    held_out_gain: float

    @classmethod
    def of(
        cls, candidate: Candidate, problem: LinearProblem, baseline: ColouredBaseline, columns: Array
    ) -> CandidateInRecording:
        """Fit the candidate with its own noise model, the likelier of two starts: white, and the baseline's."""
        rows, accepted, null = baseline.rows, baseline.accepted_columns, baseline.hypothesis
        starts = (null.noise_model, white_noise_model(columns.shape[1]))
        hypothesis = Hypothesis.of(rows, baseline.columns_with(columns), starts)
        same = Hypothesis.with_noise_model(rows, accepted, hypothesis.noise_model)
        left = remaining(rows, accepted, columns, hypothesis.noise_model)
        parts = tuple(products(part) for part in np.array_split(left, rows.policy.scatter_parts))
        null_gain = max(null.log_likelihood - same.log_likelihood, 0.0)
        held_out = max(null.held_out_log_likelihood, same.held_out_log_likelihood)
        gain = hypothesis.held_out_log_likelihood - held_out
        return cls(candidate, problem, baseline, columns, hypothesis, parts, null_gain, gain)

    @cached_property
    def surrogates(self) -> list[Array]:
        """Products (k + 1, k + 1) of the columns shifted in time, as surrogates without an effect."""
        moved = surrogate_columns(self.candidate, self.problem, self.baseline.rows)
        return self.baseline.surrogate_products(self.columns, self.hypothesis, moved)

    @cached_property
    def inflation(self) -> float:
        """Inflation of nats by coloured noise: mean gain of the surrogates over half a column each."""
        gains = [surrogate.gain(surrogate.c) for surrogate in map(CoefficientEstimate.of, self.surrogates)]
        return max(1.0, float(2 * np.mean(gains) / self.columns.shape[2]))

    @cached_property
    def estimate(self) -> CoefficientEstimate:
        """Estimate of the coefficients, with the error stated by the noise model."""
        return CoefficientEstimate.of(np.sum(self.parts, axis=0))

    def nats_at(self, c: Array) -> float:
        """Nats of given coefficients (k,) with a noise model of their own, over the same rows without the effect."""
        given = self.estimate.gain(c) - self.null_gain
        return max(given, self._log_likelihood_at(c) - self.null_log_likelihood)

    @cached_property
    def null_log_likelihood(self) -> float:
        """Log-likelihood of the rows without the effect."""
        return self._log_likelihood_at(np.zeros(self.columns.shape[2]))

    def _log_likelihood_at(self, c: Array) -> float:
        """Log-likelihood of the rows less the effect at coefficients (k,), with its likelier noise model."""
        rows, starts = self.baseline.rows, (self.hypothesis.noise_model, self.baseline.hypothesis.noise_model)
        without = replace(rows, target=rows.target - self.columns @ c)
        return Hypothesis.of(without, self.baseline.accepted_columns, starts).log_likelihood

    @property
    def strength(self) -> float:
        """Rms of the effect at its own coefficients after the base is refitted, in units of the noise."""
        rows, q = self.baseline.rows, self.columns.shape[1]
        (N,) = information_matrices(rows, self.columns[:, :, :0], [self.columns], white_noise_model(q))
        squares = self.estimate.c @ N[:-1, :-1] @ self.estimate.c
        return float(np.sqrt(squares / (rows.count.sum() * q)))

    def beside(self, own: Sequence[Array]) -> CandidateInRecording:
        """The candidate beside columns (N, q, k) of its recording's own effects, where these explain it and more.

        An own cause of one recording must not support an effect of another name in the pool.
        """
        if not own:
            return self
        before, policy = self.baseline, self.problem.policy
        columns = before.rows.bin_groups(own)
        baseline = ColouredBaseline.in_rows(before.rows, before.columns_with(columns))
        held_out = baseline.hypothesis.held_out_log_likelihood - self.hypothesis.held_out_log_likelihood
        if held_out <= policy.apart * self.inflation:
            return self
        kept, alone = before.gains_beside(self.columns, columns, baseline.hypothesis.noise_model)
        if kept >= policy.half * max(alone, 1e-9):
            return self
        return CandidateInRecording.of(self.candidate, self.problem, baseline, self.columns)


@dataclass(frozen=True, eq=False)
class PooledCandidate:
    """A candidate at one setting in n recordings; None where a recording lacks its causes."""

    candidate: Candidate
    in_recordings: tuple[CandidateInRecording | None, ...]
    price: float

    @classmethod
    def of(
        cls, settings: Sequence[Candidate], baselines: Sequence[ColouredBaseline], problems: Sequence[LinearProblem]
    ) -> PooledCandidate:
        """Test a candidate next to accepted effects, at the first setting or the likeliest in what it leaves."""
        tried = max(setting.tried for setting in settings) * len(settings)
        first = cls._at(settings[0], baselines, problems, tried)
        if len(settings) == 1:
            return first
        found = [(baseline, first.here.get(i)) for i, baseline in enumerate(baselines)]
        left = [one if here is None else replace(one, hypothesis=here.hypothesis) for one, here in found]
        likely = cross_predicted(settings, left, problems)
        best = max(settings, key=lambda setting: likely[setting])
        if best == settings[0]:
            return first
        return max(first, cls._at(best, baselines, problems, tried), key=lambda pooled: pooled.gain)

    @classmethod
    def _at(
        cls, candidate: Candidate, baselines: Sequence[ColouredBaseline], problems: Sequence[LinearProblem], tried: int
    ) -> PooledCandidate:
        """Test the candidate, found among `tried` settings."""
        in_recordings = tuple(
            None
            if (columns := columns_in(candidate, problem)) is None
            else CandidateInRecording.of(candidate, problem, baseline, baseline.rows.bin(columns))
            for problem, baseline in zip(problems, baselines, strict=True)
        )
        pooled = cls(candidate, in_recordings, 0.0)
        return replace(pooled, price=search_price(tried, max(pooled.width, 1), problems[0].policy))

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
        return max((in_recording.columns.shape[2] for in_recording in self.here.values()), default=0)

    @cached_property
    def here(self) -> dict[int, CandidateInRecording]:
        """The candidate in the recordings that hold its causes, by their index."""
        return {i: in_recording for i, in_recording in enumerate(self.in_recordings) if in_recording is not None}

    @property
    def columns(self) -> dict[int, Array]:
        """Columns (n, q, k) in rows of the recordings that hold the causes."""
        return {i: in_recording.columns for i, in_recording in self.here.items()}

    @property
    def policy(self) -> Policy:
        """The policy of the diagnosis."""
        return next(iter(self.here.values())).problem.policy

    @property
    def indistinct_nats(self) -> float:
        """Difference of nats within which another candidate is as good: of the mean inflation of the recordings."""
        return self.policy.apart * float(np.mean([in_recording.inflation for in_recording in self.here.values()]))

    @property
    def gain(self) -> float:
        """Nats over all recordings, not inflated: of common coefficients or, if larger, of each recording's own."""
        common = cross_predicted_gain([in_recording.estimate for in_recording in self.here.values()])
        own = sum(in_recording.held_out_gain for in_recording in self.here.values())
        return max(common - sum(in_recording.null_gain for in_recording in self.here.values()), own) - self.price

    @cached_property
    def estimates(self) -> dict[int, CoefficientEstimate]:
        """Estimates of the coefficients by recording, with errors widened by their scatter."""
        tested = self.here.values()
        parts = [list(map(CoefficientEstimate.of, in_recording.parts)) for in_recording in tested]
        found = with_scatter(parts, [in_recording.inflation for in_recording in tested]) if parts else []
        return dict(zip(self.here, found, strict=True))

    @property
    def error_degrees(self) -> int:
        """Degrees of freedom of the coefficients' error estimates."""
        return sum(len(in_recording.parts) - 1 for in_recording in self.here.values())

    def nats(self, i: int, c: Array) -> float:
        """Nats explained in a recording by coefficients (k,), over the inflation of their error."""
        return self.here[i].nats_at(c) / self.estimates[i].inflation(c) if i in self.here else 0.0

    def own_nats(self, i: int) -> float:
        """Nats on held-out folds of a recording's own coefficients, over the inflation of their error."""
        if i not in self.here:
            return 0.0
        return self.here[i].held_out_gain / self.estimates[i].inflation(self.estimates[i].c)

    def surrogate_gain(self) -> float:
        """Largest nats of common coefficients among surrogates, shifted alike in every recording."""
        tested = self.here.values()
        return max(
            cross_predicted_gain(
                [CoefficientEstimate.of(N, one.inflation) for N, one in zip(turn, tested, strict=True)]
            )
            for turn in zip(*(in_recording.surrogates for in_recording in tested), strict=True)
        )

    def explains(self, rival: Mapping[int, Array]) -> bool:
        """Whether a rival's columns (n, q, k) by recording keep little of their gain once this candidate is fitted."""
        kept = alone = 0.0
        for i in rival.keys() & self.here.keys():
            best = self.here[i]
            beside, by_itself = best.baseline.gains_beside(rival[i], best.columns, best.hypothesis.noise_model)
            kept, alone = kept + beside, alone + by_itself
        return not self.here or bool(kept / max(alone, 1e-9) < self.policy.half)


def estimates_beside(
    candidates: Iterable[Candidate], problem: LinearProblem, baseline: ColouredBaseline, noise_model: NoiseModel
) -> dict[Candidate, CoefficientEstimate]:
    """Coefficients of candidates in one recording under a given noise model; none for those whose causes it lacks."""
    rows = {
        candidate: baseline.rows.bin(columns)
        for candidate in candidates
        if (columns := columns_in(candidate, problem)) is not None
    }
    if not rows:
        return {}
    N = information_matrices(baseline.rows, baseline.accepted_columns, list(rows.values()), noise_model)
    return dict(zip(rows, map(CoefficientEstimate.of, N), strict=True))


def cross_predicted(
    candidates: Sequence[Candidate], baselines: Sequence[ColouredBaseline], problems: Sequence[LinearProblem]
) -> dict[Candidate, float]:
    """Nats explained in each recording by the other recordings' coefficients, summed, in the baselines' noise."""
    found = [
        estimates_beside(candidates, problem, baseline, baseline.hypothesis.noise_model)
        for problem, baseline in zip(problems, baselines, strict=True)
    ]
    several = {candidate: [one[candidate] for one in found if candidate in one] for candidate in candidates}
    return {one: cross_predicted_gain(estimates) if estimates else -np.inf for one, estimates in several.items()}


def baselines_with(candidates: Sequence[Candidate], problems: Sequence[LinearProblem]) -> list[ColouredBaseline]:
    """The baseline of each recording with the candidates whose causes it holds accepted."""
    several = [[columns_in(candidate, problem) for candidate in candidates] for problem in problems]
    return [
        ColouredBaseline.of(problem, [columns for columns in found if columns is not None])
        for problem, found in zip(problems, several, strict=True)
    ]


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
