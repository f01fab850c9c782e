"""Effects of several motors with different wiring: a gain for each motor, reported as one cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.decision.forms import ResidualTester
from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import Evidence, judge_settings
from diagnosis.library.candidates import Candidate
from diagnosis.problem.blocks import fit, inflation
from scenarios.arrays import Array
from sim.effects import EFFECTS


def split_by_motor(accepted: Sequence[AcceptedEffect], start: Baseline, tests: ResidualTester) -> list[AcceptedEffect]:
    """Split effects with one gain for all motors into a gain for each motor, where the residual supports it.

    The split must gain the nats for acceptance on held-out data, over the inflation. Motors explaining nothing are left
    out. An effect accepted earlier is split again once a later effect no longer hides a motor. start : the baseline
    without effects.
    """
    out: list[AcceptedEffect] = []
    for i, effect in enumerate(accepted):
        others = [*out, *accepted[i + 1 :]]
        alone = [other.name for other in accepted].count(effect.name) == 1
        out += _split(effect, others, start, tests) if alone else [effect]
    return out


def _split(
    effect: AcceptedEffect, accepted: Sequence[AcceptedEffect], start: Baseline, tests: ResidualTester
) -> list[AcceptedEffect]:
    """Split one effect next to all remaining effects into the motors supported by the data."""
    problem, whole = start.problem, effect.evidence
    motors, role = problem.state.motors, whole.candidate.effect.with_role("motor")
    if role is None or len(motors) < 2:
        return [effect]
    others = start.with_all(another.columns(problem) for another in accepted)
    if tests(others.with_columns(effect.columns(problem))).clean:
        return [effect]
    parts = _motor_evidence(others, [whole.candidate.at({role: motor}) for motor in motors], whole)
    if not parts:
        return [effect]
    first = replace(effect, evidence=replace(parts[0], gain=whole.gain, V=whole.V))
    return [first, *(AcceptedEffect(part, ()) for part in parts[1:])]


def _motor_evidence(others: Baseline, settings: Sequence[Candidate], evidence: Evidence) -> list[Evidence]:
    """Evidence of each motor next to all remaining effects, the strongest first; empty if the split gains too little.

    Both all motors and the kept ones must gain enough: of motors running alike none explains anything next to the rest.
    """
    policy, columns = others.problem.policy, [motor.columns(others.problem) for motor in settings]
    if not _explain_more(others, columns, evidence):
        return []
    judged = (
        judge_settings(others.with_all(other for other in columns if other is not own), [setting])
        for setting, own in zip(settings, columns, strict=True)
    )
    known = [motor for motor in judged if motor is not None and motor.nats > policy.apart]
    if not known or not _explain_more(others, [motor.candidate.columns(others.problem) for motor in known], evidence):
        return []
    return sorted(known, key=lambda motor: -motor.strength)


def _explain_more(others: Baseline, columns: Sequence[Array], evidence: Evidence) -> bool:
    """Whether columns (n, q, k) of several motors gain enough more on held-out data than a common gain.

    Held-out data are used for both: a common gain explains less on held-out data where the base is extrapolated.
    """
    joint, alone = (
        others.sums_with(np.concatenate(columns, axis=2)),
        others.sums_with(evidence.candidate.columns(others.problem)),
    )
    V = inflation(joint, fit(joint, others.all_folds), others.problem.policy)
    return (others.held_out_gain(joint) - others.held_out_gain(alone)) / V > others.problem.policy.accepted(
        len(EFFECTS)
    )
