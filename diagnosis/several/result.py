"""Result of a diagnosis of several recordings: verdict, effects with their values in each, gaps, advice."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from diagnosis.evidence.gap_size import GapSize
from diagnosis.evidence.localise import ChannelShare
from diagnosis.result import OF_VALUES, Diagnosis, Explanation, Transfer, parameters
from diagnosis.several.common_effects import CommonEffect, in_all
from diagnosis.verdict import Verdict
from sim.scenario import Model


@dataclass(frozen=True)
class Scope:
    """Words for the compared units and for the transfer of effects between them.

    key: JSON key. labels: of transfer, for pages and tables. after: basis of the gap afterwards. alone: remark on an
    effect named by a single unit.
    """

    noun: str
    key: str
    labels: Mapping[Transfer, str]
    after: str
    alone: str


RECORDINGS = Scope(
    "recording",
    "recordings",
    dict(zip(Transfer, ("not confirmed", "transferred", "not transferred", "in some"), strict=True)),
    after="with the coefficients of the other recordings, or its own where these differ",
    alone="Not a common finding: the other recordings do not confirm it.",
)
SENSORS = Scope(
    "sensor",
    "sensors",
    dict(zip(Transfer, ("at one", "the same", "differs", "at some"), strict=True)),
    after="with the effects of its own diagnosis",
    alone="The other sensors do not show it, or cannot decide.",
)


@dataclass(frozen=True, repr=False)
class PooledDiagnosis:
    """Report on n recordings compared with one model.

    names, each: the recordings with their own diagnoses. common: effects supported by more than one recording. single:
    effects named by one. gaps: what the effects explain of each recording, with the coefficients predicted by the other
    recordings, or with its own where these differ. scope: recordings, or the sensors of one array; sensors keep the
    gaps of their own diagnoses. first: the sensor in the headline, or the recording that says more alone than all.
    """

    names: tuple[str, ...]
    each: tuple[Diagnosis, ...]
    verdict: Verdict
    common: tuple[CommonEffect, ...]
    single: tuple[CommonEffect, ...]
    gaps: tuple[Explanation, ...]
    model: Model
    scope: Scope = RECORDINGS
    first: int | None = None
    sentence: str = ""
    advice: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return verdict and sentence."""
        return f"{self.verdict}: {self.sentence}"

    @cached_property
    def gap(self) -> GapSize:
        """Size of the gap of all recordings with equal weight."""
        return GapSize.joint([gap.gap for gap in self.gaps])

    @cached_property
    def where(self) -> tuple[ChannelShare, ...]:
        """Channels by mean share over the recordings; a recording in which a channel has no share counts as none."""
        frames, total = dict[str, str](), defaultdict[str, float](float)
        for name, frame, share in itertools.chain.from_iterable(gap.where for gap in self.gaps):
            frames.setdefault(name, frame)
            total[name] += share / len(self.gaps)
        largest = sorted(total, key=lambda name: -total[name])[: self.each[0].problem.policy.most_channels]
        return tuple(ChannelShare(name, frames[name], total[name]) for name in largest)

    @property
    def unexplained(self) -> tuple[str, ...]:
        """Structure left in each recording, and doubts about the effects."""
        told = ((name, (*gap.unexplained, *gap.doubts)) for name, gap in zip(self.names, self.gaps, strict=True))
        return tuple(f"{name}: {why}" for name, left in told for why in left)

    @property
    def says_less_than_each(self) -> bool:
        """Whether the recordings alone say more than all together.

        Nothing is common to all, and every recording alone has its answer or all together none; or only noise and steps
        of the values are common, and a recording has an effect or iron of its own.
        """
        if self.verdict is Verdict.NONE:
            return any(own.verdict is not Verdict.NONE for own in self.each)
        if self.verdict.explained:
            own_cause = any(cause.kind not in OF_VALUES for own in self.each for cause in own.named)
            return own_cause and all(effect.named.kind in OF_VALUES for effect in self.common)
        return self.verdict is Verdict.UNKNOWN and all(own.verdict.explained for own in self.each)

    @property
    def not_observable(self) -> tuple[str, ...]:
        """Effects observable in none of the recordings."""
        return in_all([diagnosis.not_observable for diagnosis in self.each])

    def as_dict(self) -> dict[str, Any]:
        """The JSON of `magbench diagnose` for several recordings, or for the sensors of an array."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "mode": self.each[0].problem.compared,
            "effects": [*self._own_effects_json(), *(self._effect_json(effect) for effect in self.common)],
            "not_borne_out": [self._effect_json(effect) for effect in self.single],
            "where": [{"channel": c, "frame": f, "score": round(s, 4)} for c, f, s in self.where],
            "gap": self.gap.as_dict(),
            "left": list(self.unexplained),
            "not_observable": list(self.not_observable),
            "advice": list(self.advice),
            self.scope.key: [self._recording_json(i) for i in range(len(self.names))],
        } | ({} if self.first is None else {"worst": self.names[self.first]})

    def _own_effects_json(self) -> list[dict[str, Any]]:
        """Effects of the recordings' own diagnoses that are not common, those of the headline first."""
        order = [] if self.first is None else sorted(range(len(self.names)), key=lambda i: i != self.first)
        common = {effect.name for effect in self.common}
        every = ((self.names[i], own) for i in order for own in self.each[i].as_dict()["effects"])
        return [own | {"only_in": name} for name, own in every if own["name"] not in common]

    def _effect_json(self, effect: CommonEffect) -> dict[str, Any]:
        rows, test = zip(self.names, effect.presence, effect.each, strict=True), effect.agreement
        # sensors of one recording share its slow errors: they are no second recording
        among = {"evidence": Transfer.SINGLE_RUN, "among_sensors": self.scope.labels[effect.transfer]}
        return effect.named.as_dict() | {
            **({} if self.scope is RECORDINGS else among),
            "agreement": {"chi2": test and test.chi2, "degrees": test.degrees if test else 0, "p": test and test.p},
            self.scope.key: [
                {
                    "name": name,
                    "says": presence,
                    "parameters": {} if own is None else parameters(own),
                    "evidence_nats": None if own is None else own.nats,
                }
                for name, presence, own in rows
            ],
        }

    def _recording_json(self, i: int) -> dict[str, Any]:
        told, effects = self.each[i].as_dict(), (*self.common, *self.single)
        return {
            "name": self.names[i],
            **{key: told[key] for key in ("verdict", "sentence", "gap", "effects")},
            "gap_together": self.gaps[i].gap.as_dict(),
            "coefficients": {one.name: parameters(own) for one in effects if (own := one.each[i]) is not None},
        }


def worst(each: Sequence[Diagnosis]) -> int:
    """Index of the diagnosis with the largest unexplained gap (else the largest gap), in units of its noise."""
    unexplained = [i for i, diagnosis in enumerate(each) if not diagnosis.verdict.explained]
    if unexplained:
        return max(unexplained, key=lambda i: each[i].gap.after_sigma)
    gaps = [i for i, diagnosis in enumerate(each) if diagnosis.verdict is not Verdict.NONE]
    return max(gaps or range(len(each)), key=lambda i: each[i].gap.before_sigma)
