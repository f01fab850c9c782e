"""Paired comparison of two models on held-out legs: gain and confidence interval."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from calib.held_out.legs import LEAST_LEGS, LegPartition
from calib.held_out.models import Model
from calib.numerics.paired import counted, mean_interval
from scenarios.arrays import Array

Verdict = Literal["worth_it", "as_well", "worse", "cannot_tell"]
ROUNDING = 1e-9
"""Least error over the field; smaller errors are rounding."""
SAME = 0.05
"""Half width of the interval over the simpler model's error within which models predict equally well."""
MATTERS = 5e-4
"""Least error over the field that a richer model must explain, sqrt(e^2 - e'^2), unless the gain exceeds SAME of the
error: 0.07 degrees of heading at a dip of 64 degrees. In many samples an explained error of a hundredth of the noise
is significant: without any eddy currents, noise in the field that they are computed from gains 0.3 nT of 150."""


@dataclass(frozen=True, eq=False)
class HeldOutErrors:
    """Errors of a model on held-out legs: rms (legs,) and means (legs, c) of each leg in nT; the field's strength."""

    model: Model
    rms_nT: Array
    mean_nT: Array
    strength_nT: float

    @classmethod
    def of(cls, model: Model, legs: LegPartition, strength_nT: float) -> HeldOutErrors:
        """Predict each leg with parameters fitted to all other legs."""
        errors = [strength_nT * one for one in model.unseen(legs)]
        rms = np.array([max(np.sqrt(np.mean(one**2)), ROUNDING * strength_nT) for one in errors])
        return cls(model, rms, np.array([one.mean(axis=0) for one in errors]), strength_nT)

    @property
    def typical_nT(self) -> float:
        """Return the mean of the legs' rms."""
        return float(self.rms_nT.mean())


@dataclass(frozen=True, eq=False)
class ModelPair:
    """Simpler and richer model on equal legs.

    d_j = e_j - e'_j of leg j's rms errors; the gain is the mean of d, with Student's t interval over the effective
    number of legs, which is smaller for correlated neighbours.

    doubt : reason against the richer model despite a gain, as the end of a sentence; "" for none
    """

    simpler: HeldOutErrors
    richer: HeldOutErrors
    doubt: str = ""

    @property
    def gain_nT(self) -> Array:
        """Return the gain of each leg (legs,)."""
        return np.asarray(self.simpler.rms_nT - self.richer.rms_nT)

    @property
    def better_nT(self) -> float:
        """Return the mean gain; negative if the richer model predicts worse."""
        return float(self.gain_nT.mean())

    @cached_property
    def counted(self) -> float:
        """Return the effective number of legs, less for correlated neighbours, in the gain and the mean errors."""
        return counted(self.gain_nT[:, None], self.richer.mean_nT)

    @cached_property
    def interval_nT(self) -> tuple[float, float]:
        """Return the 95 % interval of the gain; infinite for too few legs."""
        return mean_interval(self.gain_nT, self.counted if len(self.gain_nT) >= LEAST_LEGS else 0.0)

    @property
    def kept(self) -> HeldOutErrors:
        """Return the richer model's errors if the gain is significant, else the simpler model's."""
        return self.richer if self.verdict == "worth_it" else self.simpler

    @property
    def matters(self) -> bool:
        """Return whether the gain is a part of the error, or the explained error a part of the field."""
        simpler, richer = self.simpler.typical_nT, self.richer.typical_nT
        explained = np.sqrt(max(simpler**2 - richer**2, 0.0))
        return bool(simpler - richer > SAME * simpler or explained > MATTERS * self.simpler.strength_nT)

    @property
    def verdict(self) -> Verdict:
        """Return better or worse by the interval, equal for a gain that does not matter, else undecided."""
        low, high = self.interval_nT
        if low > 0 and self.matters:
            return "cannot_tell" if self.doubt else "worth_it"
        if low > 0:
            return "as_well"
        if high < 0:
            return "worse"
        return "as_well" if max(-low, high) <= SAME * self.simpler.typical_nT else "cannot_tell"
