"""What a diagnosis says: verdict, named effects with their parameters, the gap before and after, and what to do."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from diagnosis.evidence.active_parts import ActivePart, Part
from diagnosis.evidence.candidate_result import CandidateResult
from diagnosis.evidence.localise import Share
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.evidence.rising_spectrum import RisingSpectrum
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.verdict import Verdict
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.effects.parameters import Parameter
from sim.scenario import Scenario
from validation.signals.amplitude import rms

NORMAL_95 = 1.96
"""Standard deviations of a 95 % interval."""


class How(StrEnum):
    """What a name rests on; `words` says it in general."""

    words: str

    def __new__(cls, key: str, words: str) -> How:
        """A key with its words."""
        how = str.__new__(cls, key)
        how._value_, how.words = key, words
        return how

    HELD_OUT = "held-out", "gain on held-out data"
    DIRECT = "direct", "seen in the values themselves"
    IRON = "base", "iron or sensor constants differ from the model's"
    SPECTRUM = "spectrum", "the spectrum of what is left"
    CURVE = "curve", "gain of a curve on held-out data; no mechanism is told"


FITTED = (How.HELD_OUT, How.CURVE)
"""Names whose coefficients another recording can bear out."""


class Transfer(StrEnum):
    """Whether other recordings bear a name out: with one coefficient, with several, only some of them."""

    SINGLE_RUN = "single-run"
    TRANSFERRED = "transferred"
    NOT_TRANSFERRED = "not-transferred"
    SOME = "some"


@dataclass(frozen=True)
class Named:
    """One effect that is missing in the model: fitted, with 95 % intervals, and those that it may be mistaken for.

    nats: evidence on held-out data, of which so many were `needed`; strength: rms after the base refit, in noise;
    spread: standard deviations of each parameter's components; also: what belongs to it and is no cause of its own,
    such as another motor, a harmonic, or the iron that goes with a reference. Of a curve, covariance (k, k): of its
    linear coefficients; rivals: channels that may drive it as well.
    """

    effect: Effect
    alternatives: tuple[str, ...]
    how: How
    nats: float | None
    strength: float
    spread: dict[str, Array] = field(default_factory=dict)
    evidence: Transfer = Transfer.SINGLE_RUN
    needed: float | None = None
    covariance: Array | None = None
    rivals: tuple[str, ...] = ()
    also: tuple[Effect, ...] = ()

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name

    @property
    def others(self) -> tuple[str, ...]:
        """What it may be instead, in words: another effect, or what follows another channel; a curve says its own."""
        channels = () if self.how is How.CURVE else self.rivals
        return (*self.alternatives, *(f"what goes with {channel}" for channel in channels))

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effect, and what belongs to it."""
        return (self.effect, *self.also)

    @property
    def askable(self) -> bool:
        """Whether it has coefficients that hold all through a run, which another recording can bear out."""
        lasts = self.effect.active_s is None and not self.effect.traits.one_run
        return lasts and self.how in FITTED


@dataclass(frozen=True)
class GapSize:
    """Rms of measured minus simulated on held-out segments, hard and soft iron refitted on the others.

    explained: ``(g0^2 - g1^2) / (g0^2 - 1)``, at most 1, g in units of the noise; None where there is no gap.
    """

    before_nT: float
    before_sigma: float
    after_nT: float
    after_sigma: float
    explained: float | None

    @property
    def noise_nT(self) -> float:
        """The noise of a sample."""
        return self.before_nT / self.before_sigma

    @property
    def structure_nT(self) -> tuple[float, float]:
        """What of the rms before and after is no noise: ``sqrt(rms^2 - noise^2)``."""
        before, after = (max(rms_nT**2 - self.noise_nT**2, 0.0) ** 0.5 for rms_nT in (self.before_nT, self.after_nT))
        return before, after

    @classmethod
    def of(cls, before: Array, after: Array, sigma_nT: Array, policy: Policy) -> GapSize:
        """The size of what is left before and after (n, q), in units of the noise (q,)."""
        before_sigma, after_sigma = rms(before), rms(after)
        excess = before_sigma**2 - 1
        some = excess > policy.least_held_excess
        explained = min(1.0, (before_sigma**2 - after_sigma**2) / excess) if some else None
        return cls(rms(before * sigma_nT), before_sigma, rms(after * sigma_nT), after_sigma, explained)


@dataclass(frozen=True)
class Flight:
    """What to fly next: a scenario, in words, and the nats by which one leg of it tells a name from a look-alike.

    needed_s: time of the leg after which they are told apart, were every minute worth the same.
    """

    scenario: Scenario
    name: str
    other: str
    leg: str
    leg_s: float
    nats: float
    needed_s: float

    def as_dict(self) -> dict[str, Any]:
        """The key `next` of the JSON."""
        told = {"tells": self.name, "from": self.other, "leg": self.leg, "leg_s": self.leg_s}
        return told | {"nats": self.nats, "needed_s": self.needed_s, "scenario": "next.toml"}


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """All that is reported of one recording against one model.

    where: channels that the gap goes with; absorbed: effects that look like iron on this motion; untested: effects
    whose causes the recording does not hold; doubts: why names were taken back; ranking: every candidate as the first
    round judged it; before_nT, after_nT (n, q): what is left; parts: of the run, in which the gap's size is steady;
    onward: what to fly next; second: whether a second recording was asked; rise: where what is left rises with
    frequency.
    """

    verdict: Verdict
    sentence: str
    named: tuple[Named, ...]
    where: tuple[Share, ...]
    gap: GapSize
    absorbed: tuple[str, ...]
    untested: tuple[str, ...]
    doubts: tuple[str, ...]
    ranking: tuple[CandidateResult, ...]
    before: ResidualTests
    after: ResidualTests
    model: Scenario
    problem: LinearProblem
    before_nT: Array
    after_nT: Array
    advice: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()
    onward: Flight | None = None
    second: bool = False
    rise: RisingSpectrum | None = None

    def __repr__(self) -> str:
        """Verdict and sentence."""
        return f"{self.verdict}: {self.sentence}"

    @property
    def not_observable(self) -> tuple[str, ...]:
        """Effects that this recording cannot show."""
        return (*self.absorbed, *self.untested)

    @property
    def left(self) -> tuple[str, ...]:
        """Why what is left is no white noise; empty where it is."""
        return (*self.after.why, *([] if self.rise is None else [self.rise.words]))

    def stretch(self, one: Named) -> ActivePart | None:
        """When a named effect acts; None for the whole run."""
        return None if one.effect.active_s is None else ActivePart.of(self.problem, *one.effect.active_s)

    def as_dict(self) -> dict[str, Any]:
        """The JSON of `magbench diagnose`."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "mode": self.problem.compared,
            "reference": [one.words for one in self.problem.instead],
            "effects": [_effect(one) | _when(self.stretch(one)) for one in self.named],
            "where": [{"channel": c, "frame": f, "score": round(s, 4)} for c, f, s in self.where],
            "when": [_when(part.stretch) | {"rms_nT": part.rms_nT, "rms_sigma": part.rms_sigma} for part in self.parts],
            "gap": {
                "before": {"rms_nT": self.gap.before_nT, "rms_sigma": self.gap.before_sigma},
                "after": {"rms_nT": self.gap.after_nT, "rms_sigma": self.gap.after_sigma},
                "explained": self.gap.explained,
            },
            "left": list(self.left),
            "candidates": [_candidate(one) for one in self.ranking],
            "not_observable": list(self.not_observable),
            "advice": list(self.advice),
            "next": None if self.onward is None else self.onward.as_dict(),
        }


def in_use(effect: Effect) -> tuple[Parameter, ...]:
    """The parameters of an effect and of its fuller forms that are in use."""
    return tuple(p for p in effect.parameters() if p.form in effect.forms_in_use)


def parameters(one: Named) -> dict[str, dict[str, Any]]:
    """Value with 95 % interval and unit of every parameter in use; no interval where the data do not give one."""
    out: dict[str, dict[str, Any]] = {}
    for p in in_use(one.effect):
        value = getattr(one.effect, p.name)
        if isinstance(value, str):
            out[p.name] = {"value": value, "low": None, "high": None, "unit": ""}
            continue
        middle = np.asarray(value, dtype=float)
        low, high = _interval(middle, one.spread.get(p.name))
        out[p.name] = {"value": middle.tolist(), "low": low, "high": high, "unit": p.unit}
    return out


def _interval(middle: Array, spread: Array | None) -> tuple[Any, Any]:
    """Ends of the 95 % interval; none where the data leave a combination of components open."""
    if spread is None or not np.isfinite(spread).all():
        return None, None
    return (middle - NORMAL_95 * spread).tolist(), (middle + NORMAL_95 * spread).tolist()


def _effect(one: Named) -> dict[str, Any]:
    return {
        "name": one.name,
        "alternatives": list(one.alternatives),
        "rivals": list(one.rivals),
        "parameters": parameters(one),
        "also": [
            {"name": effect.name, "parameters": {p.name: getattr(effect, p.name) for p in in_use(effect)}}
            for effect in one.also
        ],
        "evidence": one.evidence,
        "how": one.how,
        "evidence_nats": one.nats,
        "needed_nats": one.needed,
        "strength_sigma": one.strength,
    }


def _candidate(one: CandidateResult) -> dict[str, Any]:
    return {
        "name": one.name,
        "evidence_nats": one.nats,
        "needed_nats": one.needed,
        "strength_sigma": one.evidence.strength,
        "outcome": one.outcome,
    }


def _when(stretch: ActivePart | None) -> dict[str, Any]:
    """A stretch of the run; None: the whole."""
    if stretch is None:
        return {"interval_s": None, "phase": None, "heading_deg": None}
    return {
        "interval_s": [stretch.from_s, stretch.to_s],
        "phase": stretch.phase,
        "heading_deg": stretch.heading_deg,
    }
