"""Candidates judged on held-out segments: evidence, inflated by what is still coloured in the residual."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from sim.effects import EFFECTS
from sim.state import Array
from validation.diagnosis.evidence.blocks import HELD, SPLITS, Cut, Fit, Sums, fit, inflation, squares, sums
from validation.diagnosis.evidence.problem import Problem
from validation.diagnosis.library.candidates import Candidate
from validation.diagnosis.library.search import refined, searched

ALPHA = 0.01
SEARCHED = 50
"""Settings beyond which they come from a search over the whole record, not from a list profiled in training."""
THRESHOLD = math.log(1 / ALPHA)
"""Most evidence D by which look-alikes may fall short of the best."""
ACCEPT = math.log(len(EFFECTS) / ALPHA)
"""Least evidence that is accepted: the same, for the best of a whole library."""


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
    fit: Fit
    width: int

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.candidate.name

    @property
    def D(self) -> float:
        """Evidence in nats, deflated by what is still coloured."""
        return self.gain / self.V

    @property
    def coefficients(self) -> Array:
        """The candidate's own coefficients."""
        return self.fit.c[self.fit.c.size - self.width :]

    def behind(self, best: Evidence) -> bool:
        """Whether the data tell this candidate from a better one."""
        return (best.gain - self.gain) / best.V > THRESHOLD


@dataclass(frozen=True)
class Ground:
    """A problem cut into blocks, with the columns (n, q, k) of the effects already in and their sums."""

    problem: Problem
    cut: Cut
    inside: Array
    sums: Sums

    @classmethod
    def of(cls, problem: Problem, inside: Array | None = None) -> Ground:
        """The ground with the effects already in, none at first."""
        n, q = problem.target.shape
        columns = np.zeros((n, q, 0)) if inside is None else inside
        cut = Cut.of(n, problem.state.interval_s)
        return cls(problem, cut, columns, sums(cut, problem.base, columns, problem.target, problem.usable))

    def residual(self, f: Fit | None = None) -> Array:
        """What the base and the effects already in leave (n, q), in units of the noise."""
        f = self.whole() if f is None else f
        left = self.problem.target - self.problem.base @ f.beta - np.einsum("nqk,k->nq", self.inside, f.c)
        return np.asarray(left * self.problem.usable[:, None])

    def whole(self) -> Fit:
        """The fit on all blocks."""
        return fit(self.sums, np.ones(self.cut.m, bool))


def judge(ground: Ground, members: Sequence[Candidate]) -> Evidence | None:
    """The evidence of a candidate: its listed or searched settings, and the best of them refined."""
    problem = ground.problem
    found = _judged(ground, searched(problem, ground.residual(), problem.base, list(members)))
    if found is None or found.D <= THRESHOLD:
        return found
    finer = refined(found.candidate, lambda candidate: _misfit(ground, candidate))
    better = _judged(ground, [finer]) if finer else None
    return better if better is not None and better.gain > found.gain else found


def judged_columns(ground: Ground, columns: Array) -> float:
    """Evidence D of columns (n, q, k) that belong to no effect: nats on held-out segments over the inflation."""
    joint = _joined(ground, columns)
    gains = [
        (squares(ground.sums, fit(ground.sums, ~held), held) - squares(joint, fit(joint, ~held), held)) / 2
        for held in map(ground.cut.held, range(SPLITS))
    ]
    return sum(gains) / HELD / inflation(joint, fit(joint, np.ones(ground.cut.m, bool)))


def _misfit(ground: Ground, candidate: Candidate) -> float:
    everything = np.ones(ground.cut.m, bool)
    s = _joined(ground, candidate.columns(ground.problem))
    return squares(s, fit(s, everything), everything)


def _judged(ground: Ground, settings: Sequence[Candidate]) -> Evidence | None:
    """Settings profiled on the training segments of each split; ln of the number tried is taken off."""
    joint = {i: s for i, member in enumerate(settings) if (s := _tried(ground, member)) is not None}
    usable = list(joint)
    if not usable:
        return None
    gains = []
    for split in range(SPLITS):
        held = ground.cut.held(split)
        before = squares(ground.sums, fit(ground.sums, ~held), held)
        trained = {i: fit(s, ~held) for i, s in joint.items()}
        best = min(usable, key=lambda i: squares(joint[i], trained[i], ~held))
        gains.append((before - squares(joint[best], trained[best], held)) / 2)
    everything = np.ones(ground.cut.m, bool)
    fits = {i: fit(s, everything) for i, s in joint.items()}
    best = min(usable, key=lambda i: squares(joint[i], fits[i], everything))
    chosen, factor = settings[best], inflation(joint[best], fits[best])
    width = joint[best].width - ground.inside.shape[2]
    gain = sum(gains) / HELD - factor * _price(chosen.tried * len(settings), width)
    strength, survival = _strength(ground, joint[best], fits[best], width)
    found = Evidence(chosen, gain, factor, strength, survival, joint[best], fits[best], width)
    return found if _possible(found) else None


def _tried(ground: Ground, member: Candidate) -> Sums | None:
    """Sums with a candidate's columns, which are not kept; None where they are zero or not finite."""
    columns = member.columns(ground.problem)
    finite = np.isfinite(columns).all() and np.abs(columns).max() > 0
    return _joined(ground, columns) if finite else None


def _price(tried: int, k: int) -> float:
    """Nats that the best of many searched settings with k columns gains by chance; 0 where nothing was searched."""
    return float(chi2.isf(1.0 / (2 * tried), k)) / 2 if tried > SEARCHED else 0.0


def _possible(found: Evidence) -> bool:
    """Whether the effect can have such a fit: no parameter beyond its bounds, none of one sign with the other."""
    effect, c = found.candidate.effect, found.coefficients
    if effect.linear and not found.candidate.phased:
        bounds = {p.name: (p.low, p.high) for p in effect.parameters()}
        return all(
            bounds[name][0] <= v <= bounds[name][1] for v, (name, _) in zip(c, effect.linear_units(), strict=True)
        )
    return bool(effect.linear or effect.tangents or c[0] > 0)


def _joined(ground: Ground, columns: Array) -> Sums:
    both = np.concatenate([ground.inside, columns], axis=2) if ground.inside.size else columns
    return sums(ground.cut, ground.problem.base, both, ground.problem.target, ground.problem.usable)


def _strength(ground: Ground, s: Sums, f: Fit, k: int) -> tuple[float, float]:
    """Rms of the candidate's part after the base, and that over its raw rms."""
    c = f.c[-k:]
    raw = float(c @ s.EE.sum(axis=0)[-k:, -k:] @ c)
    BB, BE = s.BB.sum(axis=0), s.BE.sum(axis=0)[:, :, -k:] @ c
    taken = float(np.einsum("pq,pr,rq->", BE, np.linalg.pinv(BB, rcond=1e-13, hermitian=True), BE))
    left = max(raw - taken, 0.0)
    samples = max(float(s.count.sum()) * ground.problem.target.shape[1], 1.0)
    return math.sqrt(left / samples), math.sqrt(left / raw) if raw > 0 else 0.0
