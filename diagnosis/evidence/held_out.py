"""Candidates judged on held-out segments: evidence, inflated by what is still coloured in the residual."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from diagnosis.evidence.baseline import Baseline
from diagnosis.library.candidates import Candidate
from diagnosis.library.parameter_search import between_neighbours, found_by_search
from diagnosis.policy import Policy
from diagnosis.problem.blocks import BlockFit, Sums, fit, inflation, squares
from scenarios.arrays import Array


@dataclass(frozen=True)
class Evidence:
    """What a candidate explains beside those already in, on held-out data, and its fit on all blocks.

    gain: nats of log-likelihood; V: by how much colour inflates them; strength: rms of what it adds after the base is
    refitted, in units of the noise; survival: the part of its raw size that the base cannot take up; sums, fit: of
    [already in, candidate]; width: the candidate's number of columns, which are made again where they are needed.
    """

    candidate: Candidate
    gain: float
    V: float
    strength: float
    survival: float
    sums: Sums
    fit: BlockFit
    width: int

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.candidate.name

    @property
    def nats(self) -> float:
        """Evidence in nats, deflated by what is still coloured."""
        return self.gain / self.V

    @property
    def off_size(self) -> float:
        """``|ln c|`` of an effect without coefficients of its own: 0 at its own size; 0 for one that has them."""
        free = self.candidate.effect.linear or self.candidate.effect.tangents or not self.candidate.nonlinear
        return 0.0 if free else abs(math.log(max(float(self.coefficients[0]), 1e-9)))

    @property
    def squares(self) -> float:
        """Squares that it leaves beside those already in, in units of the noise."""
        return squares(self.sums, self.fit, self.sums.everything)

    @property
    def coefficients(self) -> Array:
        """The candidate's own coefficients."""
        return self.fit.c[self.fit.c.size - self.width :]

    @property
    def raw_gain(self) -> float:
        """Nats that the effect explains where the base is not fitted anew."""
        samples = float(self.sums.count.sum()) * self.sums.y1.shape[1]
        return float(samples * (self.strength / max(self.survival, 1e-9)) ** 2 / 2)

    def taken_from(self, ground: Baseline) -> float:
        """Rms of what it takes of what a ground leaves, in units of the noise."""
        samples = float(self.sums.count.sum()) * self.sums.y1.shape[1]
        return math.sqrt(max(ground.squares - self.squares, 0.0) / max(samples, 1.0))

    def behind(self, best: Evidence, policy: Policy) -> bool:
        """Whether the data tell this candidate from a better one."""
        return (best.gain - self.gain) / best.V > policy.apart


@dataclass(frozen=True)
class _Tried:
    """One setting of a candidate: sums of [already in, its columns], and the fit on all blocks."""

    setting: Candidate
    sums: Sums
    whole: BlockFit


def ranked(ground: Baseline, members: dict[str, list[Candidate]]) -> tuple[Evidence, ...]:
    """The evidence of every candidate that can have its fit, the strongest first."""
    judged = (judge(ground, several) for several in members.values())
    return tuple(sorted((e for e in judged if e is not None), key=lambda e: -e.gain))


def judge(ground: Baseline, members: Sequence[Candidate]) -> Evidence | None:
    """The evidence of a candidate: its listed or searched settings, and the best of them refined."""
    found = judged_at(ground, found_by_search(ground.problem, ground.residual(), list(members)))
    if found is None:
        return None
    little = found.nats <= ground.problem.policy.apart  # also beside a colour of its own, which may find it in a wander
    if little or len(members) == 1:  # of a number that has one value nothing else may be tried
        return _at_full_size(ground, found)
    return _at_full_size(ground, between_listed(ground, found))


def between_listed(ground: Baseline, found: Evidence) -> Evidence:
    """The evidence with a listed number between its neighbours in the list, where that gains more."""
    finer = between_neighbours(found.candidate, lambda candidate: misfit(ground, candidate))
    better = judged_at(ground, [finer]) if finer else None
    return better if better is not None and better.gain > found.gain else found


def _at_full_size(ground: Baseline, found: Evidence) -> Evidence | None:
    """The evidence where an effect without coefficients has its own size; None where it would have to be another.

    Below a sample's interval twice the delay is twice the effect: there the value is moved by what the fit scales it.
    """
    candidate, limit = found.candidate, ground.problem.policy.own_size
    if candidate.effect.linear or candidate.effect.tangents or not candidate.nonlinear:
        return found
    scale = float(found.coefficients[0])
    moved = () if 1 / limit < scale < limit else candidate.scaled(scale)
    for one in (found, *(judged_at(ground, [one]) for one in moved)):
        if one is not None and 1 / limit < one.coefficients[0] < limit:
            return one
    return None


def judged_at(ground: Baseline, settings: Sequence[Candidate]) -> Evidence | None:
    """The evidence of settings profiled on the training segments of each split, less the price of their number.

    No more than the best gains on all blocks: what is held out can gain more where the training segments alone do not
    determine the base, and two extrapolations differ. None where no setting has columns, or the best fit is none that
    the effect can have.
    """
    tried = list(_tried(ground, settings))
    if not tried:
        return None
    best = min(tried, key=lambda one: squares(one.sums, one.whole, ground.everything))
    policy, width = ground.problem.policy, best.sums.width - ground.sums.width
    V = inflation(best.sums, best.whole, policy)
    price = V * search_price(best.setting.tried * len(settings), width, policy)
    gain = min(ground.mean_gain(_gains(ground, tried)), _gain_on_all(ground, best)) - price
    strength, survival = _strength(ground, best, width)
    found = Evidence(best.setting, gain, V, strength, survival, best.sums, best.whole, width)
    c = found.coefficients
    return found if best.setting.possible(c) and best.setting.is_natural(ground.problem, c) else None


def search_price(tried: int, k: int, policy: Policy) -> float:
    """Nats that the best of many searched settings with k columns gains by chance; 0 where nothing was searched.

    ``x / 2`` with ``P(chi2_k > x) = 1 / (odds tried)``.
    """
    if tried <= policy.listed_settings:
        return 0.0
    return float(chi2.isf(1.0 / (policy.search_price_odds * tried), k)) / 2


def _tried(ground: Baseline, settings: Sequence[Candidate]) -> Iterable[_Tried]:
    """Settings whose columns are finite and not zero."""
    for setting in settings:
        columns = setting.columns(ground.problem)
        if np.isfinite(columns).all() and np.abs(columns).max() > 0:
            joint = ground.joined(columns)
            yield _Tried(setting, joint, fit(joint, ground.everything))


def _gains(ground: Baseline, tried: Sequence[_Tried]) -> list[float]:
    """Nats on what each split holds out, of the setting that fits its training segments best."""
    gains = []
    for held in ground.splits:
        before = squares(ground.sums, fit(ground.sums, ~held), held)
        trained = [(one.sums, fit(one.sums, ~held)) for one in tried]
        joint, best = min(trained, key=lambda one: squares(one[0], one[1], ~held))
        gains.append((before - squares(joint, best, held)) / 2)
    return gains


def _gain_on_all(ground: Baseline, one: _Tried) -> float:
    """Nats of a setting on the blocks that it was fitted to."""
    everything = ground.everything
    return (ground.squares - squares(one.sums, one.whole, everything)) / 2


def misfit(ground: Baseline, candidate: Candidate) -> float:
    """Squares that a candidate leaves beside those already in."""
    s = ground.joined(candidate.columns(ground.problem))
    return squares(s, fit(s, ground.everything), ground.everything)


def _strength(ground: Baseline, one: _Tried, k: int) -> tuple[float, float]:
    """Rms of the candidate's part after the base, and that over its raw rms."""
    s, c = one.sums, one.whole.c[-k:]
    raw = float(c @ s.EE.sum(axis=0)[-k:, -k:] @ c)
    BB, BE = s.BB.sum(axis=0), s.BE.sum(axis=0)[:, :, -k:] @ c
    taken = float(np.einsum("pq,pr,rq->", BE, np.linalg.pinv(BB, rcond=1e-13, hermitian=True), BE))
    left = max(raw - taken, 0.0)
    samples = max(float(s.count.sum()) * ground.problem.target.shape[1], 1.0)
    return math.sqrt(left / samples), math.sqrt(left / raw) if raw > 0 else 0.0
