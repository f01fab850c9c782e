"""Sentence and advice for a diagnosis of several recordings, or of the sensors of an array."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

from diagnosis.decision.advice import separation_advice
from diagnosis.decision.sentence import LISTED_CHANNELS, describe_effect
from diagnosis.result import NORMAL_95, EvidenceKind, Transfer
from diagnosis.several.common_effects import CommonEffect, in_all, main_size
from diagnosis.several.pooled_effect import Presence
from diagnosis.several.result import RECORDINGS, SENSORS, PooledDiagnosis, Scope, worst
from diagnosis.verdict import Verdict
from validation.text import all_of, figure

ELSEWHERE = "{name} is not in {without}: "
ADVICE: Mapping[str, Mapping[Transfer, str]] = {
    RECORDINGS.key: {
        Transfer.NOT_TRANSFERRED: "{name} does not transfer{ratio}. Find out what changed between the recordings "
        "(mount, load, power, settings), and calibrate each state by itself.",
        Transfer.SOME: ELSEWHERE + "find out what was on or mounted in the other recordings only.",
        Transfer.SINGLE_RUN: "{name} is named by one recording alone and {against}: not a common finding.",
    },
    SENSORS.key: {
        Transfer.TRANSFERRED: "{name} is the same at all sensors: its source is far away compared with their spacing, "
        "or shared (the given field, navigation, a supply): another place in the array does not help.",
        Transfer.NOT_TRANSFERRED: "{name} differs from sensor to sensor: its source is nearby, or inside each sensor. "
        "{sizes}.",
        Transfer.SOME: ELSEWHERE + "its source is near or inside the other sensors.",
        Transfer.SINGLE_RUN: ELSEWHERE + "its source is near or inside the other sensors.",
    },
}
"""Advice on an effect by its transfer between recordings or sensors; without: those that exclude the effect."""


def with_sentences(diagnosis: PooledDiagnosis) -> PooledDiagnosis:
    """The diagnosis with sentence and advice: of all together, or of the worst where the recordings alone say more."""
    if diagnosis.first is None and diagnosis.says_less_than_each:
        first = worst(diagnosis.each)
        diagnosis = replace(diagnosis, first=first, verdict=diagnosis.each[first].verdict)
    sentence = pooled_sentence if diagnosis.first is None else headline_sentence
    return replace(diagnosis, sentence=sentence(diagnosis), advice=pooled_advice(diagnosis))


def pooled_sentence(diagnosis: PooledDiagnosis) -> str:
    """Summarise the diagnosis in one sentence for a field engineer."""
    channels = ", ".join(effect.channel for effect in diagnosis.where[:LISTED_CHANNELS])
    causes = (f"{describe_effect(effect.named)}, {describe_transfer(effect)}" for effect in diagnosis.common)
    sentence = diagnosis.verdict.sentence(
        causes="; ".join(causes),
        share=_share(diagnosis),
        left="; ".join(diagnosis.unexplained),
        nearest="",
        goes_with=f"; the gap follows {channels}" if channels else "",
    )
    for name, own in zip(diagnosis.names, diagnosis.each, strict=True):  # events, which no other recording can show
        events = [cause for cause in own.named if cause.kind is EvidenceKind.HELD_OUT and not cause.transferable]
        sentence += f" {name} alone has {'; '.join(map(describe_effect, events))}." if events else ""
    return sentence


def _share(diagnosis: PooledDiagnosis) -> str:
    """The share of the gap that fitted effects explain, if any."""
    transfers = {effect.transfer for effect in diagnosis.common if effect.named.kind is EvidenceKind.HELD_OUT}
    explained, whose = diagnosis.gap.explained, "its own" if transfers == {Transfer.NOT_TRANSFERRED} else "the others'"
    if explained is None or not transfers:
        return ""
    return f"; in each recording {whose} coefficients explain {100 * explained:.0f} % of the gap"


def headline_sentence(diagnosis: PooledDiagnosis) -> str:
    """Summarise the first sensor or recording, the verdicts of all, and the transfer of common effects."""
    n, first, count = len(diagnosis.each), diagnosis.first or 0, Counter(str(own.verdict) for own in diagnosis.each)
    verdicts = ", ".join(f"{many} {word}" for word, many in count.items())
    transfers = "".join(f" {item.name} is {describe_transfer(item, diagnosis.scope)}." for item in diagnosis.common)
    if len(count) == 1 and diagnosis.verdict is Verdict.NONE:
        return f"{all_of(n, diagnosis.scope.key).capitalize()}: {diagnosis.each[0].sentence}"
    worst = f"{diagnosis.names[first]}, of {n} {diagnosis.scope.key} ({verdicts})"
    return f"{worst}: {diagnosis.each[first].sentence}{transfers}"


def describe_transfer(effect: CommonEffect, scope: Scope = RECORDINGS) -> str:
    """Describe the transfer of an effect in words."""
    n, showing = len(effect.presence), effect.presence.count(Presence.PRESENT)
    if effect.transfer is Transfer.TRANSFERRED:
        return f"the same in {all_of(n, scope.key)}"
    if effect.transfer is Transfer.NOT_TRANSFERRED:
        return f"of different size from {scope.noun} to {scope.noun}"
    return f"in {showing} of {n} {scope.key}"


def pooled_advice(diagnosis: PooledDiagnosis) -> tuple[str, ...]:
    """Advice on the transfer of effects, then what all recordings advise alike, or the worst sensor."""
    lines = [_transfer_advice(diagnosis, effect) for effect in (*diagnosis.common, *diagnosis.single)]
    if diagnosis.scope is SENSORS:
        lines += diagnosis.each[diagnosis.first or 0].advice
    else:
        lines += separation_advice([effect.named for effect in diagnosis.common])
        named, shared = (
            tuple(effect.name for effect in diagnosis.common),
            in_all([own.advice for own in diagnosis.each]),
        )
        lines += (line for line in shared if "--confirm" not in line and not line.startswith(named))
    return tuple(dict.fromkeys(filter(None, lines)))


def _transfer_advice(diagnosis: PooledDiagnosis, effect: CommonEffect) -> str:
    """What the transfer of an effect means; empty where nothing excludes an effect that is not in all."""
    words = ADVICE[diagnosis.scope.key].get(effect.transfer, "")
    pairs = zip(diagnosis.names, effect.presence, strict=True)
    without = ", ".join(name for name, presence in pairs if presence is Presence.ABSENT)
    if words.startswith(ELSEWHERE) and not without:
        return ""
    against = f"{without} contradict it" if without else "the others cannot decide"
    ratio, sizes = _largest_ratio(diagnosis, effect), _sizes(diagnosis, effect)
    return words.format(name=effect.name, without=without, against=against, ratio=ratio, sizes=sizes)


def _largest_ratio(diagnosis: PooledDiagnosis, effect: CommonEffect) -> str:
    """The recording that differs most from all others, with the ratio of sizes."""
    known = [(name, *ratio) for name, ratio in zip(diagnosis.names, effect.ratios, strict=False) if ratio is not None]
    if not known:
        return ""
    name, ratio, std = max(known, key=lambda row: abs(row[1] - 1) / row[2])
    return f": {name} has {figure(ratio)} times the size of the others (+-{figure(NORMAL_95 * std, 1)})"


def _sizes(diagnosis: PooledDiagnosis, effect: CommonEffect) -> str:
    """The sensors with the smallest and the largest effect."""
    each = zip(effect.each, diagnosis.names, strict=True)
    sizes = sorted((main_size(own.effect), name) for own, name in each if own is not None)
    (least, name), (most, where) = sizes[0], sizes[-1]
    return f"{name} has least, {where} {f'{figure(most / least)} times as much' if least > 0 else 'most'}"
