"""What several recordings say together, in one sentence, and what to do next."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from diagnosis.decision.advice import ways_to_tell
from diagnosis.decision.sentence import LISTED_CHANNELS, words_of
from diagnosis.result import NORMAL_95, Diagnosis, How, Transfer
from diagnosis.several.common_effects import Common, main_size
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.scope import RECORDINGS, Scope
from diagnosis.several.transfer import There
from diagnosis.verdict import Verdict
from validation.text import all_of, figure


def sentence_together(found: PooledDiagnosis) -> str:
    """The finding in one sentence for a field engineer."""
    explained = found.gap.explained
    seen = explained is not None and any(one.named.how is How.HELD_OUT for one in found.common)
    channels = ", ".join(one.channel for one in found.where[:LISTED_CHANNELS])
    return found.verdict.sentence(
        causes="; ".join(f"{words_of(one.named)}, {reach_of(one)}" for one in found.common),
        share=_share(found) if seen else "",
        left="; ".join(found.left),
        nearest="",
        goes_with=f"; it goes with {channels}" if channels else "",
    )


def _share(found: PooledDiagnosis) -> str:
    fitted = [one for one in found.common if one.named.how is How.HELD_OUT]
    own = all(one.reach is Transfer.NOT_TRANSFERRED for one in fitted)
    whose = "its own coefficients" if own else "the others' coefficients"
    return f"; in each recording {whose} explain {100 * (found.gap.explained or 0.0):.0f} % of the gap"


def reach_of(one: Common, among: Scope = RECORDINGS) -> str:
    """How far an effect reaches, in words."""
    n, with_it = len(one.there), sum(there is There.PRESENT for there in one.there)
    if one.reach is Transfer.TRANSFERRED:
        return f"the same in {all_of(n, among.key)}"
    if one.reach is Transfer.NOT_TRANSFERRED:
        return f"of another size from {among.one} to {among.one}"
    return f"in {with_it} of {n} {among.key}"


def advice_together(found: PooledDiagnosis) -> tuple[str, ...]:
    """What to do next with the lot, then what every recording's own diagnosis advises."""
    shared = [line for line in found.each[0].advice if all(line in other.advice for other in found.each[1:])]
    own = [*_of_differences(found), *_of_one_alone(found), *ways_to_tell([one.named for one in found.common])]
    told = {one.name for one in found.common}
    others = [line for line in shared if "--confirm" not in line and not any(line.startswith(name) for name in told)]
    return tuple(dict.fromkeys([*own, *others]))


def _of_differences(found: PooledDiagnosis) -> Iterator[str]:
    for one in found.common:
        if one.reach is Transfer.NOT_TRANSFERRED:
            yield (
                f"{one.name} does not transfer{_odd_one(found, one)}. Ask what was changed between the recordings "
                "(mount, load, power, settings), and calibrate each state by itself."
            )
        if one.reach is Transfer.SOME:
            without = [name for name, there in zip(found.names, one.there, strict=True) if there is There.ABSENT]
            if without:
                yield f"{one.name} is not in {', '.join(without)}: ask what was on or mounted in the others only."


def _odd_one(found: PooledDiagnosis, one: Common) -> str:
    """The recording that differs most from all others, and by what factor."""
    known = [(name, *ratio) for name, ratio in zip(found.names, one.ratios, strict=False) if ratio is not None]
    if not known:
        return ""
    name, ratio, std = max(known, key=lambda each: abs(each[1] - 1) / each[2])
    return f": {name} has {figure(ratio)} times the size that the others have (+-{figure(NORMAL_95 * std, 1)})"


def sentence_of_array(found: PooledDiagnosis) -> str:
    """What the worst sensor says, how many others say what, and how far its names reach."""
    assert found.first is not None
    count = Counter(str(one.verdict) for one in found.each)
    verdicts = ", ".join(f"{many} {word}" for word, many in count.items())
    reaches = "".join(f" {one.name} is {reach_of(one, found.among)}." for one in found.common)
    if len(count) == 1 and found.verdict is Verdict.NONE:
        return f"{all_of(len(found.each), found.among.key).capitalize()}: {found.each[0].sentence}"
    return f"{found.names[found.first]}, of {len(found.each)} sensors ({verdicts}): {_own(found).sentence}{reaches}"


def _own(found: PooledDiagnosis) -> Diagnosis:
    """The diagnosis in the headline."""
    return found.each[found.first or 0]


def advice_of_array(found: PooledDiagnosis) -> tuple[str, ...]:
    """Whether a source is near or far, then what the worst sensor's own diagnosis advises."""
    return tuple(dict.fromkeys([*_near_or_far(found), *_own(found).advice]))


def _near_or_far(found: PooledDiagnosis) -> Iterator[str]:
    for one in (*found.common, *found.single):
        if one.reach is Transfer.TRANSFERRED:
            yield (
                f"{one.name} is the same at all sensors: its source is far off beside the distance between them, or it "
                "is something that they share (the given field, navigation, a supply): another place in the array does "
                "not help."
            )
        elif one.reach is Transfer.NOT_TRANSFERRED:
            size, name = min(_sizes(found, one))
            largest, where = max(_sizes(found, one))
            more = f"{figure(largest / size)} times as much" if size > 0 else "most"
            yield (
                f"{one.name} differs from sensor to sensor: its source is near them, or in each. {name} has least, "
                f"{where} {more}."
            )
        else:
            without = [name for name, there in zip(found.names, one.there, strict=True) if there is There.ABSENT]
            if without:
                yield f"{one.name} is not in {', '.join(without)}: its source is near the others, or in them."


def _sizes(found: PooledDiagnosis, one: Common) -> list[tuple[float, str]]:
    """Size of the main parameter at each sensor."""
    pairs = zip(found.names, one.each, strict=True)
    return [(main_size(mine.effect), name) for name, mine in pairs if mine is not None]


def _of_one_alone(found: PooledDiagnosis) -> Iterator[str]:
    for one in found.single:
        against = [name for name, there in zip(found.names, one.there, strict=True) if there is There.ABSENT]
        why = f"{', '.join(against)} speak against it" if against else "the others cannot tell"
        yield f"{one.name} is named by one recording alone and {why}: it is no finding of the lot."
