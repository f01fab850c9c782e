"""A diagnosis in one sentence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from diagnosis.decision.remarks import remarks
from diagnosis.evidence.active_parts import largest
from diagnosis.evidence.candidate_result import TOO_LITTLE
from diagnosis.problem.actuators import as_currents
from diagnosis.result import Diagnosis, How, Named, Transfer
from recordings.channels import current_name
from sim.effects.base import Effect
from sim.effects.linearisation import linearise
from sim.state import State
from validation.text import digits, short

LISTED_CHANNELS = 3
"""Channels that a sentence lists."""


def sentence_for(found: Diagnosis) -> str:
    """The finding in one sentence for a field engineer."""
    channels = ", ".join(one.channel for one in found.where[:LISTED_CHANNELS])
    said = found.verdict.sentence(
        causes="; ".join(
            words_of(one, _acts(found, one), _logged_as(found), found.problem.state) + _again(found, one)
            for one in found.named
        ),
        share=_share(found),
        left="; ".join(found.left or found.doubts),
        nearest=_nearest(found),
        goes_with=(_curves(found) or (f"; it goes with {channels}" if channels else "")) + _largest(found),
    )
    return " ".join([*remarks(found), said])


def _again(found: Diagnosis, one: Named) -> str:
    """What a second recording says of a name, where one was asked."""
    if not (found.second and one.askable):
        return ""
    return f", {'' if one.evidence is Transfer.TRANSFERRED else 'not '}borne out by the second recording"


def _share(found: Diagnosis) -> str:
    gap = found.gap
    if gap.explained is None or all(one.how is not How.HELD_OUT for one in found.named):
        return ""
    amount = f"{digits(gap.structure_nT[0])} nT of structure in {digits(gap.noise_nT)} nT of noise"
    return f"; of {amount} {100 * max(gap.explained, 0.0):.0f} % is gone on held-out data"


def _largest(found: Diagnosis) -> str:
    """From when to when the gap is large."""
    part = largest(found.parts, found.problem.policy)
    if part is None:
        return ""
    return f"; it is largest {part.stretch.words}: {digits(part.rms_nT)} nT rms"


def _nearest(found: Diagnosis) -> str:
    """The best candidate that is no name, where it has evidence at all."""
    if not found.ranking or found.ranking[0].nats <= found.problem.policy.apart:
        return ""
    best = found.ranking[0]
    why = "" if best.outcome == TOO_LITTLE else f" ({best.outcome})"
    return f"; nearest is {best.name}, {digits(best.nats)} nats where {digits(best.needed)} are needed{why}"


def curves_of(found: Diagnosis) -> list[Named]:
    """The curves of channels that stand where no effect of the library does."""
    return [one for one in found.named if one.how is How.CURVE]


def _curves(found: Diagnosis) -> str:
    """The channels whose curves stand, and how much they explain together."""
    several = curves_of(found)
    if not several:
        return ""
    share, names = f"{found.gap.explained or 0.0:.0%} of it on held-out data", ", ".join(map(_channel, several))
    return f"; curves of {names} explain {share}" if len(several) > 1 else f"; a curve of {names} explains {share}"


def _channel(one: Named) -> str:
    return one.effect.required_inputs[-1]


def _logged_as(found: Diagnosis) -> dict[str, str]:
    """Channels that are treated like motor currents, by the current's name."""
    return {current: channel for channel, current in as_currents(found.problem.recording).items()}


def _acts(found: Diagnosis, one: Named) -> str:
    """When a named effect acts, in words; of two of a name it is said of the one that acts all along too.

    A period is told that is shorter than the run.
    """
    stretch, period = found.stretch(one), one.effect.with_role("period")
    if stretch is not None:
        return f" {stretch.words}"
    if period is not None and getattr(one.effect, period) < np.ptp(found.problem.state.time_s):
        return f" every {digits(getattr(one.effect, period), 4)} s"
    return " in the whole run" if sum(other.name == one.name for other in found.named) > 1 else ""


def words_of(one: Named, when: str = "", logged: Mapping[str, str] | None = None, along: State | None = None) -> str:
    """A name with its look-alikes, what drives it, when it acts, its main parameter and its size.

    when : in words; logged : channels by the name of the motor current that they stand for. along : the motion, of
    whose course a bent line is told by its mean slope.
    """
    either = f" (or {', '.join(one.others)})" if one.others else ""
    when = _at_moments(one) or when
    parameter = next(p for p in one.effect.parameters() if p.name == main_parameter(one.effect))
    straight = one.effect if along is None else linearise(one.effect, along)
    value = short(np.asarray(getattr(straight, parameter.name), dtype=float).tolist())
    driver, whose = _driven_by(one, logged or {})
    unit = parameter.unit.replace("/A", " a unit") if driver else parameter.unit
    size = (" in the mean" if straight is not one.effect else "") + (
        f", {one.strength:.2g} sigma" if one.strength else ""
    )
    return f"{one.name}{either}{driver}{when}: {parameter.name}{whose} {value} {unit}".rstrip() + size


def _at_moments(one: Named) -> str:
    """When an event was, in words; nothing of what is none."""
    if (moment := one.effect.with_role("moment")) is None:
        return ""
    moments = [getattr(each, moment) for each in one.effects if each.name == one.name]
    return " at " + " and ".join(f"{digits(time_s, 4)} s" for time_s in moments)


def _driven_by(one: Named, logged: Mapping[str, str]) -> tuple[str, str]:
    """The channels that an effect of motors follows, and of several motors the one whose gain is told."""
    role = one.effect.with_role("motor")
    if role is None:
        return "", ""
    motors = [getattr(each, role) for each in one.effects if each.name == one.name]
    currents = [current_name(motor) for motor in motors if motor]
    followed = [channel for current, channel in logged.items() if 0 in motors or current in currents]
    driver = f" of {', '.join(followed)}" if followed else ""
    several = len(set(motors)) > 1 and motors[0] != 0
    return driver, f" of {logged.get(currents[0], currents[0])}" if several else ""


def main_parameter(effect: Effect) -> str:
    """The parameter that says how large an effect is."""
    names: Sequence[str] = effect.linear or [p.name for p in effect.parameters() if not p.worded]
    return names[0]
