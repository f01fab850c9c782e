"""Result of a diagnosis of several recordings: verdict, effects with their values in each, gaps, advice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from diagnosis.evidence.localise import ChannelShare
from diagnosis.result import Diagnosis, GapSize, Transfer, parameters
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.scope import RECORDINGS, Scope
from diagnosis.verdict import Verdict
from scenarios.arrays import Array
from sim.scenario import Scenario


@dataclass(frozen=True, repr=False)
class PooledDiagnosis:
    """Report on n recordings compared with one model.

    names, each: the recordings with their own diagnoses. common: effects supported by more than one recording. single:
    effects named by one. gaps, before_nT, after_nT: of each recording, with the coefficients predicted by the other
    recordings, or with its own where these differ. gap: of all recordings. scope: recordings, or the sensors of one
    array; sensors keep the gaps of their own diagnoses. first: the sensor in the headline, or the recording that
    says more alone than all together.
    """

    names: tuple[str, ...]
    each: tuple[Diagnosis, ...]
    verdict: Verdict
    sentence: str
    common: tuple[CommonEffect, ...]
    single: tuple[CommonEffect, ...]
    gap: GapSize
    gaps: tuple[GapSize, ...]
    where: tuple[ChannelShare, ...]
    unexplained: tuple[str, ...]
    advice: tuple[str, ...]
    model: Scenario
    before_nT: tuple[Array, ...]
    after_nT: tuple[Array, ...]
    scope: Scope = RECORDINGS
    first: int | None = None

    def __repr__(self) -> str:
        """Return verdict and sentence."""
        return f"{self.verdict}: {self.sentence}"

    @property
    def not_observable(self) -> tuple[str, ...]:
        """Effects observable in none of the recordings."""
        first, *others = (diagnosis.not_observable for diagnosis in self.each)
        return tuple(name for name in first if all(name in names_of_other for names_of_other in others))

    def as_dict(self) -> dict[str, Any]:
        """The JSON of `magbench diagnose` for several recordings, or for the sensors of an array."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "mode": self.each[0].problem.compared,
            "effects": [*self._own_effects_json(), *(self._effect_json(effect) for effect in self.common)],
            "not_borne_out": [self._effect_json(effect) for effect in self.single],
            "where": [{"channel": c, "frame": f, "score": round(s, 4)} for c, f, s in self.where],
            "gap": _gap_json(self.gap),
            "left": list(self.unexplained),
            "not_observable": list(self.not_observable),
            "advice": list(self.advice),
            self.scope.key: [self._recording_json(i) for i in range(len(self.names))],
        } | ({} if self.first is None else {"worst": self.names[self.first]})

    def _own_effects_json(self) -> list[dict[str, Any]]:
        """Effects of the recordings' own diagnoses that are not common, those of the headline first."""
        if self.first is None:
            return []
        order = (self.first, *(i for i in range(len(self.names)) if i != self.first))
        every = ((self.names[i], own) for i in order for own in self.each[i].as_dict()["effects"])
        common = {effect.name for effect in self.common}
        return [own | {"only_in": name} for name, own in every if own["name"] not in common]

    def _effect_json(self, effect: CommonEffect) -> dict[str, Any]:
        values = ({} if in_recording is None else parameters(in_recording) for in_recording in effect.each)
        rows = zip(self.names, effect.presence, effect.each, values, strict=True)
        return {
            "name": effect.name,
            "alternatives": list(effect.named.alternatives),
            "rivals": list(effect.named.rivals),
            "parameters": parameters(effect.named),
            **self._transfer_json(effect),
            "how": effect.named.kind,
            "evidence_nats": effect.named.nats,
            "strength_sigma": effect.named.strength,
            "agreement": {"chi2": effect.chi2, "degrees": effect.degrees, "p": effect.p},
            self.scope.key: [
                {
                    "name": name,
                    "says": presence,
                    "parameters": values,
                    "evidence_nats": None if in_recording is None else in_recording.nats,
                }
                for name, presence, in_recording, values in rows
            ],
        }

    def _transfer_json(self, effect: CommonEffect) -> dict[str, str]:
        """Sensors of one recording share its slow errors: they are no second recording."""
        if self.scope is RECORDINGS:
            return {"evidence": effect.transfer}
        return {"evidence": Transfer.SINGLE_RUN, "among_sensors": self.scope.labels[effect.transfer]}

    def _recording_json(self, i: int) -> dict[str, Any]:
        own = self.each[i].as_dict()
        coefficients = {
            effect.name: parameters(in_recording)
            for effect in (*self.common, *self.single)
            if (in_recording := effect.each[i]) is not None
        }
        return {
            "name": self.names[i],
            "verdict": own["verdict"],
            "sentence": own["sentence"],
            "gap": own["gap"],
            "gap_together": _gap_json(self.gaps[i]),
            "effects": own["effects"],
            "coefficients": coefficients,
        }


def _gap_json(gap: GapSize) -> dict[str, Any]:
    return {
        "before": {"rms_nT": gap.before_nT, "rms_sigma": gap.before_sigma},
        "after": {"rms_nT": gap.after_nT, "rms_sigma": gap.after_sigma},
        "explained": gap.explained,
    }


def worst(each: Sequence[Diagnosis]) -> int:
    """Index of the diagnosis with the largest unexplained gap (else the largest gap), in units of its noise."""
    unexplained = [i for i, diagnosis in enumerate(each) if not diagnosis.verdict.explained]
    if unexplained:
        return max(unexplained, key=lambda i: each[i].gap.after_sigma)
    gaps = [i for i, diagnosis in enumerate(each) if diagnosis.verdict is not Verdict.NONE]
    return max(gaps or range(len(each)), key=lambda i: each[i].gap.before_sigma)
