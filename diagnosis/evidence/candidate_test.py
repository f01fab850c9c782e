"""Likelihood-ratio test of a candidate with its own noise model, against the baseline and time-shifted surrogates."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.held_out import TOO_LITTLE, Evidence, on_six_digits, search_price
from diagnosis.evidence.hypothesis import (
    Hypothesis,
    explained_nats,
    held_out_squares,
    in_sample_gains,
    information_matrices,
    products,
    project_out,
    remaining,
    solved,
    white_noise_model,
)
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array

NO_BETTER_THAN_SURROGATES = "no better than its own course shifted in time"


@dataclass(frozen=True, eq=False)
class CandidateFit:
    """A candidate fitted with its own noise model: columns (n, q, k) in rows, and the gain in nats on held-out folds.

    within : the part of the gain that comes from samples within the rows.
    """

    evidence: Evidence
    columns: Array
    rows: BinnedRows
    hypothesis: Hypothesis
    gain: float
    within: float = 0.0


@dataclass(frozen=True, eq=False)
class ColouredBaseline:
    """A problem in rows, accepted columns (n, q, k), and the null hypothesis of the accepted effects alone."""

    problem: LinearProblem
    rows: BinnedRows
    accepted_columns: Array
    hypothesis: Hypothesis

    @classmethod
    def of(cls, problem: LinearProblem, accepted_columns: Sequence[Array]) -> ColouredBaseline:
        """The coloured baseline of a problem with the columns (N, q, k) of several effects accepted."""
        state, sigma = problem.state, problem.sigma_nT
        output_axes = None if problem.output_axes is None else problem.output_axes * (sigma[0] / sigma)[:, None]
        rows = BinnedRows.of(state.time_s, problem.usable, problem.base, problem.target, problem.policy, output_axes)
        return cls.in_rows(problem, rows, rows.bin_groups(accepted_columns))

    @classmethod
    def in_rows(cls, problem: LinearProblem, rows: BinnedRows, accepted_columns: Array) -> ColouredBaseline:
        """The coloured baseline of given rows with accepted columns (n, q, k).

        The noise model is fitted twice, the second time from the first: ordinary least squares absorb a part of a
        random walk into the base, and the residual of such a fit has a different noise model, under which a drift would
        appear significant.
        """
        first = Hypothesis.of(rows, accepted_columns, (white_noise_model(rows.target.shape[1]),))
        again = Hypothesis.of(rows, accepted_columns, (first.noise_model,))
        likelier = max(first, again, key=lambda hypothesis: hypothesis.log_likelihood)
        return cls(problem, rows, accepted_columns, likelier)

    def columns_of(self, candidate: Candidate) -> Array:
        """Columns (n, q, k) of a candidate in the rows."""
        return self.rows.bin(candidate.columns(self.problem))

    def columns_with(self, columns: Array) -> Array:
        """Columns (n, q, k) of the accepted effects and further columns, side by side."""
        return np.concatenate([self.accepted_columns, columns], axis=2)

    def screening_gains(self, several: Sequence[Array]) -> Array:
        """Approximate nats (m,) that groups of columns gain under the noise model of the null hypothesis."""
        width = np.array([columns.shape[2] for columns in several])
        return np.asarray(
            in_sample_gains(self.rows, self.accepted_columns, several, self.hypothesis.noise_model) - width
        )

    def fit_columns(self, columns: Array) -> tuple[Hypothesis, Hypothesis, float]:
        """Fit further columns (n, q, k) with their own noise model, the likelier of two starts: the null's, and white.

        The null hypothesis under that noise model follows, and the gain in nats on held-out folds over the likelier of
        the two null hypotheses.
        """
        both, null = self.columns_with(columns), self.hypothesis
        richer = Hypothesis.of(self.rows, both, (null.noise_model, white_noise_model(both.shape[1])))
        same = Hypothesis.with_noise_model(self.rows, self.accepted_columns, richer.noise_model)
        poorer = max(null.held_out_log_likelihood, same.held_out_log_likelihood)
        return richer, same, richer.held_out_log_likelihood - poorer

    def fit_candidate(self, evidence: Evidence, columns: Array, within: float = 0.0) -> CandidateFit:
        """Fit a candidate with its own noise model: held-out gain plus nats `within` rows, less the search price."""
        rows, finer = self.rows.refine_folds(columns), self
        if rows is not self.rows:
            null = Hypothesis.with_noise_model(rows, self.accepted_columns, self.hypothesis.noise_model)
            finer = replace(self, rows=rows, hypothesis=null)
        hypothesis, _, gain = finer.fit_columns(columns)
        price = search_price(evidence.candidate.tried, evidence.width, rows.policy)
        return CandidateFit(evidence, columns, rows, hypothesis, gain + within - price, within)

    def beyond_chance(self, fit: CandidateFit, needed: float) -> tuple[float, str]:
        """Inflation of a candidate's nats by chance, and why the nats are not beyond chance; empty if they are.

        Chance is what the candidate's columns, shifted in time, gain.
        """
        surrogates = self.surrogate_gains(fit)
        inflation = inflation_by_chance(surrogates, fit.columns.shape[2])
        by_chance = "" if fit.gain > surrogates.max() else NO_BETTER_THAN_SURROGATES
        return inflation, by_chance if fit.gain / inflation > needed else TOO_LITTLE

    def nats_in_its_own_noise(self, fit: CandidateFit) -> float:
        """Nats of a candidate with the size of the noise where it acts as unknown, if clearly larger than elsewhere.

        ``N / 2 ln(1 + 2 gain / (V N))`` with ``V = sum f^2 r^2 / sum f^2`` and ``N = (sum f^2)^2 / sum f^4``, f the
        fitted effect and r the residual, whitened [White1980]: louder noise in a part of the run gains as an effect.
        """
        left = remaining(fit.rows, self.accepted_columns, fit.columns, fit.hypothesis.noise_model)
        added = left[:, :, :-1] @ solved(products(left))
        power = added**2 / max(float((added**2).sum()), 1e-300)
        V, N = float((power * (left[:, :, -1] - added) ** 2).sum()), 1 / max(float((power**2).sum()), 1e-300)
        louder = fit.rows.policy.clearly_larger < V
        return N / 2 * math.log1p(2 * max(fit.gain, 0.0) / (V * N)) if louder else fit.gain

    def surrogate_gains(self, candidate: CandidateFit) -> Array:
        """Nats (m,) that time-shifted columns of a candidate gain in sample from the candidate's residual."""
        kind, columns, hypothesis = candidate.evidence.candidate, candidate.columns, candidate.hypothesis
        return np.array([explained_nats(N) for N in self.surrogate_products(kind, columns, hypothesis)])

    def surrogate_products(self, candidate: Candidate, columns: Array, hypothesis: Hypothesis) -> list[Array]:
        """Products (k + 1, k + 1) of time-shifted columns and of the residual of a hypothesis with the candidate."""
        moved = surrogate_columns(candidate, self.problem, self.rows)
        rows = replace(self.rows, target=hypothesis.residual(self.rows, self.columns_with(columns)))
        return information_matrices(rows, columns[:, :, :0], moved, hypothesis.noise_model)

    def gains_beside(self, rival: Array, best: Array, noise_model: NoiseModel) -> tuple[float, float]:
        """Nats of a rival's columns (n, q, k) on held-out folds beside the best candidate's, and without these."""

        def held_out(*several: Array) -> float:
            columns = np.concatenate([self.accepted_columns, *several], axis=2)
            return Hypothesis.with_noise_model(self.rows, columns, noise_model).held_out_log_likelihood

        return held_out(best, rival) - held_out(best), held_out(rival) - held_out()

    def remaining_share(self, rival: CandidateFit, best: CandidateFit) -> float:
        """Share of a rival's gain that remains once the best candidate is accepted with its noise model."""
        baseline = replace(self, rows=best.rows)
        kept, alone = baseline.gains_beside(rival.columns, best.columns, best.hypothesis.noise_model)
        return kept / max(alone, 1e-9)


def inflation_by_chance(gains: Array, k: int) -> float:
    """Inflation of nats by coloured noise: mean gain (m,) of k columns as surrogates, over half a nat each."""
    return max(1.0, 2 * float(gains.mean()) / k)


def surrogate_columns(candidate: Candidate, problem: LinearProblem, rows: BinnedRows) -> list[Array]:
    """Time-shifted columns (n, q, k) of a candidate: surrogates of an absent effect, at several shifts.

    The course is continued by reflection, so that a monotone course has no jump. Where only the strength is known the
    contribution is shifted in the sensor frame and then projected along the unshifted motion: wander of an axis is
    modulated by the direction of the field, and the surrogates must be modulated alike; a field of the Earth is not.
    """
    if problem.mode == "vector" or candidate.effect.stage == "field":
        return list(_to_and_fro(rows.bin(candidate.columns(problem)), problem.policy.surrogates))
    moved = _to_and_fro(candidate.contribution_nT(problem), problem.policy.surrogates)
    return [rows.bin(problem.whitened(contribution_nT, candidate.effect)) for contribution_nT in moved]


def _to_and_fro(columns: Array, times: int) -> Iterator[Array]:
    n, both = len(columns), np.concatenate([columns[::-1], columns, columns[::-1]])
    for t in range(times):
        begin = int((2 * t + 1) / times * n)
        yield both[begin : begin + n]


def find_look_alikes(
    best: CandidateFit, others: Sequence[CandidateFit], coloured_baseline: ColouredBaseline, chance: float, share: float
) -> list[CandidateFit]:
    """Candidates within a number of nats or a share of the best gain, and without use once the best is accepted."""
    within = max(chance, share * best.gain)
    near = [other for other in others if best.gain - other.gain < within]
    return [
        other for other in near if coloured_baseline.remaining_share(other, best) < coloured_baseline.rows.policy.half
    ]


def gain_within(baseline: Baseline, rows: BinnedRows, columns: Array) -> float:
    """Nats that columns (N, q, k) gain in samples less their row means, on held-out folds, beside the accepted columns.

    Fast tones are lost in the means. 0 where the rows keep most of the columns' power. Slow noise is constant within a
    row and cancels, leaving white noise of variance one. Means and deviations are independent: their nats add up.
    """
    problem, power = baseline.problem, float((columns**2).sum())
    all_kept = len(rows.starts) == len(problem.target) or power == 0
    if all_kept or float((rows.bin(columns) ** 2).sum()) > problem.policy.half * power:
        return 0.0
    base = problem.base if rows.common else np.repeat(problem.base[:, None], problem.target.shape[1], axis=1)
    others = np.concatenate([*baseline.accepted_columns, columns, problem.target[:, :, None]], axis=2)
    base, others = (_about_means(rows, problem.usable, part) for part in (base, others))
    free, k = project_out(base, others, common=rows.common)[0], others.shape[2] - columns.shape[2] - 1
    left = project_out(free[:, :, :k], free[:, :, k:])[0]
    fold = np.repeat(rows.fold, np.diff(rows.starts, append=len(left)))
    squares, total = held_out_squares(left, fold, problem.policy.folds)
    return float(total[-1, -1] - squares) / 2


def _about_means(rows: BinnedRows, usable: Array, values: Array) -> Array:
    """Values (N, q, j) less the row mean of the usable values, 0 where not usable."""
    means = np.add.reduceat(values, rows.starts, axis=0) / np.maximum(rows.count, 1.0)[:, None, None]
    each = np.repeat(means, np.diff(rows.starts, append=len(values)), axis=0)
    return np.asarray((values - each) * usable[:, None, None])


def screen(
    candidates: Sequence[Evidence], beside: ColouredBaseline, baseline: Baseline, start: Baseline
) -> tuple[list[CandidateFit], list[tuple[Evidence, float]]]:
    """Fit the best candidates, each with a noise model of its own, the strongest first.

    The order is that of the nats by the noise model of all, with candidates of a negligible share of the gap last:
    refitted iron follows slow noise, and gains much. Returned with the other candidates and their nats.
    """
    policy, names = baseline.problem.policy, [evidence.name for evidence in candidates]
    columns, within = _in_rows(candidates, beside, baseline)
    nats = beside.screening_gains(columns) + within
    negligible = [added_share(start, baseline, evidence.squares) < policy.trace for evidence in candidates]
    first = best_of_each_name(names, nats, policy)
    order = sorted(first, key=lambda i: (negligible[i], -on_six_digits(float(nats[i]))))
    tried = {names[i] for i in order[: policy.tried_coloured]}
    settings = (each for each in zip(candidates, columns, within, strict=True) if each[0].name in tried)
    fits = [beside.fit_candidate(*each) for each in settings]
    best = best_of_each_name([fit.evidence.name for fit in fits], np.array([fit.gain for fit in fits]), policy)
    screened = [(candidates[i], float(nats[i])) for i in order[policy.tried_coloured :]]
    return sorted((fits[i] for i in best), key=lambda fit: -on_six_digits(fit.gain)), screened


def _in_rows(
    candidates: Sequence[Evidence], beside: ColouredBaseline, baseline: Baseline
) -> tuple[list[Array], list[float]]:
    """Columns (n, q, k) of candidates in rows, and the nats that each gains within the rows."""
    columns, within = list[Array](), list[float]()
    for evidence in candidates:  # whole columns are large: one candidate at a time
        whole = evidence.candidate.columns(baseline.problem)
        columns.append(beside.rows.bin(whole))
        within.append(gain_within(baseline, beside.rows, whole))
    return columns, within


def best_of_each_name(names: Sequence[str], nats: Array, policy: Policy) -> list[int]:
    """The best index for each name; a later one wins only where it gains more than a form error.

    Forms are fitted once the effect is accepted.
    """
    best: dict[str, int] = {}
    for i, name in enumerate(names):
        before = best.setdefault(name, i)
        if nats[i] > nats[before] + max(policy.apart, policy.same_coloured * nats[before]):
            best[name] = i
    return list(best.values())
