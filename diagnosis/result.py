"""Result of a diagnosis: verdict, named effects with parameters, the gap before and after, advice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.evidence.active_parts import ActivePart
from diagnosis.evidence.gap_size import GapSize
from diagnosis.evidence.held_out import CandidateResult
from diagnosis.evidence.localise import ChannelShare, localise
from diagnosis.evidence.residual_tests import ResidualTests, RisingSpectrum
from diagnosis.problem.linear import LinearProblem
from diagnosis.verdict import Verdict
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.effects.parameters import Parameter
from sim.scenario import Model, Scenario
from validation.signals.amplitude import rms
from validation.text import digits

NORMAL_95 = 1.96
"""Standard deviations of a 95 % interval."""


class EvidenceKind(StrEnum):
    """Kind of evidence for a named effect; `words` describes it."""

    words: str

    def __new__(cls, key: str, words: str) -> EvidenceKind:
        """Create a kind from key and words."""
        kind = str.__new__(cls, key)
        kind._value_, kind.words = key, words
        return kind

    HELD_OUT = "held-out", "gain on held-out data"
    DIRECT = "direct", "seen in the values themselves"
    IRON = "base", "iron or sensor constants differ from the model"
    SPECTRUM = "spectrum", "the spectrum of the residual"
    CURVE = "curve", "gain of a curve on held-out data; the mechanism is unknown"


FITTED = (EvidenceKind.HELD_OUT, EvidenceKind.CURVE)
"""Kinds whose coefficients another recording can confirm."""
OF_VALUES = (EvidenceKind.DIRECT, EvidenceKind.SPECTRUM)
"""Kinds of evidence for noise and for steps, spikes and repeated rows of the values."""


class Transfer(StrEnum):
    """Whether other recordings confirm an effect: with equal or differing coefficients, or only some of them."""

    SINGLE_RUN = "single-run"
    TRANSFERRED = "transferred"
    NOT_TRANSFERRED = "not-transferred"
    SOME = "some"


@dataclass(frozen=True)
class NamedEffect:
    """An effect missing in the model: fitted, with 95 % intervals and look-alikes.

    nats: evidence on held-out data, of which `needed` were required. strength: rms after the base refit, in units of
    the noise. spread: standard deviations of each parameter's components. also: further parts of the cause, such as a
    second motor, a harmonic, or iron restating a reference. For a curve, covariance (k, k): of its linear coefficients.
    rivals: channels that may drive the effect as well.
    """

    effect: Effect
    alternatives: tuple[str, ...]
    kind: EvidenceKind
    nats: float | None
    strength: float
    spread: dict[str, Array] = field(default_factory=dict)
    transfer: Transfer = Transfer.SINGLE_RUN
    needed: float | None = None
    covariance: Array | None = None
    rivals: tuple[str, ...] = ()
    also: tuple[Effect, ...] = ()

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name

    @property
    def look_alikes(self) -> tuple[str, ...]:
        """Look-alikes in words: other effects, or effects of other channels; a curve names its own rivals."""
        channels = () if self.kind is EvidenceKind.CURVE else self.rivals
        return (*self.alternatives, *(f"an effect of {channel}" for channel in channels))

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effect with all further parts."""
        return (self.effect, *self.also)

    @property
    def transferable(self) -> bool:
        """Whether the coefficients hold throughout a run, and a further recording can confirm them."""
        return self.kind in FITTED and self.effect.active_s is None and not self.effect.traits.one_run

    def as_dict(self) -> dict[str, Any]:
        """Keys of the JSON that all named effects have."""
        return {
            "name": self.name,
            "alternatives": list(self.alternatives),
            "rivals": list(self.rivals),
            "parameters": parameters(self),
            "evidence": self.transfer,
            "how": self.kind,
            "evidence_nats": self.nats,
            "strength_sigma": self.strength,
        }


@dataclass(frozen=True)
class Explanation:
    """Named effects of a recording, and the gap that they explain.

    clean: whether the residual is white, or explained by slow noise. where: channels that the gap follows. before_nT,
    after_nT (n, q): residuals. after: tests of the residual of the accepted effects. rise: frequencies at which the
    residual's spectrum rises. doubts: why the named effects may only resemble the cause.
    """

    problem: LinearProblem
    named: tuple[NamedEffect, ...]
    clean: bool
    gap: GapSize
    where: tuple[ChannelShare, ...]
    before_nT: Array
    after_nT: Array
    after: ResidualTests
    rise: RisingSpectrum | None
    doubts: tuple[str, ...] = field(default=(), kw_only=True)

    @classmethod
    def by(
        cls,
        problem: LinearProblem,
        named: Sequence[NamedEffect],
        residuals: tuple[Array, Array],
        use: NDArray[np.bool_],
        after: ResidualTests,
        *,
        clean: bool,
    ) -> Explanation:
        """The explanation by effects whose residuals (n, q) before and after are compared on the samples `use` (n,)."""
        gap, where = GapSize.of(problem, *residuals, use), localise(problem, residuals[0])
        before_nT, after_nT = (residual * problem.sigma_nT for residual in residuals)
        rise = RisingSpectrum.of(problem, *residuals)
        return cls(problem, tuple(named), clean, gap, where, before_nT, after_nT, after, rise)

    @property
    def residual(self) -> Array:
        """The residual (n, q) in units of the noise."""
        return self.after_nT / self.problem.sigma_nT

    @cached_property
    def left(self) -> tuple[ChannelShare, ...]:
        """Channels that the residual follows."""
        return localise(self.problem, self.residual)

    @property
    def unexplained(self) -> tuple[str, ...]:
        """Structure left in the residual; empty where the residual is white."""
        return (*self.after.why, *([] if self.rise is None else [self.rise.words]))

    def of_kind(self, kind: EvidenceKind) -> tuple[NamedEffect, ...]:
        """The named effects with a kind of evidence."""
        return tuple(cause for cause in self.named if cause.kind is kind)

    def without_effects(self) -> Explanation:
        """Direct evidence alone: of the gap nothing is explained."""
        named, gap = self.of_kind(EvidenceKind.DIRECT), self.gap.without_effects()
        return replace(self, named=named, after_nT=self.before_nT, gap=gap)


@dataclass(frozen=True)
class Flight:
    """The next flight: a scenario, in words, and the nats by which one leg separates a named effect from a look-alike.

    needed_s: flying time to separate both, at constant nats per time.
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
        separation = {"tells": self.name, "from": self.other, "leg": self.leg, "leg_s": self.leg_s}
        return separation | {"nats": self.nats, "needed_s": self.needed_s, "scenario": "next.toml"}


@dataclass(frozen=True, repr=False)
class Diagnosis(Explanation):
    """Diagnosis of a recording against a model: an explanation with its verdict, in words, and the new model.

    absorbed: effects resembling iron on the motion. untested: effects whose causes are not recorded. ranking: results
    of all candidates in the first round. before: tests of the residual without effects. given: effects of the model as
    given. parts: parts of the run with a steady size of the gap. next_flight: advised flight. has_second: whether a
    second recording was given. resimulated_nT: rms that the written model leaves of the whole recording, without any
    fit. iron_anew: whether that model has iron fitted to the recording in place of the given.
    """

    verdict: Verdict
    absorbed: tuple[str, ...]
    untested: tuple[str, ...]
    ranking: tuple[CandidateResult, ...]
    before: ResidualTests
    model: Model
    given: tuple[Effect, ...] = ()
    parts: tuple[ActivePart, ...] = ()
    sentence: str = ""
    advice: tuple[str, ...] = ()
    next_flight: Flight | None = None
    has_second: bool = False
    resimulated_nT: float | None = None
    iron_anew: bool = False

    def __repr__(self) -> str:
        """Return verdict and sentence."""
        return f"{self.verdict}: {self.sentence}"

    @cached_property
    def left_nT(self) -> float:
        """Rms of the residual of the named effects beside the fitted iron."""
        return rms(self.after_nT[self.problem.usable > 0])

    @property
    def unexplained(self) -> tuple[str, ...]:
        """Structure left in the residual, and a written model that leaves clearly more than the named effects do."""
        left_nT, most_nT = self.resimulated_nT, self.problem.policy.clearly_larger * self.left_nT
        if left_nT is None or left_nT <= most_nT or not self.named:
            return super().unexplained
        return (*super().unexplained, f"run by the simulator, the new model leaves {digits(left_nT)} nT")

    @property
    def not_observable(self) -> tuple[str, ...]:
        """Effects not observable in the recording."""
        return (*self.absorbed, *self.untested)

    def correction_of(self, cause: NamedEffect) -> tuple[Effect, Effect] | None:
        """The model's own effect of a named effect's name, as given and as corrected; None unless there is one each."""
        given, new = ([one for one in chain if one.name == cause.name] for chain in (self.given, self.model.chain()))
        return (given[0], new[0]) if len(given) == len(new) == 1 and given != new else None

    def stretch(self, cause: NamedEffect) -> ActivePart | None:
        """The time of action of a named effect; None for the whole run."""
        return None if cause.effect.active_s is None else ActivePart.of(self.problem, *cause.effect.active_s)

    def as_dict(self) -> dict[str, Any]:
        """The JSON of `magbench diagnose`."""
        resimulated = None if self.resimulated_nT is None else {"rms_nT": self.resimulated_nT}
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "mode": self.problem.compared,
            "reference": [item.words for item in self.problem.corrections],
            "effects": [self._effect_json(item) for item in self.named],
            "where": [{"channel": c, "frame": f, "score": round(s, 4)} for c, f, s in self.where],
            "when": [
                _interval_json(part) | {"rms_nT": part.rms_nT, "rms_sigma": part.rms_sigma} for part in self.parts
            ],
            "gap": self.gap.as_dict() | {"resimulated": resimulated},
            "left": list(self.unexplained),
            "candidates": [_candidate_json(item) for item in self.ranking],
            "not_observable": list(self.not_observable),
            "advice": list(self.advice),
            "next": None if self.next_flight is None else self.next_flight.as_dict(),
        }

    def _effect_json(self, cause: NamedEffect) -> dict[str, Any]:
        given, corrected = map(_values_in_use, self.correction_of(cause) or (None, None))
        return cause.as_dict() | {
            "also": [{"name": effect.name, "parameters": _values_in_use(effect)} for effect in cause.also],
            "needed_nats": cause.needed,
            "stated": given,
            "corrected": corrected,
            **_interval_json(self.stretch(cause)),
        }


def in_use(effect: Effect) -> tuple[Parameter, ...]:
    """Parameters in use of an effect and of its fuller forms."""
    return tuple(parameter for parameter in effect.parameters() if parameter.form in effect.forms_in_use)


def _values_in_use(effect: Effect | None) -> dict[str, Any] | None:
    return None if effect is None else {parameter.name: getattr(effect, parameter.name) for parameter in in_use(effect)}


def parameters(cause: NamedEffect) -> dict[str, dict[str, Any]]:
    """Value with 95 % interval and unit of every parameter in use; no interval where undetermined."""
    values: dict[str, dict[str, Any]] = {}
    for parameter in in_use(cause.effect):
        value, low, high = getattr(cause.effect, parameter.name), None, None
        if not (worded := isinstance(value, str)):
            middle, spread = np.asarray(value, dtype=float), cause.spread.get(parameter.name)
            value = middle.tolist()
            if spread is not None and np.isfinite(spread).all():  # no combination of components is undetermined
                low, high = ((middle + side * NORMAL_95 * spread).tolist() for side in (-1, 1))
        values[parameter.name] = {"value": value, "low": low, "high": high, "unit": "" if worded else parameter.unit}
    return values


def _candidate_json(result: CandidateResult) -> dict[str, Any]:
    evidence = {"evidence_nats": result.nats, "needed_nats": result.needed, "strength_sigma": result.evidence.strength}
    return {"name": result.name, **evidence, "outcome": result.outcome}


def _interval_json(part: ActivePart | None) -> dict[str, Any]:
    """A part of the run; None: the whole."""
    told = (None, None, None) if part is None else ([part.from_s, part.to_s], part.phase, part.heading_deg)
    return dict(zip(("interval_s", "phase", "heading_deg"), told, strict=True))
