"""What several recordings say together: verdict, effects with their values in each, gaps, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from diagnosis.evidence.localise import Share
from diagnosis.result import Diagnosis, GapSize, Transfer, parameters
from diagnosis.several.common_effects import Common
from diagnosis.several.scope import RECORDINGS, Scope
from diagnosis.verdict import Verdict
from scenarios.arrays import Array
from sim.scenario import Scenario


@dataclass(frozen=True, repr=False)
class PooledDiagnosis:
    """All that is reported of n recordings against one model.

    names, each: the recordings with their own diagnoses; common: effects that more than one bears out; single: effects
    that one alone names; gaps, before_nT, after_nT: of each recording, the named effects with the coefficients that
    the other recordings give, with its own where these differ; gap: of all. among: recordings, or the sensors of one
    array, which keep their own diagnosis' gaps; first: the one in the headline, of an array.
    """

    names: tuple[str, ...]
    each: tuple[Diagnosis, ...]
    verdict: Verdict
    sentence: str
    common: tuple[Common, ...]
    single: tuple[Common, ...]
    gap: GapSize
    gaps: tuple[GapSize, ...]
    where: tuple[Share, ...]
    left: tuple[str, ...]
    advice: tuple[str, ...]
    model: Scenario
    before_nT: tuple[Array, ...]
    after_nT: tuple[Array, ...]
    among: Scope = RECORDINGS
    first: int | None = None

    def __repr__(self) -> str:
        """Verdict and sentence."""
        return f"{self.verdict}: {self.sentence}"

    @property
    def not_observable(self) -> tuple[str, ...]:
        """Effects that none of the recordings can show."""
        first, *others = (one.not_observable for one in self.each)
        return tuple(name for name in first if all(name in other for other in others))

    def as_dict(self) -> dict[str, Any]:
        """The JSON of `magbench diagnose` for several recordings, or for the sensors of an array."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "mode": self.each[0].problem.compared,
            "effects": [self._effect(one) for one in self.common],
            "not_borne_out": [self._effect(one) for one in self.single],
            "where": [{"channel": c, "frame": f, "score": round(s, 4)} for c, f, s in self.where],
            "gap": _gap(self.gap),
            "left": list(self.left),
            "not_observable": list(self.not_observable),
            "advice": list(self.advice),
            self.among.key: [self._recording(i) for i in range(len(self.names))],
        } | ({} if self.first is None else {"worst": self.names[self.first]})

    def _effect(self, one: Common) -> dict[str, Any]:
        values = ({} if mine is None else parameters(mine) for mine in one.each)
        per = zip(self.names, one.there, one.each, values, strict=True)
        return {
            "name": one.name,
            "alternatives": list(one.named.alternatives),
            "rivals": list(one.named.rivals),
            "parameters": parameters(one.named),
            **self._evidence(one),
            "how": one.named.how,
            "evidence_nats": one.named.nats,
            "strength_sigma": one.named.strength,
            "agreement": {"chi2": one.chi2, "degrees": one.degrees, "p": one.p},
            self.among.key: [
                {
                    "name": name,
                    "says": there,
                    "parameters": values,
                    "evidence_nats": None if mine is None else mine.nats,
                }
                for name, there, mine, values in per
            ],
        }

    def _evidence(self, one: Common) -> dict[str, str]:
        """One run's sensors share its slow errors: they are no second recording."""
        if self.first is None:
            return {"evidence": one.reach}
        return {"evidence": Transfer.SINGLE_RUN, "among_sensors": self.among.reach[one.reach]}

    def _recording(self, i: int) -> dict[str, Any]:
        own = self.each[i].as_dict()
        coefficients = {
            one.name: parameters(mine) for one in (*self.common, *self.single) if (mine := one.each[i]) is not None
        }
        return {
            "name": self.names[i],
            "verdict": own["verdict"],
            "sentence": own["sentence"],
            "gap": own["gap"],
            "gap_together": _gap(self.gaps[i]),
            "effects": own["effects"],
            "coefficients": coefficients,
        }


def _gap(gap: GapSize) -> dict[str, Any]:
    return {
        "before": {"rms_nT": gap.before_nT, "rms_sigma": gap.before_sigma},
        "after": {"rms_nT": gap.after_nT, "rms_sigma": gap.after_sigma},
        "explained": gap.explained,
    }
