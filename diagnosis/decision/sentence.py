"""The sentence that summarises a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from diagnosis.decision.remarks import remarks
from diagnosis.evidence.active_parts import largest_part
from diagnosis.evidence.held_out import BEHIND, TOO_LITTLE
from diagnosis.problem.sensors import as_currents
from diagnosis.result import Diagnosis, EvidenceKind, NamedEffect, Transfer, in_use
from diagnosis.verdict import Verdict
from recordings.channels import current_name
from sim.effects.base import Effect
from sim.effects.linearisation import linearise
from sim.effects.parameters import Parameter
from sim.state import State
from validation.text import digits, figure, short

LISTED_CHANNELS = 3
"""Number of channels listed in a sentence."""


def sentence_for(diagnosis: Diagnosis) -> str:
    """Summarise a diagnosis in one sentence for a field engineer, after the remarks and before iron that is new."""
    wrong = [diagnosis.correction_of(cause) is not None for cause in diagnosis.named]
    told = diagnosis.verdict.sentence(
        lacks="Wrong in the model" if wrong and all(wrong) else f"Missing{' or wrong' * any(wrong)} in the model",
        causes="; ".join(_described(diagnosis, cause) for cause in diagnosis.named),
        share=_share(diagnosis),
        left=_left(diagnosis),
        nearest=_nearest(diagnosis),
        goes_with=_course(diagnosis),
    )
    if diagnosis.iron_anew and diagnosis.resimulated_nT is not None:
        told += (
            " The new model has hard and soft iron fitted to this recording, beside which the effects were found; run "
            f"by the simulator it leaves {digits(diagnosis.resimulated_nT)} nT."
        )
    return " ".join([*remarks(diagnosis), told])


def _left(diagnosis: Diagnosis) -> str:
    """What is not explained; of a part the structure in nT too, where the residual has one."""
    left = "; ".join(diagnosis.unexplained or diagnosis.doubts)
    sized = diagnosis.verdict is Verdict.PARTIAL and (diagnosis.after.why or diagnosis.rise)
    return f"{digits(diagnosis.gap.structure_nT[1])} nT: {left}" if sized else left


def _described(diagnosis: Diagnosis, cause: NamedEffect) -> str:
    """A named effect; one that the model states by its corrected parameters and those stated."""
    logged = {current: channel for channel, current in as_currents(diagnosis.problem.recording).items()}
    when, motion, stated = _when_active(diagnosis, cause), diagnosis.problem.state, ""
    second = f", {'' if cause.transfer is Transfer.TRANSFERRED else 'not '}confirmed by the second recording"
    if (both := diagnosis.correction_of(cause)) is not None:
        given, new = both
        differing = [p for p in in_use(new) if getattr(given, p.name) != getattr(new, p.name)]
        further = [_value(new, p) for p in differing if p is not main_parameter(new)]
        cause, stated = replace(cause, effect=new), f" (stated: {', '.join(_value(given, p) for p in differing)})"
        stated = ", ".join(["", *further]) + stated
    told = describe_effect(cause, when, logged, motion) + stated
    return told + second if diagnosis.has_second and cause.transferable else told


def _value(effect: Effect, p: Parameter) -> str:
    """ "lag_s 0.5 s"."""
    return f"{p.name} {short(np.asarray(getattr(effect, p.name)).tolist())} {p.unit}".rstrip()


def _share(diagnosis: Diagnosis) -> str:
    gap = diagnosis.gap
    if gap.explained is None or not diagnosis.of_kind(EvidenceKind.HELD_OUT):
        return ""
    amount = f"the gap of {digits(gap.structure_nT[0])} nT beyond {digits(gap.noise_nT)} nT of noise"
    return f"; {100 * max(gap.explained, 0.0):.0f} % of {amount} explained on held-out data"


def _course(diagnosis: Diagnosis) -> str:
    """Channels of curves with the explained share, else those that the gap follows, and when the gap is largest."""
    curves = [driver_of(curve) for curve in diagnosis.of_kind(EvidenceKind.CURVE)]
    followed = [share.channel for share in diagnosis.where[:LISTED_CHANNELS]]
    told = f"; the gap follows {', '.join(followed)}" if followed else ""
    if curves:
        explain = f"curves of {', '.join(curves)} explain" if len(curves) > 1 else f"a curve of {curves[0]} explains"
        told = f"; {explain} {diagnosis.gap.explained or 0.0:.0%} of the gap on held-out data"
    part = largest_part(diagnosis.parts, diagnosis.problem.policy)
    return f"{told}; the gap is largest {part.words}: {digits(part.rms_nT)} nT rms" if part else told


def _nearest(diagnosis: Diagnosis) -> str:
    """The best refused candidate with any evidence, and the reason; BEHIND was not tested with its own noise model."""
    if not diagnosis.ranking or diagnosis.ranking[0].nats <= diagnosis.problem.policy.apart:
        return ""
    best = diagnosis.ranking[0]
    if best.outcome == BEHIND:
        return f"; the nearest candidate is {best.name}, which explains less of the gap than the candidates refused"
    why = "" if best.outcome == TOO_LITTLE else f" ({best.outcome})"
    return f"; the nearest candidate is {best.name}, {digits(best.nats)} of {digits(best.needed)} nats needed{why}"


def driver_of(curve: NamedEffect) -> str:
    """Name of the channel of a curve."""
    return curve.effect.required_inputs[-1]


def _when_active(diagnosis: Diagnosis, cause: NamedEffect) -> str:
    """The time at which a named effect acts, a period within the run, or of two effects of a name the lasting one."""
    stretch, period = diagnosis.stretch(cause), cause.effect.with_role("period")
    if stretch is not None:
        return f" {stretch.words}"
    if period is not None and getattr(cause.effect, period) < np.ptp(diagnosis.problem.state.time_s):
        return f" every {digits(getattr(cause.effect, period), 4)} s"
    return " throughout the run" if sum(another.name == cause.name for another in diagnosis.named) > 1 else ""


def describe_effect(
    cause: NamedEffect, when: str = "", logged: Mapping[str, str] | None = None, motion: State | None = None
) -> str:
    """Describe an effect: look-alikes, driving channels, time of action, main parameter and size.

    when : in words, for an effect without moments of its own. logged : channels by the name of the motor current that
    they stand for. motion : for a curve, defines the mean slope to be stated.
    """
    either = f" (or {', '.join(cause.look_alikes)})" if cause.look_alikes else ""
    if (moment := cause.effect.with_role("moment")) is not None:
        parts = filter(lambda part: part.name == cause.name, cause.effects)
        when = " at " + " and ".join(f"{digits(getattr(part, moment), 4)} s" for part in parts)
    parameter = main_parameter(cause.effect)
    straight = cause.effect if motion is None else linearise(cause.effect, motion)
    value = short(np.asarray(getattr(straight, parameter.name), dtype=float).tolist())
    driver, whose = _drivers(cause, logged or {})
    unit = parameter.unit.replace("/A", " per unit") if driver else parameter.unit
    average = " on average" if straight is not cause.effect else ""
    size = f", {figure(cause.strength, 2)} times the noise" if cause.strength else ""
    return f"{cause.name}{either}{driver}{when}: {parameter.name}{whose} {value} {unit}".rstrip() + average + size


def _drivers(cause: NamedEffect, logged: Mapping[str, str]) -> tuple[str, str]:
    """The channels followed by an effect of motors, and the motor whose gain is stated."""
    role = cause.effect.with_role("motor")
    if role is None:
        return "", ""
    motors = [getattr(each, role) for each in cause.effects if each.name == cause.name]
    currents = [current_name(motor) for motor in motors if motor]
    followed = [channel for current, channel in logged.items() if 0 in motors or current in currents]
    driver = f" of {', '.join(followed)}" if followed else ""
    several = len(set(motors)) > 1 and motors[0] != 0
    return driver, f" of {logged.get(currents[0], currents[0])}" if several else ""


def main_parameter(effect: Effect) -> Parameter:
    """The parameter that gives the size of an effect."""
    return next(p for p in effect.parameters() if (p.name in effect.linear if effect.linear else not p.worded))
