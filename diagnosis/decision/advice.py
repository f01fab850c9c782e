"""Advice after a diagnosis, one line each: what to fly, log or check."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.decision.monotone_courses import driving_channels
from diagnosis.decision.remarks import reference_remarks
from diagnosis.decision.sentence import channel_curves, driver_of
from diagnosis.evidence.along_field import is_attitude_error
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.sensors import as_currents
from diagnosis.result import Diagnosis, EvidenceKind, NamedEffect, Transfer
from diagnosis.verdict import Verdict
from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from sim.effects import BY_NAME
from validation.text import digits, short

TRIED_CHANNELS = 2
"""Number of channels offered as actuators."""
VOLTAGE = re.compile(r"volt|_m?V$", re.IGNORECASE)
"""Names of voltages: of a supply that the load draws on."""


def advice_for(diagnosis: Diagnosis) -> tuple[str, ...]:
    """All applicable lines of `ADVICE`."""
    return tuple(dict.fromkeys(line for advise in ADVICE for line in advise(diagnosis)))


def try_actuator(diagnosis: Diagnosis) -> Iterator[str]:
    """A recorded channel followed by the gap more than time may drive it; a monotone one resembles any slow course."""
    if not (diagnosis.verdict.explained or channel_curves(diagnosis)):
        first = {share.channel for share in diagnosis.where[:TRIED_CHANNELS]} & _untried_channels(diagnosis)
        followed = [name for name in driving_channels(diagnosis.problem, diagnosis.where) if name in first]
        if followed:
            yield f"The gap follows {' and '.join(followed)}: try {_as_actuators(followed)}."


def _as_actuators(names: Sequence[str]) -> str:
    return " ".join(f"--actuator {name}" for name in names)


def _untried_channels(found: Diagnosis) -> set[str]:
    """Recorded channels not treated like motor currents; a position drives nothing, and a voltage sags by the load."""
    recording = found.problem.recording
    drives_nothing = {LATITUDE, LONGITUDE, ALTITUDE, *filter(VOLTAGE.search, recording.channels)}
    return set(recording.channels) - set(as_currents(recording)) - drives_nothing


def find_mechanism(diagnosis: Diagnosis) -> Iterator[str]:
    """A curve names a channel, not a mechanism."""
    curves = channel_curves(diagnosis)
    untried = [name for curve in curves if (name := driver_of(curve)) in _untried_channels(diagnosis)]
    if untried:
        options = _as_actuators(untried)
        yield f"If {' or '.join(untried)} commands a current or a coil, add {options}: the effect can then be named."
    for curve in curves:
        name, traits = driver_of(curve), curve.effect.traits
        rivals = f" A curve of {' or '.join(curve.rivals)} explains nearly as much." if curve.rivals else ""
        seen = diagnosis.problem.state.channel(name)
        known = f" The curve holds for {name} from {short(float(seen.min()))} to {short(float(seen.max()))} only."
        yield f"The curve of {name} shows no mechanism: {traits.experiment}; {traits.remedy}.{known}{rivals}"


def fly_other_motion(diagnosis: Diagnosis) -> Iterator[str]:
    """Effects absorbed by the base need another motion, unless the station is fixed."""
    if diagnosis.absorbed and diagnosis.problem.turns:
        yield (
            f"On this motion {', '.join(diagnosis.absorbed)} can hardly be distinguished from hard and soft iron, "
            "whose fit takes a part of such an effect; fly turns at different rates with changing roll and pitch "
            "(a spiral both ways, then a comb)."
        )


def separation_advice(named: Sequence[NamedEffect]) -> Iterator[str]:
    """For each named effect with look-alikes, how to distinguish them."""
    for cause in named:
        if cause.look_alikes:
            experiments = (BY_NAME[name].traits.experiment for name in (cause.name, *cause.alternatives))
            ways = dict.fromkeys(filter(None, experiments))
            yield f"{cause.name} may also be {', '.join(cause.look_alikes)}. To distinguish: {'; '.join(ways)}."


def turn_at_standstill(diagnosis: Diagnosis) -> Iterator[str]:
    """Iron or a jump during, or next to, a standstill: the field of the place has the same effect.

    At a standstill, the strength alone determines an offset only along the field.
    """
    time_s = diagnosis.problem.state.time_s
    for cause in diagnosis.named:
        moment, stretch = cause.effect.with_role("moment"), diagnosis.stretch(cause)
        if moment is not None:
            begin_s = getattr(cause.effect, moment)
            acts, when = time_s >= begin_s, f"from {digits(begin_s, 4)} s on"
        elif stretch is not None and cause.effect.traits.absorbed:
            acts, when = cause.effect.is_active(time_s), stretch.words
        else:
            continue
        if diagnosis.problem.turns and any(_is_at_rest(diagnosis.problem, part) for part in (acts, ~acts)):
            yield (
                f"{cause.name} acts {when}, and the vehicle stands still during this part or outside it: steel or a "
                "magnet near the standstill looks the same. To distinguish: turn the vehicle at this place too."
            )


def _is_at_rest(problem: LinearProblem, samples: NDArray[np.bool_]) -> bool:
    """Whether the field hardly turns in the sensor during some of the samples (n,)."""
    field_nT = problem.state.field_nT[samples]
    if not len(field_nT):
        return False
    spread_nT, mean_nT = (float(np.linalg.norm(part)) for part in (field_nT.std(axis=0), field_nT.mean(axis=0)))
    return spread_nT < problem.policy.still_spread * mean_nT


def suspect_navigation(diagnosis: Diagnosis) -> Iterator[str]:
    """An attitude error turns the field and leaves nothing along it."""
    unexplained = diagnosis.verdict in (Verdict.UNKNOWN, Verdict.PARTIAL)
    slow = is_attitude_error(diagnosis.problem, diagnosis.after_nT / diagnosis.problem.sigma_nT)
    if unexplained and (slow or _rise_is_across_field(diagnosis)):
        yield "The residual has no part along the field: check the attitude and the time stamps of the navigation."


def log_rotating_parts(diagnosis: Diagnosis) -> Iterator[str]:
    """A spectrum rising with frequency is no sensor noise: a rotating part is as fast, or the clocks are uneven.

    A rotating part has a component along the field.
    """
    if diagnosis.rise is not None and not _rise_is_across_field(diagnosis):
        yield (
            f"The residual has {diagnosis.rise.words}; sensor noise does not rise with frequency, but a wheel, a "
            "propeller or a pump gives a tone that sweeps with its speed. Switch it off for a run, or log its speed."
        )


def _rise_is_across_field(diagnosis: Diagnosis) -> bool:
    """Whether the rising part is visible sample by sample and has no component along the field."""
    problem = diagnosis.problem
    interval_s = problem.state.interval_s
    return diagnosis.rise is not None and is_attitude_error(problem, diagnosis.after_nT / problem.sigma_nT, interval_s)


def log_attitude(diagnosis: Diagnosis) -> Iterator[str]:
    """Without attitude little is observable."""
    if diagnosis.problem.mode == "strength" and not diagnosis.problem.corrections:
        bare = any(cause.kind is EvidenceKind.HELD_OUT and not cause.spread for cause in diagnosis.named)
        why = ", and parameters have no interval" if bare else ""
        if diagnosis.problem.recording.att_q is None:
            yield f"Without attitude only the field's strength was compared{why}; log attitude to see more."
        else:
            known = "Without the field's vector only the strength was compared"
            yield f"{known}{why}; give --field-enu-nT E,N,U, and the recorded attitude shows more."


def confirm_by_second_recording(diagnosis: Diagnosis) -> Iterator[str]:
    """Held-out segments share the slow noise of their recording; direct evidence needs no confirmation."""
    unconfirmed = [cause for cause in diagnosis.named if cause.kind is not EvidenceKind.DIRECT]
    alone = [cause for cause in unconfirmed if cause.transfer is Transfer.SINGLE_RUN]
    doubtful = ", ".join(cause.name for cause in alone if cause.transferable)
    if diagnosis.has_second and doubtful:
        yield (
            f"The second recording does not confirm {doubtful}: absent, of another size, or not observable. "
            "Give both recordings to magbench diagnose without --confirm to see which."
        )
    elif not diagnosis.has_second and alone and len(alone) == len(unconfirmed):
        yield "Confirm on a second recording with --confirm: all segments of one recording share its slow noise."


def log_more_channels(diagnosis: Diagnosis) -> Iterator[str]:
    """Effects that cannot be tested."""
    if diagnosis.untested:
        yield "Not tested, for lack of channels: " + ", ".join(diagnosis.untested) + "."


Advise = Callable[[Diagnosis], Iterator[str]]
ADVICE: tuple[Advise, ...] = (
    lambda diagnosis: (advice for _, advice in reference_remarks(diagnosis)),
    try_actuator,
    find_mechanism,
    fly_other_motion,
    lambda diagnosis: separation_advice(diagnosis.named),
    turn_at_standstill,
    suspect_navigation,
    log_rotating_parts,
    log_attitude,
    confirm_by_second_recording,
    log_more_channels,
)
