"""Cramer-Rao bound: least standard deviations of any unbiased method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.bound.experiment import Experiment
from validation.bound.information import INVOLVED, SINGULAR, Information
from validation.bound.knowledge import KNOWLEDGE


@dataclass(frozen=True, eq=False)
class Bound:
    """Cramer-Rao bound of the offset b and of S times the strength F, both in nT.

    scale : (k, k), transformation of the errors, dp -> scale dp; None for the identity. Without the strength the trace
    of S is fixed, S (1 - tr dS / tr S) + dS, since S / a and a F give equal measurements.
    """

    knowledge: str
    strength_nT: float
    information: Information
    scale: Array | None = None

    @classmethod
    def of(cls, known: Experiment, knowledge: str, *, strength_known: bool = True) -> Bound:
        """Return the bound of an experiment with knowledge of the field, a key of KNOWLEDGE.

        Raises InputError if the field's vector is known but the strength is not.
        """
        information = KNOWLEDGE[knowledge](known)
        if strength_known:
            return cls(knowledge, known.strength_nT, information)
        if information.includes_rotation:
            what = "a known field vector has a known strength"
            raise InputError(what, where="--strength-unknown", do="ask with --knowledge norm or norm+gyro")
        return cls(knowledge, known.strength_nT, information, _fixed_trace(known.matrix, information))

    def shared_with(self, others: Sequence[Bound]) -> Bound:
        """Return the bound for equal times of several experiments: the mean information."""
        mean = np.mean([one.information.matrix for one in (self, *others)], axis=0)
        return replace(self, information=replace(self.information, matrix=mean))

    def variance(self, figures: Array) -> Array:
        """Return the variance (n,) of figures G p, G (n, k) per nT; infinite for unobservable figures."""
        observed, unobserved = self._split
        finite = np.asarray(np.isfinite(figures).all(axis=1))
        criterion = np.where(finite[:, None], figures, 0.0)
        criterion = criterion if self.scale is None else criterion @ self.scale
        share = criterion / self._size
        lost = np.sum((share @ unobserved) ** 2, axis=1) > INVOLVED * np.sum(share**2, axis=1)
        return np.where(lost | ~finite, np.inf, np.einsum("ni,ij,nj->n", criterion, observed, criterion, optimize=True))

    @cached_property
    def covariance(self) -> Array:
        """Return the covariance (k, k) in nT^2, with infinite variance of unobservable parameters."""
        observed, each = self._split[0], np.eye(len(self.information.matrix))
        covariance = observed if self.scale is None else self.scale @ observed @ self.scale.T
        return np.asarray(covariance - np.diag(np.diag(covariance)) + np.diag(self.variance(each)))

    @property
    def offset_std_nT(self) -> Array:
        """Return the standard deviation (3,) of each component of the offset."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[:3]))

    @property
    def offset_rms_nT(self) -> float:
        """Return the rms length of the offset's error."""
        return float(np.sqrt(np.sum(self.offset_std_nT**2)))

    @property
    def matrix_std(self) -> Array:
        """Return the standard deviation (3, 3) of the entries of S."""
        std = np.full((3, 3), np.nan)
        for (i, j), value in zip(self.information.places, np.sqrt(np.diag(self.covariance)[3:]), strict=True):
            std[i, j] = value / self.strength_nT
        return np.where(np.isnan(std), std.T, std)

    @cached_property
    def _split(self) -> tuple[Array, Array]:
        """Return the covariance (k, k) of the observable part, and unobservable scaled directions (k, m)."""
        units = np.outer(self._size, self._size)
        values, vectors = np.linalg.eigh(self.information.matrix / units)
        observed = values > SINGULAR * values[-1]
        covariance = (vectors[:, observed] / values[observed]) @ vectors[:, observed].T / units
        return np.asarray(covariance), np.asarray(vectors[:, ~observed])

    @property
    def _size(self) -> Array:
        """Return the scale (k,) of the parameters: inverse standard deviation of each with all others known."""
        size = np.sqrt(np.diag(self.information.matrix))
        return np.where(size > 0, size, 1.0)


def _fixed_trace(matrix: Array, information: Information) -> Array:
    """Return I - s t^T / tr S (k, k): s holds the entries of S, t is 1 on the diagonal of S."""
    entries = np.array([0.0] * 3 + [matrix[i, j] for i, j in information.places])
    diagonal = np.array([0.0] * 3 + [float(i == j) for i, j in information.places])
    return np.asarray(np.eye(len(entries)) - np.outer(entries, diagonal) / np.trace(matrix))
