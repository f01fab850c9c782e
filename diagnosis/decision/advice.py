"""What to do next about a diagnosis, a line each: fly, log or check."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.decision.remarks import long_climb, long_track
from diagnosis.decision.sentence import curves_of
from diagnosis.evidence.slow_noise import turns_the_field
from diagnosis.problem.actuators import as_currents
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis, How, Named, Transfer
from diagnosis.verdict import Verdict
from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from sim.effects import BY_NAME
from validation.text import digits, short

TRIED_CHANNELS = 2
"""Channels that are offered as actuators."""


def advice_for(found: Diagnosis) -> tuple[str, ...]:
    """What to do next: every line of `ADVICE` that applies."""
    return tuple(dict.fromkeys(line for advise in ADVICE for line in advise(found)))


def mend_the_reference(found: Diagnosis) -> Iterator[str]:
    """A field that was misread, a heading that hides the errors of the magnetometer that it was made from."""
    yield from (one.figures for one in found.problem.instead)


def follow_the_track(found: Diagnosis) -> Iterator[str]:
    """A field that changes along a long track is no effect: latitude and longitude tell it."""
    if any(long_track(found)):
        yield (
            f"Give the log's place, --map {LATITUDE}=COLUMN --map {LONGITUDE}=COLUMN: the field then changes along "
            "the track as IGRF says. A gradient that is named without it may be no more than that."
        )


def follow_the_height(found: Diagnosis) -> Iterator[str]:
    """A field that falls with height is no effect: the place and the altitude tell it."""
    if any(long_climb(found)):
        yield (
            f"Give the model's [field] by {LATITUDE}, {LONGITUDE} and date, and the log's height, --map "
            f"{ALTITUDE}=COLUMN: the field then changes with height as IGRF says. What is named without it, and rises "
            "or falls with height, may be no more than that."
        )


def try_an_actuator(found: Diagnosis) -> Iterator[str]:
    """A recorded channel that the gap goes with may be what drives it."""
    goes_with = [one.channel for one in found.where[:TRIED_CHANNELS] if one.channel in _untried(found)]
    if goes_with and not found.verdict.explained and not curves_of(found):
        options = " ".join(f"--actuator {name}" for name in goes_with)
        yield f"The gap goes with {' and '.join(goes_with)}: try {options}."


def _untried(found: Diagnosis) -> set[str]:
    """Recorded channels that are not treated like motor currents; a place drives nothing."""
    recording = found.problem.recording
    return set(recording.channels) - set(as_currents(recording)) - {LATITUDE, LONGITUDE, ALTITUDE}


def seek_the_mechanism(found: Diagnosis) -> Iterator[str]:
    """A curve names a channel; what it drives is for people to find, or to say where it commands a current."""
    untried = [channel for one in curves_of(found) if (channel := one.effect.required_inputs[-1]) in _untried(found)]
    if untried:
        options = " ".join(f"--actuator {channel}" for channel in untried)
        yield f"Where {' or '.join(untried)} commands a current or a coil, say so: {options}. It can then be named."
    for one in curves_of(found):
        channel, traits = one.effect.required_inputs[-1], one.effect.traits
        rivals = f" A curve of {' or '.join(one.rivals)} does nearly as well." if one.rivals else ""
        seen = found.problem.state.channel(channel)
        known = f" It is known for {channel} from {short(float(seen.min()))} to {short(float(seen.max()))} alone."
        yield f"The curve of {channel} tells no mechanism: {traits.experiment}; {traits.remedy}.{known}{rivals}"


def fly_another_motion(found: Diagnosis) -> Iterator[str]:
    """Effects that the base takes up need another motion; a fixed station has none."""
    if found.absorbed and found.problem.turns:
        yield (
            f"On this motion {', '.join(found.absorbed)} can hardly be told from hard and soft iron, which they bias; "
            "fly turns at different rates and with changing roll and pitch (a spiral both ways, then a comb)."
        )


def tell_look_alikes_apart(found: Diagnosis) -> Iterator[str]:
    """Each kind of look-alikes has its own test."""
    yield from ways_to_tell(found.named)


def ways_to_tell(named: Sequence[Named]) -> Iterator[str]:
    """For each name with look-alikes what to do that tells them apart."""
    for one in named:
        if one.others:
            ways = dict.fromkeys(
                filter(None, (BY_NAME[name].traits.experiment for name in (one.name, *one.alternatives)))
            )
            yield f"{one.name} may also be {', '.join(one.others)}. To tell: {'; '.join(ways)}."


def turn_where_it_stood(found: Diagnosis) -> Iterator[str]:
    """Iron or a jump in a part of the run, in which or beside which the vehicle stands: so is the field of that place.

    Of a vehicle that stands the strength alone tells nothing of an offset but its part along the field.
    """
    time_s = found.problem.state.time_s
    for one in found.named:
        moment, stretch = one.effect.with_role("moment"), found.stretch(one)
        if moment is not None:
            begin_s = getattr(one.effect, moment)
            acts, when = time_s >= begin_s, f"from {digits(begin_s, 4)} s on"
        elif stretch is not None and one.effect.traits.absorbed:
            acts, when = one.effect.is_active(time_s), stretch.words
        else:
            continue
        if found.problem.turns and (_stands(found.problem, acts) or _stands(found.problem, ~acts)):
            yield (
                f"{one.name} acts {when}, and in that part or beside it the vehicle stands: the field of the "
                "place where it stood, of steel or a magnet near by, looks the same. To tell: turn it there too."
            )


def _stands(problem: LinearProblem, samples: NDArray[np.bool_]) -> bool:
    """Whether the field hardly turns in the sensor at some of the samples (n,)."""
    if not samples.any():
        return False
    field_nT = problem.state.field_nT[samples]
    spread_nT = float(np.linalg.norm(field_nT.std(axis=0)))
    return spread_nT < problem.policy.still_spread * float(np.linalg.norm(field_nT.mean(axis=0)))


def suspect_navigation(found: Diagnosis) -> Iterator[str]:
    """An error of the attitude turns the field, and leaves nothing along it."""
    unexplained = found.verdict in (Verdict.UNKNOWN, Verdict.PARTIAL)
    slow = turns_the_field(found.problem, found.after_nT / found.problem.sigma_nT)
    if unexplained and (slow or _rise_turns_the_field(found)):
        yield "What is left has no part along the field: suspect navigation's attitude or time stamps."


def log_what_turns(found: Diagnosis) -> Iterator[str]:
    """No noise of a sensor rises with frequency: something in the vehicle is as fast as that, or the clocks are uneven.

    What the vehicle turns has a part along the field.
    """
    if found.rise is not None and not _rise_turns_the_field(found):
        yield (
            f"There is {found.rise.words}, and a sensor's noise does not rise with frequency: a wheel, a propeller or "
            "a pump gives a tone that sweeps with its speed. Switch it off for a run, or add its speed to the log."
        )


def _rise_turns_the_field(found: Diagnosis) -> bool:
    """Whether what rises with frequency is so large that it shows sample by sample, and has nothing along the field."""
    problem = found.problem
    each_s = problem.state.interval_s
    return found.rise is not None and turns_the_field(problem, found.after_nT / problem.sigma_nT, each_s)


def log_attitude(found: Diagnosis) -> Iterator[str]:
    """Without attitude little is observable."""
    if found.problem.mode == "strength" and not found.problem.instead:
        bare = any(one.how is How.HELD_OUT and not one.spread for one in found.named)
        why = ", so that parameters have no interval" if bare else ""
        yield f"Without attitude only the field's strength was compared{why}; log attitude to see more."


def confirm(found: Diagnosis) -> Iterator[str]:
    """One recording shares its slow noise with its held-out segments; what the values show needs no other."""
    if found.second:
        yield from _not_borne_out(found)
        return
    asked = [one for one in found.named if one.how is not How.DIRECT]
    if asked and all(one.evidence is Transfer.SINGLE_RUN for one in asked):
        yield "Confirm on a second recording with --confirm: held-out segments of one run share its slow noise."


def _not_borne_out(found: Diagnosis) -> Iterator[str]:
    several = [one.name for one in found.named if one.askable and one.evidence is Transfer.SINGLE_RUN]
    if several:
        yield (
            f"The second recording does not bear out {', '.join(several)}: not there, of another size, or not to be "
            "told there. Give both to magbench diagnose, without --confirm: it says which."
        )


def log_more_channels(found: Diagnosis) -> Iterator[str]:
    """What cannot be tested."""
    if found.untested:
        yield "Not tested for want of channels: " + ", ".join(found.untested) + "."


Advise = Callable[[Diagnosis], Iterator[str]]
ADVICE: tuple[Advise, ...] = (
    mend_the_reference,
    follow_the_track,
    follow_the_height,
    try_an_actuator,
    seek_the_mechanism,
    fly_another_motion,
    tell_look_alikes_apart,
    turn_where_it_stood,
    suspect_navigation,
    log_what_turns,
    log_attitude,
    confirm,
    log_more_channels,
)
