"""Strength on held-out legs, before and after a calibration, and which model predicts them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from calib import Calibration, Reference
from calib.held_out.legs import LEAST_LEGS, LegPartition, legs_of
from calib.held_out.models import offset, with_iron
from calib.held_out.paired_legs import HeldOutErrors, ModelPair
from calib.numerics.paired import counted, mean_interval
from calib.numerics.points import lengths
from recordings import Recording
from scenarios.arrays import Array
from validation.assessment.policy import ASSESSMENT
from validation.assessment.sensor_model import MOTORS, WARMTH
from validation.signals.thinning import every_nth
from validation.text import listed

IronKind = Literal["nothing", "offset", "offset and matrix"]
CALLED = {MOTORS: "motor terms", WARMTH: "temperature term"}
"""Terms of the groups of inputs in words."""
MOST_SAMPLES = 10_000
"""Samples at most; longer recordings are thinned, since the residual of models depends on the motion."""
MULTIPLE = 1e-6
"""Deviation of a matrix from a multiple of the identity, in parts of the multiple, that is rounding."""


@dataclass(frozen=True)
class StrengthRms:
    """Rms deviation of the strength from the reference, nT: as measured, and on legs that the fit has not used."""

    before_nT: float
    after_nT: float


@dataclass(frozen=True)
class Use:
    """What predicts held-out legs significantly better than less, and whether more is undecided.

    terms : groups of inputs, motors and temperature, that a calibrator has chosen by unseen legs.
    """

    iron: IronKind
    undecided: bool
    terms: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """Return all parts in words: "offset, matrix and motor terms"."""
        parts = [*(() if self.iron == "nothing" else self.iron.split(" and ")), *(CALLED[one] for one in self.terms)]
        return listed(parts) if self.terms else self.iron

    @property
    def sentence(self) -> str:
        """Return the use as a clause."""
        if self.terms:
            return f"{self.kind} are needed" if self.iron != "nothing" else f"{self.kind} would do"
        if self.iron == "nothing":
            return "no calibration predicts unseen legs better than the raw measurement"
        if self.iron == "offset and matrix":
            return "offset and matrix are both needed"
        return "whether the matrix helps is undecided" if self.undecided else "the offset alone would do"


@dataclass(frozen=True)
class LegAgreement:
    """Number of legs, and of those that a fit without the leg predicts no worse than most."""

    agree: int
    legs: int

    @property
    def sentence(self) -> str:
        """Return the count as a clause: "3 of 4 legs agree"."""
        return f"{self.agree} of {self.legs} legs agree"

    @property
    def share(self) -> float:
        """Return the share of the legs that agree."""
        return self.agree / self.legs


@dataclass(frozen=True, eq=False)
class HeldOutLegs:
    """Errors of raw strength, of offset with a scale, and of offset with S, on held-out legs (legs,)."""

    sizes: Array
    raw_nT: Array
    pair: ModelPair

    @classmethod
    def of(cls, recording: Recording, reference: Reference) -> HeldOutLegs:
        """Return the errors, each leg predicted by least squares on all other legs."""
        thin = recording.taken(every_nth(len(recording), MOST_SAMPLES))
        legs, strength_nT = legs_of(thin), reference.strength_nT
        simple = offset(replace(thin, att_q=None), reference)
        errors = [HeldOutErrors.of(model, legs, strength_nT) for model in (simple, with_iron(simple))]
        raw = lengths(thin.mag_nT) - strength_nT
        return cls(legs.sizes.astype(float), _rms_of(raw, legs), ModelPair(errors[0], errors[1]))

    def strength(self, fit: Calibration, recording: Recording, reference: Reference) -> StrengthRms:
        """Return the strength before a calibration and after; never below what the calibration itself leaves."""
        own = lengths(fit.apply(recording)) - reference.strength_nT
        before = self._pooled(self.raw_nT)
        return StrengthRms(before, max(self._pooled(self._rms_nT(fit)), float(np.sqrt(np.mean(own**2)))))

    def agreement(self, fit: Calibration) -> LegAgreement:
        """Return how many legs the model of a calibration predicts."""
        rms = self._rms_nT(fit)
        return LegAgreement(int(np.sum(rms <= ASSESSMENT.leg_worse * np.median(rms))), len(rms))

    def use(self) -> Use:
        """Return what predicts held-out legs significantly better than less."""
        if self.pair.verdict == "worth_it":
            return Use("offset and matrix", undecided=False)
        gain = self.raw_nT - self.pair.simpler.rms_nT
        effective = counted(gain[:, None]) if len(gain) >= LEAST_LEGS else 0.0
        kind: IronKind = "offset" if mean_interval(gain, effective)[0] > 0 else "nothing"
        return Use(kind, undecided=self.pair.verdict == "cannot_tell")

    def _rms_nT(self, fit: Calibration) -> Array:
        return (self.pair.simpler if is_scalar(fit) else self.pair.richer).rms_nT

    def _pooled(self, rms_nT: Array) -> float:
        return float(np.sqrt(np.average(rms_nT**2, weights=self.sizes)))


def is_scalar(fit: Calibration) -> bool:
    """Return whether a calibration's matrix is a multiple of the identity: offset and scale alone."""
    scale = float(np.trace(fit.matrix)) / 3.0
    return bool(np.abs(fit.matrix - scale * np.eye(3)).max() <= MULTIPLE * abs(scale))


def _rms_of(values: Array, legs: LegPartition) -> Array:
    ends = np.flatnonzero(np.diff(legs.number)) + 1
    parts: Sequence[Array] = np.split(values, ends)
    return np.array([np.sqrt(np.mean(part**2)) for part in parts])
