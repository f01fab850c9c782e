"""The loop: the best candidate goes in, the rest are judged beside it, until nothing gains or what is left is clean."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sim.effects import BY_NAME
from sim.state import Array
from validation.diagnosis.evidence.battery import Battery, battery
from validation.diagnosis.evidence.blocks import Cut
from validation.diagnosis.evidence.compare import ACCEPT, THRESHOLD, Evidence, Ground, judge, judged_columns
from validation.diagnosis.evidence.problem import Problem
from validation.diagnosis.evidence.stated import as_stated
from validation.diagnosis.library.candidates import ABSORBED, Candidate, proposed
from validation.diagnosis.library.search import SEARCHES

MOST_EFFECTS = 3
MEMORY = 10
FORM_ERROR, SAME_FORM = 0.15, 0.35
"""A further effect below this part of the first's size is the first's form, not a name of its own."""
UNSEEN, SMOOTH_S = 0.1, 1.0
"""Largest survival of an effect that the base takes up nearly whole; length of the means that it is read from."""
Progress = Callable[[str], object]


@dataclass(frozen=True)
class Found:
    """An accepted effect, those that the data do not tell from it, and every candidate ranked beside it."""

    evidence: Evidence
    alternatives: tuple[str, ...]
    ranking: tuple[Evidence, ...]

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.evidence.name


@dataclass(frozen=True)
class Selection:
    """What the loop found: effects in order, the ground with all of them in, and the tests before and after."""

    found: tuple[Found, ...]
    start: Ground
    end: Ground
    before: Battery
    after: Battery
    first_ranking: tuple[Evidence, ...]


def select(problem: Problem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None) -> Selection:
    """Effects one after the other, each accepted on held-out evidence.

    without : names left out of the library (the bench's leave-one-out).
    """
    start = ground = Ground.of(problem)
    members = proposed(problem, without)
    before = now = residual_tests(ground, ())
    if before.clean and as_stated(problem, ground.residual()):  # slow errors that the model states look like effects
        return Selection((), start, ground, before, before, ())
    found: list[Found] = []
    first: tuple[Evidence, ...] = ()
    while len(found) < MOST_EFFECTS and not (found and now.clean):
        say(f"candidates, round {len(found) + 1}")
        ranking = _ranked(ground, members)
        first = first or ranking
        if not ranking or ranking[0].D <= ACCEPT:
            break
        chosen = found_among(ranking)
        if found and chosen.evidence.gain < _form(chosen, found) ** 2 * found[0].evidence.gain:
            break
        found.append(chosen)
        ground = Ground.of(problem, _with(ground, chosen))
        now = residual_tests(ground, tuple(f.name for f in found))
        if now.clean and _earth_vector_left(ground):
            now = replace(now, why=("a constant vector in the earth's frame",))
    return Selection(tuple(found), start, ground, before, now, first)


def _form(chosen: Found, found: list[Found]) -> float:
    """Part of the first effect's size below which another is only its form; more for one that is in already."""
    return SAME_FORM if chosen.name in {f.name for f in found} else FORM_ERROR


def _earth_vector_left(ground: Ground) -> bool:
    """Whether a constant error of the earth's field is left, which an effect that depends on the place imitates."""
    problem = ground.problem
    if problem.mode != "vector":
        return False
    constant = judged_columns(ground, problem.whitened(problem.state.R_wb.transpose(0, 2, 1), "field"))
    return constant > THRESHOLD


def found_among(ranking: tuple[Evidence, ...]) -> Found:
    """The best of those that the data do not tell from the strongest: the one with the fewest columns."""
    best = ranking[0]
    close = [e for e in ranking if not e.behind(best) and e.D > THRESHOLD]
    name = min(close, key=lambda e: (e.width, -e.gain))
    return Found(name, tuple(e.name for e in close if e is not name), ranking)


def residual_tests(ground: Ground, names: tuple[str, ...]) -> Battery:
    """The tests of what a ground leaves; slow errors that the model itself states pass them.

    After a low-pass or a delay the noise has a memory of some samples.
    """
    fitted = ground.problem.base.shape[1] * ground.problem.target.shape[1] + ground.inside.shape[2]
    memory = MEMORY if {"latency", "bandwidth"} & set(names) else 1
    left = ground.residual()
    tests = battery(left, ground.problem.usable, ground.problem.state.interval_s, fitted, memory)
    return tests if tests.clean or not as_stated(ground.problem, left) else replace(tests, why=())


def base_changes(selection: Selection, without: frozenset[str] = frozenset()) -> tuple[Found, ...]:
    """What of the base differs from the model as it was given: iron, offset, scale, axes, turn; vector mode only.

    Its alternatives are also the effects that look like that change on this motion.
    """
    problem = selection.end.problem
    if problem.mode != "vector":
        return ()
    target = (problem.recording.mag_nT - problem.predicted_nT) / problem.sigma_nT * problem.usable[:, None]
    bare = replace(problem, base=np.zeros((len(target), 1)), target=target)
    ground = Ground.of(bare, selection.end.inside)
    members = {name: [Candidate(BY_NAME[name])] for name in ABSORBED}
    others = {name: several for name, several in proposed(problem, without).items() if name not in SEARCHES}
    found: list[Found] = []
    least = FORM_ERROR**2 * max((_raw_gain(f.evidence) for f in selection.found), default=0.0)
    while len(found) < MOST_EFFECTS:
        ranking = _ranked(ground, members)
        if not ranking or ranking[0].D <= ACCEPT:
            break
        chosen = found_among(ranking)
        least = max(least, FORM_ERROR**2 * found[0].evidence.gain) if found else least
        if chosen.evidence.gain < least or chosen.evidence.strength < _turned_by(problem):
            break
        alike = tuple(e.name for e in _ranked(ground, others) if not e.behind(ranking[0]))
        found.append(replace(chosen, alternatives=(*chosen.alternatives, *alike)))
        ground = Ground.of(bare, _with(ground, chosen))
    return tuple(found)


def _turned_by(problem: Problem) -> float:
    """Rms that the stated attitude error makes, in units of the noise; a smaller change of the base cannot be told."""
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    return problem.attitude_std_rad * strength_nT / float(np.sqrt((problem.sigma_nT**2).mean()))


def _with(ground: Ground, chosen: Found) -> Array:
    """The columns (n, q, k) already in, and a chosen effect's."""
    return np.concatenate([ground.inside, chosen.evidence.candidate.columns(ground.problem)], axis=2)


def _raw_gain(found: Evidence) -> float:
    """Nats that an effect explains where the base is not fitted anew."""
    samples = float(found.sums.count.sum()) * found.sums.y1.shape[1]
    return float(samples * (found.strength / max(found.survival, 1e-9)) ** 2 / 2)


def unseen(problem: Problem) -> tuple[str, ...]:
    """Effects that have the channels but that the base takes up nearly whole on this motion."""
    ground = Ground.of(problem)
    return tuple(
        name
        for name, members in proposed(problem).items()
        if name not in SEARCHES and _survival(ground, members[0]) < UNSEEN
    )


def _survival(ground: Ground, member: Candidate) -> float:
    """``rho = |(I - P_base) E| / |E|`` of a candidate's columns, as means over SMOOTH_S (rates are noisy)."""
    columns = member.columns(ground.problem)
    cut = Cut(max(1, round(SMOOTH_S / ground.problem.state.interval_s)), 1)
    cut = replace(cut, m=len(columns) // cut.length)
    E, B = (cut.blocks(values).mean(axis=1) for values in (columns, ground.problem.base))
    Q = np.linalg.qr(B / np.linalg.norm(B, axis=0))[0]
    left = E - np.einsum("np,pqk->nqk", Q, np.einsum("np,nqk->pqk", Q, E))
    size = float(np.linalg.norm(E))
    return float(np.linalg.norm(left)) / size if size > 0 else 0.0


def _ranked(ground: Ground, members: dict[str, list[Candidate]]) -> tuple[Evidence, ...]:
    judged = (judge(ground, several) for several in members.values())
    return tuple(sorted((e for e in judged if e is not None), key=lambda e: -e.gain))
