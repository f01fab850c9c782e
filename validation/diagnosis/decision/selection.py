"""The loop: the best candidate goes in, the rest are judged beside it, until nothing gains or what is left is clean."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from sim.effects import BY_NAME, EFFECTS
from sim.state import Array
from validation.diagnosis.evidence.battery import Battery, battery
from validation.diagnosis.evidence.compare import Evidence, ranked
from validation.diagnosis.evidence.ground import Ground
from validation.diagnosis.evidence.stated import as_stated
from validation.diagnosis.library.candidates import proposed
from validation.diagnosis.policy import Policy
from validation.diagnosis.problem.linear import LinearProblem

Progress = Callable[[str], object]
CHAIN = tuple(BY_NAME)


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


@dataclass(frozen=True)
class Selection:
    """What the loop found: effects in order, the ground with all of them in, and the tests before and after.

    without: names that were left out of the library; first_ranking: every candidate, the strongest first.
    """

    found: tuple[Accepted, ...]
    start: Ground
    end: Ground
    before: Battery
    after: Battery
    first_ranking: tuple[Evidence, ...]
    without: frozenset[str]


def select(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Effects one after the other, each accepted on held-out evidence.

    without : names left out of the library (the bench's leave-one-out).
    """
    start = ground = Ground.of(problem)
    before = after = residual_tests(ground, ())
    if before.clean and as_stated(problem, ground.residual()):  # slow errors that the model states look like effects
        return Selection((), start, start, before, before, (), without)
    members = proposed(problem, without)
    found: list[Accepted] = []
    first: tuple[Evidence, ...] = ()
    while len(found) < problem.policy.most_effects and not (found and after.clean):
        say(f"candidates, round {len(found) + 1}")
        ranking = ranked(ground, members)
        first = first or ranking
        chosen = accepted(ranking, problem.policy)
        if chosen is None or _is_form(chosen, found, problem.policy):
            break
        found.append(chosen)
        ground = ground.beside(chosen.columns(problem))
        after = _with_earth_vector(residual_tests(ground, found), ground)
    return Selection(tuple(found), start, ground, before, after, first, without)


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


def residual_tests(ground: Ground, found: Sequence[Accepted]) -> Battery:
    """The tests of what a ground leaves; slow errors that the model itself states pass them.

    After a low-pass or a delay the noise has a memory of some samples.
    """
    problem, left = ground.problem, ground.residual()
    fitted = problem.base.shape[1] * problem.target.shape[1] + ground.inside.shape[2]
    filtered = any(BY_NAME[one.name].clues.memory for one in found)
    samples = problem.policy.filter_memory if filtered else 1
    tests = battery(left, problem.usable, problem.state.interval_s, fitted, problem.policy, samples)
    return tests if tests.clean or not as_stated(problem, left) else replace(tests, why=())


def _is_form(chosen: Accepted, found: Sequence[Accepted], policy: Policy) -> bool:
    """Whether an effect is so much smaller than the first that it is only the first's form."""
    if not found:
        return False
    again = chosen.name in {one.name for one in found}
    share = policy.same_form_share if again else policy.form_share
    return chosen.evidence.gain < share**2 * found[0].evidence.gain


def _with_earth_vector(tests: Battery, ground: Ground) -> Battery:
    """The tests, failed where a constant vector of the earth's frame is left.

    An effect that depends on the place imitates such an error of the field.
    """
    problem = ground.problem
    if not tests.clean or problem.mode != "vector":
        return tests
    constant = problem.whitened(problem.state.R_wb.transpose(0, 2, 1), "field")
    if ground.evidence_of(constant) <= problem.policy.apart:
        return tests
    return replace(tests, why=("a constant vector in the earth's frame",))
