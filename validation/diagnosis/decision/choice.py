"""The choice of the next effect: the best on held-out data, or the simplest of those as good."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.effects import BY_NAME, EFFECTS
from sim.state import Array
from validation.diagnosis.evidence.compare import Evidence
from validation.diagnosis.evidence.ground import Ground
from validation.diagnosis.evidence.standing import Beside, Standing, gains_along_the_field, look_alikes
from validation.diagnosis.policy import Policy
from validation.diagnosis.problem.linear import LinearProblem

CHAIN = tuple(BY_NAME)
IsClean = Callable[[Ground, str], bool]
"""(ground with an effect in, its name) -> whether what is left is white."""


@dataclass(frozen=True)
class Accepted:
    """An accepted effect, and those that the data do not tell from it."""

    evidence: Evidence
    alternatives: tuple[str, ...]

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.evidence.name

    def columns(self, problem: LinearProblem) -> Array:
        """Its columns (n, q, k)."""
        return self.evidence.candidate.columns(problem)


def accepted(ranking: Sequence[Evidence], policy: Policy) -> Accepted | None:
    """The one with the fewest columns of those that the data do not tell from the best, if the best is accepted."""
    if not ranking or ranking[0].nats <= policy.accepted(len(EFFECTS)):
        return None
    close = [e for e in ranking if not e.behind(ranking[0], policy) and e.nats > policy.apart]
    chosen = _simplest(close, policy)
    return Accepted(chosen, tuple(e.name for e in close if e is not chosen))


def _simplest(close: Sequence[Evidence], policy: Policy) -> Evidence:
    """The strongest of those with the fewest columns; of two that are one and the same, the chain's first.

    Hard iron and a sensor's offset span the same columns: which of them gains more is a matter of the last bit. Others
    say of themselves that they are the same.
    """
    narrowest = min(e.width for e in close)
    rivals = [e for e in close if e.width == narrowest]
    best = max(rivals, key=lambda e: e.gain)
    like = best.candidate.effect.clues.same_as
    same = [e for e in rivals if e.name == like or math.isclose(e.gain, best.gain, rel_tol=policy.same_gain)]
    return min(same, key=lambda e: CHAIN.index(e.name))


def accepted_beside_colour(
    ground: Ground, ranking: Sequence[Evidence], start: Ground, is_clean: IsClean
) -> Accepted | None:
    """The candidate that beats a rest with its own colour; one rest for all would swallow it, or take it for granted.

    start : the ground without any effect, whose gap a share is of.
    """
    beside = Beside.of(ground.problem, ground.inside)
    tried = _first_look(ground, beside, ranking)
    for best in sorted(tried, key=lambda one: -one.gain):
        with_it = ground.beside(best.evidence.candidate.columns(ground.problem))
        coloured = not is_clean(with_it, best.evidence.name)
        by_chance = beside.surrogates(best)
        inflation = max(1.0, 2 * float(by_chance.mean()) / best.columns.shape[2])
        if _stands(best, inflation, float(by_chance.max()), ground, coloured=coloured) and not (
            coloured and added_share(start, ground, with_it) < ground.problem.policy.least_added
        ):
            return _named(best, tried, beside, inflation, coloured=coloured)
    return None


def added_share(start: Ground, before: Ground, after: Ground) -> float:
    """Share of the first gap that an effect explains beside those before it, by ordinary least squares."""
    first, poorer, richer = (float((ground.residual() ** 2).mean()) for ground in (start, before, after))
    return (poorer - richer) / max(first - 1, 1e-9)


def _first_look(ground: Ground, beside: Beside, ranking: Sequence[Evidence]) -> list[Standing]:
    """The best candidates with the rest as it is, each with a rest of its own."""
    if not ranking:
        return []
    columns = [beside.rows.taken(e.candidate.columns(ground.problem)) for e in ranking]
    best = np.argsort(-beside.roughly(columns), kind="stable")[: ground.problem.policy.tried_coloured]
    return [beside.standing(ranking[i], columns[i]) for i in best]


def _stands(best: Standing, inflation: float, most: float, ground: Ground, *, coloured: bool) -> bool:
    policy = ground.problem.policy
    needed = policy.coloured_nats if coloured else policy.accepted(len(EFFECTS))
    if best.gain / inflation <= needed or best.gain <= most:
        return False
    if not coloured or ground.problem.mode != "vector" or not best.evidence.candidate.effect.clues.source:
        return True
    return gains_along_the_field(ground.problem, ground.inside, best.evidence.candidate.columns(ground.problem))


def _named(best: Standing, tried: Sequence[Standing], beside: Beside, inflation: float, *, coloured: bool) -> Accepted:
    """The simplest of those as good as the best and of its kin, and all others that look like it."""
    policy = beside.rows.policy
    chance = policy.apart * inflation
    others = [one for one in tried if one is not best]
    kin = [one for one in others if are_kin(one.evidence, best.evidence)]
    as_good = look_alikes(best, others, beside, chance, 0.0)
    of_its_kin = look_alikes(best, kin, beside, chance, policy.same_kin_coloured if coloured else policy.same_kin)
    alike = look_alikes(best, others, beside, chance, policy.same_coloured) if coloured else []
    simplest = [best, *as_good, *(one for one in of_its_kin if one not in as_good)]
    chosen = _simplest([_deflated(one, inflation) for one in simplest], policy)
    names = dict.fromkeys(one.evidence.name for one in (*simplest, *alike))
    return Accepted(chosen, tuple(name for name in names if name != chosen.name))


def are_kin(one: Evidence, other: Evidence) -> bool:
    """Whether two effects are the same to first order."""
    kin = one.candidate.effect.clues.kin
    return bool(kin) and kin == other.candidate.effect.clues.kin


def _deflated(one: Standing, inflation: float) -> Evidence:
    return replace(one.evidence, gain=one.gain, V=inflation)
