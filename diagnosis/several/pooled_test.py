"""The test of a candidate in several recordings at once, with a noise model for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.evidence.candidate_test import ColouredBaseline, surrogate_columns
from diagnosis.evidence.held_out import search_price
from diagnosis.evidence.hypothesis import Hypothesis, remaining, white_noise_model
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.evidence.projections import products
from diagnosis.library.candidates import Candidate, missing_channels
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.several.coefficients import CoefficientEstimate, cross_predicted_gains, with_scatter
from scenarios.arrays import Array
from sim.state import State


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
        columns_with_candidate = baseline.columns_with(columns)
        hypothesis = Hypothesis.of(
            baseline.rows,
            columns_with_candidate,
            (baseline.hypothesis.noise_model, white_noise_model(columns_with_candidate.shape[1])),
        )
        null_hypothesis = Hypothesis.with_noise_model(baseline.rows, baseline.accepted_columns, hypothesis.noise_model)
        part_count = baseline.rows.policy.scatter_parts
        left = remaining(baseline.rows, baseline.accepted_columns, columns, hypothesis.noise_model)
        parts = [products(part) for part in np.array_split(left, part_count)]
        null_gain = max(baseline.hypothesis.log_likelihood - null_hypothesis.log_likelihood, 0.0)
        held_out_gain = hypothesis.held_out_log_likelihood - max(
            baseline.hypothesis.held_out_log_likelihood, null_hypothesis.held_out_log_likelihood
        )
        return cls(candidate, problem, baseline, columns, hypothesis, tuple(parts), null_gain, held_out_gain)

    @cached_property
    def surrogates(self) -> list[Array]:
        """Products (k + 1, k + 1) of the columns shifted in time, as surrogates without an effect."""
        moved = surrogate_columns(self.candidate, self.problem, self.baseline.rows)
        return self.baseline.surrogate_products(self.columns, self.hypothesis, moved)

    @cached_property
    def inflation(self) -> float:
        """Inflation of nats by coloured noise: mean gain of the surrogates over half a column each."""
        gains = [surrogate.gain(surrogate.c) for surrogate in map(estimate, self.surrogates)]
        return max(1.0, float(2 * np.mean(gains) / self.columns.shape[2]))

    @cached_property
    def estimate(self) -> CoefficientEstimate:
        """Estimate of the coefficients, with the error stated by the noise model."""
        return estimate(np.sum(self.parts, axis=0))

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
        rows = self.baseline.rows
        remaining = replace(rows, target=rows.target - np.einsum("nqk,k->nq", self.columns, c))
        return Hypothesis.of(
            remaining,
            self.baseline.accepted_columns,
            (self.hypothesis.noise_model, self.baseline.hypothesis.noise_model),
        ).log_likelihood

    @property
    def strength(self) -> float:
        """Rms of the effect at its own coefficients after the base is refitted, in units of the noise."""
        rows = self.baseline.rows
        added = np.einsum("nqk,k->nq", self.columns, self.estimate.c)
        by_output = zip(rows.base.transpose(1, 0, 2), added.T, strict=True)
        outputs = [(rows.base.reshape(added.size, -1), added.ravel())] if rows.common else by_output
        residuals = [y - B @ np.linalg.lstsq(B, y, rcond=None)[0] for B, y in outputs]
        squares = sum(float(output @ output) for output in residuals)
        return float(np.sqrt(squares / (rows.count.sum() * added.shape[1])))


def estimate(products: Array, inflation: float = 1.0) -> CoefficientEstimate:
    """Information and score from products (k + 1, k + 1) of columns and target."""
    return CoefficientEstimate(products[:-1, :-1] / inflation, products[:-1, -1] / inflation)


@dataclass(frozen=True, eq=False)
class PooledCandidate:
    """A candidate at one setting in n recordings; None where a recording lacks its causes."""

    candidate: Candidate
    in_recordings: tuple[CandidateInRecording | None, ...]
    price: float

    @classmethod
    def of(
        cls,
        candidate: Candidate,
        baselines: Sequence[ColouredBaseline],
        problems: Sequence[LinearProblem],
        tried: int,
    ) -> PooledCandidate:
        """Test the candidate, found among `tried` settings, next to accepted effects."""
        columns = [columns_in(candidate, problem) for problem in problems]
        in_recordings = tuple(
            None
            if columns_here is None
            else CandidateInRecording.of(candidate, problem, baseline, baseline.rows.bin(columns_here))
            for problem, baseline, columns_here in zip(problems, baselines, columns, strict=True)
        )
        width = next((in_recording.columns.shape[2] for in_recording in in_recordings if in_recording), 1)
        return cls(candidate, in_recordings, search_price(tried, width, problems[0].policy))

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
        return self.tested[0].columns.shape[2] if self.tested else 0

    @property
    def tested(self) -> list[CandidateInRecording]:
        """The candidate in all recordings that hold its causes."""
        return [in_recording for in_recording in self.in_recordings if in_recording is not None]

    @property
    def columns(self) -> list[Array | None]:
        """Columns (n, q, k) in rows of each recording."""
        return [None if in_recording is None else in_recording.columns for in_recording in self.in_recordings]

    @property
    def policy(self) -> Policy:
        """The policy of the diagnosis."""
        return self.tested[0].problem.policy

    @property
    def indistinct_nats(self) -> float:
        """Difference of nats within which another candidate is as good."""
        return self.policy.apart * self.inflation

    @property
    def gain(self) -> float:
        """Nats over all recordings, not inflated: of common coefficients or, if larger, of each recording's own."""
        common = float(cross_predicted_gains([in_recording.estimate for in_recording in self.tested]).sum())
        own = sum(in_recording.held_out_gain for in_recording in self.tested)
        return max(common - sum(in_recording.null_gain for in_recording in self.tested), own) - self.price

    @cached_property
    def estimates(self) -> tuple[CoefficientEstimate | None, ...]:
        """Estimates of the coefficients in each recording, with errors widened by their scatter."""
        parts = [[estimate(part) for part in in_recording.parts] for in_recording in self.tested]
        found = iter(with_scatter(parts, [part.inflation for part in self.tested]) if parts else ())
        return tuple(None if part is None else next(found) for part in self.in_recordings)

    @property
    def error_degrees(self) -> int:
        """Degrees of freedom of the coefficients' error estimates."""
        return sum(len(in_recording.parts) - 1 for in_recording in self.tested)

    def nats(self, i: int, c: Array) -> float:
        """Nats explained in a recording by coefficients (k,), over the inflation of their error."""
        in_recording, estimate = self.in_recordings[i], self.estimates[i]
        return 0.0 if in_recording is None or estimate is None else in_recording.nats_at(c) / estimate.inflation(c)

    def own_nats(self, i: int) -> float:
        """Nats on held-out folds of a recording's own coefficients, over the inflation of their error."""
        in_recording, estimate = self.in_recordings[i], self.estimates[i]
        return (
            0.0
            if in_recording is None or estimate is None
            else in_recording.held_out_gain / estimate.inflation(estimate.c)
        )

    @cached_property
    def inflation(self) -> float:
        """Mean inflation of the recordings."""
        return float(np.mean([in_recording.inflation for in_recording in self.tested])) if self.tested else 1.0


def with_own_effects(in_recording: CandidateInRecording, own_columns: Sequence[Array]) -> CandidateInRecording:
    """Add columns (N, q, k) of its recording's own effects, where these explain the candidate and more.

    An own cause of one recording must not support an effect of another name in the pool.
    """
    if not own_columns:
        return in_recording
    before, policy = in_recording.baseline, in_recording.problem.policy
    baseline = ColouredBaseline.in_rows(before.rows, before.columns_with(before.rows.bin_groups(own_columns)))
    own, noise_model = baseline.hypothesis.held_out_log_likelihood, baseline.hypothesis.noise_model
    if own - in_recording.hypothesis.held_out_log_likelihood <= policy.apart * in_recording.inflation:
        return in_recording
    alone = held_out_nats(before, before.columns_with(in_recording.columns), noise_model)
    alone -= held_out_nats(before, before.accepted_columns, noise_model)
    kept = held_out_nats(before, baseline.columns_with(in_recording.columns), noise_model) - own
    if kept >= policy.half * max(alone, 1e-9):
        return in_recording
    return CandidateInRecording.of(in_recording.candidate, in_recording.problem, baseline, in_recording.columns)


def held_out_nats(baseline: ColouredBaseline, columns: Array, noise_model: NoiseModel) -> float:
    """Log-likelihood of held-out folds with columns (n, q, k) fitted, for a given noise model."""
    return Hypothesis.with_noise_model(baseline.rows, columns, noise_model).held_out_log_likelihood


def columns_in(candidate: Candidate, problem: LinearProblem) -> Array | None:
    """Columns (N, q, k) of a candidate in a recording; None where causes, motor or place are missing.

    A place found in another recording may lie on the path of this recording.
    """
    if missing_channels(candidate.effect, problem) or not _holds(candidate, problem.state):
        return None
    columns = candidate.columns(problem)
    return columns if np.isfinite(columns).all() and columns.any() else None


def _holds(candidate: Candidate, state: State) -> bool:
    """Whether a recording has the motor and the channel named by a setting."""
    values, effect = dict(candidate.nonlinear), candidate.effect
    motor, channel = (values.get(effect.with_role(role) or "") for role in ("motor", "channel"))
    return (not motor or motor in state.motors) and (not channel or channel in state.channels)
