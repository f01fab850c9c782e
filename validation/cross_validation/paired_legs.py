"""Two models on the same unseen legs: how much better one predicts, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.stats import t as student

from scenarios.arrays import Array
from validation.cross_validation.legs import LEAST_LEGS, LegPartition
from validation.cross_validation.models import Model

Verdict = Literal["worth_it", "as_well", "worse", "cannot_tell"]
SURE = 0.95
ROUNDING = 1e-9
"""Share of the field that an error is taken to have at least: less is rounding."""
SAME = 0.05
"""An interval within this share of what the simpler model leaves: the two predict as well as each other."""


@dataclass(frozen=True, eq=False)
class Unseen:
    """A model's errors on legs that it was not fitted to: rms of each leg (legs,), nT, and their means (legs, c)."""

    model: Model
    rms_nT: Array
    mean_nT: Array

    @classmethod
    def of(cls, model: Model, legs: LegPartition, strength_nT: float) -> Unseen:
        """Each leg by the parameters that the others give."""
        errors = [strength_nT * one for one in model.unseen(legs)]
        rms = np.array([max(np.sqrt(np.mean(one**2)), ROUNDING * strength_nT) for one in errors])
        return cls(model, rms, np.array([one.mean(axis=0) for one in errors]))

    @property
    def typical_nT(self) -> float:
        """Mean over the legs of their rms."""
        return float(self.rms_nT.mean())


@dataclass(frozen=True, eq=False)
class ModelPair:
    """A simpler and a richer model on the same legs.

    d_j = e_j - e'_j of leg j's rms errors; the gain is their mean, and its interval Student's t over as many legs as
    they count for: fewer where neighbours agree.

    doubt : why a gain is no reason to take the richer, as the end of a sentence; "" for none
    """

    simpler: Unseen
    richer: Unseen
    doubt: str = ""

    @property
    def gain_nT(self) -> Array:
        """By how much each leg (legs,) is predicted better."""
        return np.asarray(self.simpler.rms_nT - self.richer.rms_nT)

    @property
    def better_nT(self) -> float:
        """Their mean; negative where the richer predicts worse."""
        return float(self.gain_nT.mean())

    @cached_property
    def counted(self) -> float:
        """Legs that they count for: n (1 - r) / (1 + r), r the correlation of neighbours, where it is positive."""
        count = len(self.gain_nT)
        worst = max(_neighbours(self.gain_nT[:, None]), _neighbours(self.richer.mean_nT)) - 1.0 / np.sqrt(count)
        return float(count * (1.0 - max(0.0, worst)) / (1.0 + max(0.0, worst)))

    @cached_property
    def interval_nT(self) -> tuple[float, float]:
        """Of 95 %; without end where nothing is told."""
        if len(self.gain_nT) < LEAST_LEGS or self.counted < 2.0:
            return -np.inf, np.inf
        std = float(self.gain_nT.std(ddof=1)) / np.sqrt(self.counted)
        reach = float(student.ppf(0.5 + SURE / 2.0, self.counted - 1.0)) * std
        return self.better_nT - reach, self.better_nT + reach

    @property
    def kept(self) -> Unseen:
        """The richer where that is worth it, else the simpler."""
        return self.richer if self.verdict == "worth_it" else self.simpler

    @property
    def verdict(self) -> Verdict:
        """Worth it or worse where the interval says so, as well where it is narrow, else cannot tell."""
        low, high = self.interval_nT
        if low > 0:
            return "cannot_tell" if self.doubt else "worth_it"
        if high < 0:
            return "worse"
        return "as_well" if max(-low, high) <= SAME * self.simpler.typical_nT else "cannot_tell"


def _neighbours(values: Array) -> float:
    """Correlation of neighbours in values (n, k)."""
    off = values - values.mean(axis=0)
    total = float(np.sum(off**2))
    return float(np.sum(off[1:] * off[:-1])) / total if total > 0 else 0.0
