"""Advice after a diagnosis, one line each: what to fly, log or check."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.decision.monotone_courses import driving_channels
from diagnosis.decision.remarks import reference_remarks
from diagnosis.decision.sentence import driver_of
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
    """All applicable advice, each line once."""
    lines = [advice for _, advice in reference_remarks(diagnosis)]
    for advise in (actuator_advice, motion_advice, navigation_advice, reference_advice, recording_advice):
        lines += advise(diagnosis)
    return tuple(dict.fromkeys(lines))


def actuator_advice(diagnosis: Diagnosis) -> Iterator[str]:
    """A recorded channel that the gap follows more than time may drive it, and a curve names no mechanism.

    A monotone channel resembles any slow course, a position drives nothing, and a voltage sags by the load.
    """
    problem, curves = diagnosis.problem, diagnosis.of_kind(EvidenceKind.CURVE)
    channels = problem.recording.channels
    drives_nothing = {LATITUDE, LONGITUDE, ALTITUDE, *filter(VOLTAGE.search, channels)}
    untried = set(channels) - set(as_currents(problem.recording)) - drives_nothing
    if not (diagnosis.verdict.explained or curves):
        first = {share.channel for share in diagnosis.where[:TRIED_CHANNELS]} & untried
        followed = [name for name in driving_channels(problem, diagnosis.where) if name in first]
        if followed:
            yield f"The gap follows {' and '.join(followed)}: try {_as_actuators(followed)}."
    if open_ := [name for curve in curves if (name := driver_of(curve)) in untried]:
        options = _as_actuators(open_)
        yield f"If {' or '.join(open_)} commands a current or a coil, add {options}: the effect can then be named."
    for curve in curves:
        name, traits = driver_of(curve), curve.effect.traits
        rivals = f" A curve of {' or '.join(curve.rivals)} explains nearly as much." if curve.rivals else ""
        seen = problem.state.channel(name)
        known = f" The curve holds for {name} from {short(float(seen.min()))} to {short(float(seen.max()))} only."
        yield f"The curve of {name} shows no mechanism: {traits.experiment}; {traits.remedy}.{known}{rivals}"


def _as_actuators(names: Sequence[str]) -> str:
    return " ".join(f"--actuator {name}" for name in names)


def motion_advice(diagnosis: Diagnosis) -> Iterator[str]:
    """Effects absorbed by the base need another motion, unless the station is fixed; look-alikes an experiment.

    Iron or a jump during, or next to, a standstill has the effect of the field of the place; at a standstill, the
    strength alone determines an offset only along the field.
    """
    problem, time_s = diagnosis.problem, diagnosis.problem.state.time_s
    if diagnosis.absorbed and problem.turns:
        yield (
            f"On this motion {', '.join(diagnosis.absorbed)} can hardly be distinguished from hard and soft iron, "
            "whose fit takes a part of such an effect; fly turns at different rates with changing roll and pitch "
            "(a spiral both ways, then a comb)."
        )
    yield from separation_advice(diagnosis.named)
    for cause in diagnosis.named:
        moment, stretch = cause.effect.with_role("moment"), diagnosis.stretch(cause)
        if moment is not None:
            begin_s = getattr(cause.effect, moment)
            acts, when = time_s >= begin_s, f"from {digits(begin_s, 4)} s on"
        elif stretch is not None and cause.effect.traits.absorbed:
            acts, when = cause.effect.is_active(time_s), stretch.words
        else:
            continue
        if problem.turns and any(_is_at_rest(problem, part) for part in (acts, ~acts)):
            yield (
                f"{cause.name} acts {when}, and the vehicle stands still during this part or outside it: steel or a "
                "magnet near the standstill looks the same. To distinguish: turn the vehicle at this place too."
            )


def separation_advice(named: Sequence[NamedEffect]) -> Iterator[str]:
    """For each named effect with look-alikes, how to distinguish them."""
    for cause in named:
        if cause.look_alikes:
            experiments = (BY_NAME[name].traits.experiment for name in (cause.name, *cause.alternatives))
            ways = dict.fromkeys(filter(None, experiments))
            yield f"{cause.name} may also be {', '.join(cause.look_alikes)}. To distinguish: {'; '.join(ways)}."


def _is_at_rest(problem: LinearProblem, samples: NDArray[np.bool_]) -> bool:
    """Whether the field hardly turns in the sensor during some of the samples (n,)."""
    field_nT = problem.state.field_nT[samples]
    if not len(field_nT):
        return False
    spread_nT, mean_nT = (float(np.linalg.norm(part)) for part in (field_nT.std(axis=0), field_nT.mean(axis=0)))
    return spread_nT < problem.policy.still_spread * mean_nT


def navigation_advice(diagnosis: Diagnosis) -> Iterator[str]:
    """An attitude error leaves nothing along the field, and a spectrum rising with frequency is no sensor noise."""
    problem, rise = diagnosis.problem, diagnosis.rise
    fast = rise is not None and is_attitude_error(problem, diagnosis.residual, problem.state.interval_s)
    unexplained = diagnosis.verdict in (Verdict.UNKNOWN, Verdict.PARTIAL)
    if unexplained and (fast or is_attitude_error(problem, diagnosis.residual)):
        yield "The residual has no part along the field: check the attitude and the time stamps of the navigation."
    if rise is not None and not fast:
        yield (
            f"The residual has {rise.words}; sensor noise does not rise with frequency, but a wheel, a propeller or a "
            "pump gives a tone that sweeps with its speed. Switch it off for a run, or log its speed."
        )


def reference_advice(diagnosis: Diagnosis) -> Iterator[str]:
    """Without attitude, or without the field's vector, little is observable."""
    problem = diagnosis.problem
    if problem.mode == "strength" and not problem.corrections:
        bare = any(not cause.spread for cause in diagnosis.of_kind(EvidenceKind.HELD_OUT))
        lacks, more = "the field's vector only the", "give --field-enu-nT E,N,U, and the recorded attitude shows more"
        if problem.recording.att_q is None:
            lacks, more = "attitude only the field's", "log attitude to see more"
        yield f"Without {lacks} strength was compared{', and parameters have no interval' * bare}; {more}."


def recording_advice(diagnosis: Diagnosis) -> Iterator[str]:
    """A second recording to confirm by, which direct evidence does not need, and missing channels."""
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
    if diagnosis.untested:
        yield "Not tested, for lack of channels: " + ", ".join(diagnosis.untested) + "."
