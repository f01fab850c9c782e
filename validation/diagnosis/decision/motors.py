"""A cause of several motors whose wires run differently: each motor with a gain of its own, and still one name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sim.effects import EFFECTS
from sim.state import Array
from validation.diagnosis.decision.choice import Accepted
from validation.diagnosis.decision.forms import Tests
from validation.diagnosis.evidence.compare import Evidence, judged_at
from validation.diagnosis.evidence.ground import Ground
from validation.diagnosis.library.candidates import Candidate
from validation.diagnosis.problem.blocks import fit, inflation


def each_by_itself(found: Sequence[Accepted], start: Ground, tests: Tests) -> list[Accepted]:
    """Effects, the last with a gain of each motor, where that explains what one gain of all leaves.

    Nats on held-out data beyond those of what is in, over the inflation, must be as many as a name needs. Motors that
    explain nothing beside the others are left out. start : the ground without any effect.
    """
    problem, one = start.problem, found[-1].evidence
    motors, role = problem.state.motors, one.candidate.effect.with_role("motor")
    if role is None or len(motors) < 2 or tests(start.with_all(each.columns(problem) for each in found)).clean:
        return list(found)
    others = start.with_all(before.columns(problem) for before in found[:-1])
    parts = _parts(others, [one.candidate.at({role: motor}) for motor in motors], one)
    if not parts:
        return list(found)
    first = replace(found[-1], evidence=replace(parts[0], gain=one.gain, V=one.V))
    return [*found[:-1], first, *(Accepted(part, ()) for part in parts[1:])]


def _parts(others: Ground, settings: Sequence[Candidate], one: Evidence) -> list[Evidence]:
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


def _do_better(others: Ground, columns: Sequence[Array], one: Evidence) -> bool:
    """Whether columns (n, q, k) of several motors explain more than one gain by what a name needs."""
    before, joint = judged_at(others, [one.candidate]), others.joined(np.concatenate(columns, axis=2))
    V = inflation(joint, fit(joint, others.everything), others.problem.policy)
    gained = others.evidence_in(joint) - (0.0 if before is None else before.gain / V)
    return gained > others.problem.policy.accepted(len(EFFECTS))
