"""The bound: the least standard deviations that any unbiased method can reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from validation.bound.experiment import Experiment
from validation.bound.information import KNOWLEDGE, Information

Array = NDArray[np.float64]
SINGULAR = 1e-11
"""Eigenvalue of the information, in units of its largest with every parameter in units of its own, that is rounding:
the motion says nothing in that direction."""
INVOLVED = 1e-4
"""Share of such a direction from which a parameter is part of it."""


@dataclass(frozen=True, eq=False)
class Bound:
    """Covariance (k, k), nT^2, of offset and S times the strength; infinite where the motion says nothing."""

    knowledge: str
    strength_nT: float
    information: Information
    covariance: Array

    @classmethod
    def of(cls, known: Experiment, knowledge: str) -> Bound:
        """The Cramer-Rao bound of an experiment with what is known of the field."""
        return cls._with(knowledge, known.strength_nT, KNOWLEDGE[knowledge](known))

    def shared_with(self, others: Sequence[Bound]) -> Bound:
        """The bound when equal parts of the time are spent on this experiment and others: the mean information."""
        mean = np.mean([one.information.matrix for one in (self, *others)], axis=0)
        return self._with(self.knowledge, self.strength_nT, replace(self.information, matrix=mean))

    @classmethod
    def _with(cls, knowledge: str, strength_nT: float, information: Information) -> Bound:
        return cls(knowledge, strength_nT, information, _inverse(information.matrix))

    @property
    def offset_std_nT(self) -> Array:
        """Standard deviation (3,) of each component of the offset."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[:3]))

    @property
    def offset_rms_nT(self) -> float:
        """Rms length of the offset's error, all three components together."""
        return float(np.sqrt(np.sum(self.offset_std_nT**2)))

    @property
    def matrix_std(self) -> Array:
        """Standard deviation (3, 3) of the entries of S, without unit."""
        std = np.full((3, 3), np.nan)
        for (i, j), value in zip(self.information.places, np.sqrt(np.diag(self.covariance)[3:]), strict=True):
            std[i, j] = value / self.strength_nT
        return np.where(np.isnan(std), std.T, std)


def _inverse(information: Array) -> Array:
    """The inverse, every parameter scaled to one first; infinite for parameters of a direction without information."""
    size = np.sqrt(np.diag(information))
    size = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(information / np.outer(size, size))
    told = values > SINGULAR * values[-1]
    covariance = (vectors[:, told] / values[told]) @ vectors[:, told].T / np.outer(size, size)
    lost = np.any(vectors[:, ~told] ** 2 > INVOLVED, axis=1)
    covariance[np.diag_indices_from(covariance)] = np.where(lost, np.inf, np.diag(covariance))
    return np.asarray(covariance)
