"""What several recordings say together, in one sentence, and what to do next."""

from __future__ import annotations

from collections.abc import Iterator

from validation.diagnosis.decision.wording import LISTED_CHANNELS, ways_to_tell, words_of
from validation.diagnosis.result import How, Reach
from validation.diagnosis.together.common import Common
from validation.diagnosis.together.reach import There
from validation.diagnosis.together.result import Together


def sentence_together(found: Together) -> str:
    """The finding in one sentence for a field engineer."""
    explained = found.gap.explained
    seen = explained is not None and any(one.named.how is How.HELD_OUT for one in found.common)
    channels = ", ".join(one.channel for one in found.where[:LISTED_CHANNELS])
    return found.verdict.sentence(
        causes="; ".join(f"{words_of(one.named)}, {reach_of(one)}" for one in found.common),
        share=f" ({100 * (explained or 0.0):.0f} % of the gap, each recording by the coefficients of the others)"
        if seen
        else "",
        left="; ".join(found.left),
        nearest="",
        goes_with=f"; it goes with {channels}" if channels else "",
    )


def reach_of(one: Common) -> str:
    """How far an effect reaches, in words."""
    n, with_it = len(one.there), sum(there is There.PRESENT for there in one.there)
    if one.reach is Reach.TRANSFERRED:
        return f"the same in all {n} recordings"
    if one.reach is Reach.NOT_TRANSFERRED:
        return "of another size from recording to recording"
    return f"in {with_it} of {n} recordings"


def advice_together(found: Together) -> tuple[str, ...]:
    """What to do next with the lot, then what every recording's own diagnosis advises."""
    shared = [line for line in found.each[0].advice if all(line in other.advice for other in found.each[1:])]
    own = [*_of_differences(found), *_of_one_alone(found), *ways_to_tell([one.named for one in found.common])]
    told = {one.name for one in found.common}
    others = [line for line in shared if "--confirm" not in line and not any(line.startswith(name) for name in told)]
    return tuple(dict.fromkeys([*own, *others]))


def _of_differences(found: Together) -> Iterator[str]:
    for one in found.common:
        if one.reach is Reach.NOT_TRANSFERRED:
            yield (
                f"{one.name} does not transfer: its size differs between the recordings. Ask what was changed between "
                "them (mount, load, power, settings), and calibrate each state by itself."
            )
        if one.reach is Reach.SOME:
            without = [name for name, there in zip(found.names, one.there, strict=True) if there is There.ABSENT]
            if without:
                yield f"{one.name} is not in {', '.join(without)}: ask what was on or mounted in the others only."


def _of_one_alone(found: Together) -> Iterator[str]:
    for one in found.single:
        against = [name for name, there in zip(found.names, one.there, strict=True) if there is There.ABSENT]
        why = f"{', '.join(against)} speak against it" if against else "the others cannot tell"
        yield f"{one.name} is named by one recording alone and {why}: it is no finding of the lot."
