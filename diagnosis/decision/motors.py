"""A cause of several motors whose wires run differently: each motor with a gain of its own, and still one name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.decision.forms import Tests
from diagnosis.decision.white_choice import Accepted
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import Evidence, judged_at
from diagnosis.library.candidates import Candidate
from diagnosis.problem.blocks import fit, inflation
from scenarios.arrays import Array
from sim.effects import EFFECTS


def each_by_itself(found: Sequence[Accepted], start: Baseline, tests: Tests) -> list[Accepted]:
    """Effects, those of one gain for all motors with a gain of each, where that explains what one gain leaves.

    Nats on held-out data beyond those of what is in, over the inflation, must be as many as a name needs. Motors that
    explain nothing beside the others are left out. Of one that was found first it is asked again beside a second, in
    whose gap a motor was not seen. start : the ground without any effect.
    """
    out: list[Accepted] = []
    for i, one in enumerate(found):
        others = [*out, *found[i + 1 :]]
        alone = [each.name for each in found].count(one.name) == 1
        out += _by_itself(one, others, start, tests) if alone else [one]
    return out


def _by_itself(one: Accepted, found: Sequence[Accepted], start: Baseline, tests: Tests) -> list[Accepted]:
    """An effect beside others that were found, in as many parts as there are motors that tell."""
    problem, whole = start.problem, one.evidence
    motors, role = problem.state.motors, whole.candidate.effect.with_role("motor")
    if role is None or len(motors) < 2:
        return [one]
    others = start.with_all(other.columns(problem) for other in found)
    if tests(others.beside(one.columns(problem))).clean:
        return [one]
    parts = _parts(others, [whole.candidate.at({role: motor}) for motor in motors], whole)
    if not parts:
        return [one]
    first = replace(one, evidence=replace(parts[0], gain=whole.gain, V=whole.V))
    return [first, *(Accepted(part, ()) for part in parts[1:])]


def _parts(others: Baseline, settings: Sequence[Candidate], one: Evidence) -> list[Evidence]:
    """Each motor's evidence beside all others, the strongest first; none where they do not do better.

    Neither all together, nor those that are kept: of motors that run alike none explains anything beside the others.
    """
    policy, columns = others.problem.policy, [each.columns(others.problem) for each in settings]
    if not _do_better(others, columns, one):
        return []
    judged = (
        judged_at(others.with_all(other for other in columns if other is not own), [setting])
        for setting, own in zip(settings, columns, strict=True)
    )
    known = [each for each in judged if each is not None and each.nats > policy.apart]
    if not known or not _do_better(others, [each.candidate.columns(others.problem) for each in known], one):
        return []
    return sorted(known, key=lambda each: -each.strength)


def _do_better(others: Baseline, columns: Sequence[Array], one: Evidence) -> bool:
    """Whether columns (n, q, k) of several motors explain more than one gain by what a name needs.

    Both on held-out data: what one gain explains on all of it is less where the base is extrapolated.
    """
    joint, alone = others.joined(np.concatenate(columns, axis=2)), others.joined(one.candidate.columns(others.problem))
    V = inflation(joint, fit(joint, others.everything), others.problem.policy)
    return (others.held_gain(joint) - others.held_gain(alone)) / V > others.problem.policy.accepted(len(EFFECTS))
