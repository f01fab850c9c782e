"""Sentence and advice for a diagnosis of several recordings."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from diagnosis.decision.advice import separation_advice
from diagnosis.decision.sentence import LISTED_CHANNELS, describe_effect
from diagnosis.result import NORMAL_95, EvidenceKind, Transfer
from diagnosis.several.common_effects import CommonEffect, in_all, main_size
from diagnosis.several.pooled_effect import Presence
from diagnosis.several.result import RECORDINGS, PooledDiagnosis, Scope
from diagnosis.verdict import Verdict
from validation.text import all_of, figure


def with_sentences(diagnosis: PooledDiagnosis) -> PooledDiagnosis:
    """The diagnosis with its sentence and advice: of all together, or of the worst with the verdicts of all."""
    sentence = pooled_sentence(diagnosis) if diagnosis.first is None else headline_sentence(diagnosis, diagnosis.first)
    advice = pooled_advice if diagnosis.scope is RECORDINGS else array_advice
    return replace(diagnosis, sentence=sentence, advice=advice(diagnosis))


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
    explained = diagnosis.gap.explained
    if explained is None or not transfers:
        return ""
    whose = "its own" if transfers == {Transfer.NOT_TRANSFERRED} else "the others'"
    return f"; in each recording {whose} coefficients explain {100 * explained:.0f} % of the gap"


def headline_sentence(diagnosis: PooledDiagnosis, first: int) -> str:
    """Summarise the sensor or recording of index `first`, the verdicts of all, and the transfer of common effects."""
    count = Counter(str(item.verdict) for item in diagnosis.each)
    verdicts = ", ".join(f"{many} {word}" for word, many in count.items())
    transfers = "".join(f" {item.name} is {describe_transfer(item, diagnosis.scope)}." for item in diagnosis.common)
    if len(count) == 1 and diagnosis.verdict is Verdict.NONE:
        return f"{all_of(len(diagnosis.each), diagnosis.scope.key).capitalize()}: {diagnosis.each[0].sentence}"
    worst = f"{diagnosis.names[first]}, of {len(diagnosis.each)} {diagnosis.scope.key} ({verdicts})"
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
    """Advice on differences and single recordings, then advice shared by all recordings' own diagnoses."""
    lines = [line for effect in diagnosis.common for line in _advice_on_transfer(diagnosis, effect)]
    for effect in diagnosis.single:
        against = diagnosis.without(effect)
        why = f"{', '.join(against)} contradict it" if against else "the others cannot decide"
        lines.append(f"{effect.name} is named by one recording alone and {why}: not a common finding.")
    lines += separation_advice([effect.named for effect in diagnosis.common])
    shared, named = in_all([own.advice for own in diagnosis.each]), tuple(effect.name for effect in diagnosis.common)
    lines += (line for line in shared if "--confirm" not in line and not line.startswith(named))
    return tuple(dict.fromkeys(lines))


def _advice_on_transfer(diagnosis: PooledDiagnosis, effect: CommonEffect) -> list[str]:
    if effect.transfer is Transfer.SOME:
        return _elsewhere(diagnosis, effect, "find out what was on or mounted in the other recordings only.")
    if effect.transfer is not Transfer.NOT_TRANSFERRED:
        return []
    return [
        f"{effect.name} does not transfer{_most_different(diagnosis, effect)}. Find out what changed between the "
        "recordings (mount, load, power, settings), and calibrate each state by itself."
    ]


def _most_different(diagnosis: PooledDiagnosis, effect: CommonEffect) -> str:
    """The recording that differs most from all others, with the ratio of sizes."""
    known = [(name, *ratio) for name, ratio in zip(diagnosis.names, effect.ratios, strict=False) if ratio is not None]
    if not known:
        return ""
    name, ratio, std = max(known, key=lambda row: abs(row[1] - 1) / row[2])
    return f": {name} has {figure(ratio)} times the size of the others (+-{figure(NORMAL_95 * std, 1)})"


def array_advice(diagnosis: PooledDiagnosis) -> tuple[str, ...]:
    """Whether a source is near or far, then the advice of the worst sensor's own diagnosis."""
    lines: list[str] = []
    for effect in (*diagnosis.common, *diagnosis.single):
        if effect.transfer is Transfer.TRANSFERRED:
            lines.append(
                f"{effect.name} is the same at all sensors: its source is far away compared with their spacing, or "
                "shared (the given field, navigation, a supply): another place in the array does not help."
            )
        elif effect.transfer is Transfer.NOT_TRANSFERRED:
            known = [(own, name) for own, name in zip(effect.each, diagnosis.names, strict=True) if own is not None]
            (size, name), *_, (largest, where) = sorted((main_size(own.effect), name) for own, name in known)
            more = f"{figure(largest / size)} times as much" if size > 0 else "most"
            lines.append(
                f"{effect.name} differs from sensor to sensor: its source is nearby, or inside each sensor. {name} has "
                f"least, {where} {more}."
            )
        else:
            lines += _elsewhere(diagnosis, effect, "its source is near or inside the other sensors.")
    return tuple(dict.fromkeys([*lines, *diagnosis.each[diagnosis.first or 0].advice]))


def _elsewhere(diagnosis: PooledDiagnosis, effect: CommonEffect, meaning: str) -> list[str]:
    """What an effect's absence from some recordings or sensors means."""
    without = diagnosis.without(effect)
    return [f"{effect.name} is not in {', '.join(without)}: {meaning}"] if without else []
