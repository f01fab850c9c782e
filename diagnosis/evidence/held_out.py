"""Evidence of candidates on held-out segments, over the inflation by the residual's colour; results of a round."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from calib.numerics.symmetric import symmetric_inverse
from diagnosis.evidence.baseline import Baseline
from diagnosis.library.candidates import Candidate
from diagnosis.library.parameter_search import refine_between_neighbours, search_parameters
from diagnosis.policy import Policy
from diagnosis.problem.blocks import BlockFit, Sums, fit, inflation, squares
from scenarios.arrays import Array

NAMED, BEHIND, TOO_LITTLE = "named", "explains less", "below what is needed"
INDISTINGUISHABLE, HARDLY_MORE = "cannot be distinguished from", "explains little more than"
WITHDRAWN, SMALL_SHARE = "withdrawn: ", "the named effects together explain too little of the gap"


@dataclass(frozen=True)
class Evidence:
    """Evidence of a candidate on held-out data beside the accepted effects, and its fit on all blocks.

    gain: nats of log-likelihood; V: inflation of the nats by coloured noise; strength: rms of the contribution after
    the base is refitted, in units of the noise; survival: strength over the rms before the refit; raw_gain: nats that
    the effect explains without a refit of the base; coefficients c (k,) with covariance (k, k); squares: sum of squared
    residuals beside the accepted effects, over a number of blocks. The columns are computed again where needed.
    """

    candidate: Candidate
    gain: float
    V: float
    strength: float
    survival: float
    raw_gain: float
    coefficients: Array
    covariance: Array
    squares: float
    blocks: int

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.candidate.name

    @property
    def nats(self) -> float:
        """Evidence ``gain / V`` in nats."""
        return self.gain / self.V

    @property
    def scale_error(self) -> float:
        """``|ln c|`` of an effect without linear coefficients, 0 at its own size; else 0."""
        free = self.candidate.effect.linear or self.candidate.effect.tangents or not self.candidate.nonlinear
        return 0.0 if free else abs(math.log(max(float(self.coefficients[0]), 1e-9)))

    @property
    def width(self) -> int:
        """Number of columns k."""
        return len(self.coefficients)

    def is_behind(self, best: Evidence, policy: Policy) -> bool:
        """Whether the data distinguish the candidate from a better candidate."""
        return (best.gain - self.gain) / best.V > policy.apart


def rank_candidates(baseline: Baseline, settings: dict[str, list[Candidate]]) -> tuple[Evidence, ...]:
    """Evidence of every candidate with an admissible fit, strongest first."""
    judged = (judge_candidate(baseline, several) for several in settings.values())
    return tuple(sorted((e for e in judged if e is not None), key=lambda e: -on_six_digits(e.gain)))


def on_six_digits(nats: float) -> float:
    """Nats on six digits: where only rounding differs, candidates keep the order of the chain."""
    return float(f"{nats:.6g}")


def judge_candidate(baseline: Baseline, settings: Sequence[Candidate]) -> Evidence | None:
    """Evidence of a candidate at its best setting, listed or searched, then refined; None if inadmissible."""
    found = judge_settings(baseline, search_parameters(baseline.problem, baseline.residual(), list(settings)))
    if found is None:
        return None
    # of a number with one value nothing else may be tried, and little evidence is not worth a refinement
    if found.nats > baseline.problem.policy.apart and len(settings) > 1:
        found = refine_listed(baseline, found)
    return _at_own_size(baseline, found)


def refine_listed(baseline: Baseline, found: Evidence) -> Evidence:
    """Evidence with the listed parameter refined between its neighbours in the list, if larger."""
    finer = refine_between_neighbours(found.candidate, lambda candidate: misfit(baseline, candidate))
    better = judge_settings(baseline, [finer]) if finer else None
    return better if better is not None and better.gain > found.gain else found


def _at_own_size(baseline: Baseline, found: Evidence) -> Evidence | None:
    """Evidence of an effect without coefficients near its own size, or with its listed value scaled; None otherwise.

    Below a sample interval, twice the delay is nearly twice the effect.
    """
    candidate, limit = found.candidate, baseline.problem.policy.far_larger
    if candidate.effect.linear or candidate.effect.tangents or not candidate.nonlinear:
        return found
    scale = float(found.coefficients[0])
    moved = () if 1 / limit < scale < limit else candidate.scaled(scale)
    for one in (found, *(judge_settings(baseline, [one]) for one in moved)):
        if one is not None and 1 / limit < one.coefficients[0] < limit:
            return one
    return None


def judge_settings(baseline: Baseline, settings: Sequence[Candidate]) -> Evidence | None:
    """Evidence of several settings, profiled on the training segments of each split, less the price of their number.

    The gain is at most the gain on all blocks: where the training segments do not determine the base, held-out gains
    compare two extrapolations and can be too large. None where no setting has finite non-zero columns, or the best fit
    is outside the effect's bounds.
    """
    problem, every, tried = baseline.problem, baseline.all_folds, list[tuple[Candidate, Sums, BlockFit, float]]()
    for setting in settings:
        joint = baseline.sums_with(setting.columns(problem))
        if _is_admissible(joint, baseline.sums.width):
            whole = fit(joint, every)
            tried.append((setting, joint, whole, squares(joint, whole, every)))
    if not tried:
        return None
    best, joint, whole, least = min(tried, key=lambda each: each[3])
    k, V = joint.width - baseline.sums.width, inflation(joint, whole, problem.policy)
    gain = min(baseline.held_out_gain(*(each[1] for each in tried)), (baseline.squares - least) / 2)
    gain, c = gain - V * search_price(best.tried * len(settings), k, problem.policy), whole.c[-k:]
    found = Evidence(best, gain, V, *_strength(joint, c), c, whole.covariance[-k:, -k:], least, len(joint.count))
    return found if best.within_bounds(c) and best.is_natural(problem, c) else None


def _is_admissible(s: Sums, known: int) -> bool:
    """Whether the columns after a known number are finite, and not all zero."""
    power = np.einsum("fkk->k", s.CC)[1 + known :]
    return bool(np.isfinite(power).all() and power.any())


def search_price(tried: int, k: int, policy: Policy) -> float:
    """Nats that the best of many searched settings with k columns gains by chance; 0 where nothing was searched.

    ``x / 2`` with ``P(chi2_k > x) = 1 / (odds tried)``.
    """
    if tried <= policy.listed_settings:
        return 0.0
    return float(chi2.isf(1.0 / (policy.search_price_odds * tried), k)) / 2


def misfit(baseline: Baseline, candidate: Candidate) -> float:
    """Sum of squared residuals of a candidate beside the accepted effects."""
    s = baseline.sums_with(candidate.columns(baseline.problem))
    return squares(s, fit(s, baseline.all_folds), baseline.all_folds)


def _strength(s: Sums, c: Array) -> tuple[float, float, float]:
    """Rms of the last columns times c (k,) after the base is refitted, its ratio to the rms before, and nats before."""
    k, samples = len(c), max(s.samples, 1.0)
    raw = float(c @ s.CC.sum(axis=0)[-k:, -k:] @ c)
    BB, BE = s.BB.sum(axis=0), s.BC.sum(axis=0)[:, :, -k:] @ c
    taken = float(np.einsum("pq,pr,rq->", BE, symmetric_inverse(BB, 1e-13), BE))
    remaining = max(raw - taken, 0.0)
    return math.sqrt(remaining / samples), math.sqrt(remaining / raw) if raw > 0 else 0.0, raw / 2


@dataclass(frozen=True)
class CandidateResult:
    """A candidate with its evidence and the nats needed, under the noise model of the round; the outcome in words."""

    evidence: Evidence
    nats: float
    needed: float
    outcome: str

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.evidence.name


def with_outcomes(
    results: Sequence[CandidateResult], named: str | None, alternatives: Sequence[str]
) -> tuple[CandidateResult, ...]:
    """Candidates, strongest first, each with the outcome that follows from the choice of `named`."""

    def outcome(result: CandidateResult) -> str:
        rules = (
            (NAMED, result.name == named),
            (f"{INDISTINGUISHABLE} {named}", result.name in alternatives),
            (result.outcome, bool(result.outcome)),
            (TOO_LITTLE, result.nats <= result.needed),
            (f"{HARDLY_MORE} {named}", named in result.evidence.candidate.effect.traits.contains),
            (BEHIND, True),
        )
        return next(words for words, holds in rules if holds)

    told = (replace(result, outcome=outcome(result)) for result in results)
    return tuple(sorted(told, key=lambda result: -on_six_digits(result.nats)))


def withdraw_names(results: Sequence[CandidateResult], doubts: Sequence[str]) -> tuple[CandidateResult, ...]:
    """Candidates with the outcome of every name withdrawn, for doubts or because the names explain too little."""
    why = WITHDRAWN + ("; ".join(doubts) or SMALL_SHARE)
    named = {result.name for result in results if result.outcome == NAMED}
    alike = {f"{INDISTINGUISHABLE} {name}" for name in named}
    return tuple(
        replace(result, outcome=why) if result.name in named or result.outcome in alike else result
        for result in results
    )
