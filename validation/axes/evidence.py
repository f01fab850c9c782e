"""Likelihood of each axis map: a condition linear in the map, its nuisance parameters, and soft iron about the map."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from validation.axes.maps import TURNS
from validation.axes.policy import AXES

ITERATIONS = 8
"""Repetitions of the estimate of the noise: each is closed."""

RIGID = 1e3
"""Weight of the map over the signal's squares in a fit without soft iron."""


@dataclass(frozen=True)
class MapEvidence:
    """What an instrument says of the 24 turns P: which are possible, and the share of the signal explained.

    possible : (24,); all, for an instrument that says nothing.
    share : share of the signal that the likeliest map explains without soft iron.
    loss : (24,) log-likelihood below the likeliest map's, nats.
    fitted, std : (24, p) fitted parameters, the map's nine elements first, and their standard deviations.
    """

    possible: NDArray[np.bool_]
    share: float
    loss: Array
    fitted: Array
    std: Array

    @property
    def best(self) -> int:
        """Return the index of the likeliest turn."""
        return int(np.argmin(self.loss))

    @property
    def silent(self) -> bool:
        """Return whether the instrument excludes nothing."""
        return bool(self.possible.all())


@dataclass(frozen=True)
class AxisCondition:
    """A condition ``F B theta = 0`` that holds for the right map, up to noise.

    moments : (pieces, f, f) second moments of the functions F. design : (24, c, f, p) B of each turn, c components.
    signal : sum of squares without any model. samples : independent rows. prior_std : (p,) of theta about (P, 0);
    infinite for a free nuisance parameter. error : least rms error of the condition over the rms signal.
    """

    moments: Array
    design: Array
    signal: float
    samples: float
    prior_std: Array
    error: float = AXES.least_error

    @property
    def tempered(self) -> AxisCondition:
        """Return the condition with at most AXES.most_samples independent rows."""
        weight = min(1.0, AXES.most_samples / self.samples)
        return replace(self, moments=weight * self.moments, signal=weight * self.signal, samples=weight * self.samples)

    @property
    def forms(self) -> Array:
        """Return the sums of squares (24, p, p) as quadratic forms of theta."""
        weighed = self.moments.sum(axis=0) @ self.design
        return np.asarray(np.einsum("hcfp,hcfq->hpq", self.design, weighed, optimize=True))

    def variance(self, forms: Array, precision: Array) -> float:
        """Return the variance of a component that the likeliest turn leaves."""
        count = self.samples * self.design.shape[1]
        variance = float(self.signal / count)
        for _ in range(ITERATIONS):
            fitted, cost = _fitted(forms, variance * precision)
            best = int(np.argmin(cost))
            squares = float(fitted[best] @ forms[best] @ fitted[best])
            variance = float(max(squares, self.error**2 * self.signal) / count)
        return variance


def evidence(given: AxisCondition) -> MapEvidence:
    """Compare the turns by likelihood, with a deviation of the map from P within the prior standard deviation."""
    given = given.tempered
    forms, precision = given.forms, 1.0 / given.prior_std**2 + 1e-9
    variance = given.variance(forms, precision)
    pull = variance * precision
    fitted, cost = _fitted(forms, pull)
    best = int(np.argmin(cost))
    loss = 0.5 * (cost - cost[best]) / variance
    std = np.sqrt(variance * np.diagonal(np.linalg.inv(forms + np.diag(pull)), axis1=1, axis2=2))
    rigid, _ = _fitted(forms, np.where(np.arange(len(pull)) < 9, RIGID * given.signal, pull))
    share = 1.0 - float(rigid[best] @ forms[best] @ rigid[best]) / given.signal
    excluded = np.zeros(len(TURNS), np.bool_)
    if share > AXES.least_share:
        excluded = (loss > AXES.rejected_nats) & _steadily_worse(given, rigid, best)
    return MapEvidence(~excluded, share, loss, fitted, std)


def _fitted(forms: Array, pull: Array) -> tuple[Array, Array]:
    """Return theta (24, p) of least ``theta' Q theta + (theta - theta_0)' L (theta - theta_0)``, and that least cost.

    forms : (24, p, p) Q of each turn. pull : (p,) diagonal of L. theta_0 = (P, 0).
    """
    start = np.zeros(forms.shape[:2])
    start[:, :9] = TURNS.reshape(-1, 9)
    fitted = np.asarray(np.linalg.solve(forms + np.diag(pull), (pull * start)[..., None])[..., 0], np.float64)
    return fitted, np.asarray(np.einsum("hp,p,hp->h", start, pull, start - fitted))


def _steadily_worse(given: AxisCondition, fitted: Array, best: int) -> NDArray[np.bool_]:
    """Return which turns (24,) leave larger residuals than the likeliest, consistently over the pieces of the log."""
    values = np.einsum("hcfp,hp->hcf", given.design, fitted)
    squares = np.einsum("hcf,bfg,hcg->hb", values, given.moments, values, optimize=True)
    worse = squares - squares[best]
    for_it, against = np.maximum(worse, 0.0).sum(axis=1), np.maximum(-worse, 0.0).sum(axis=1)
    lasting = worse.max(axis=1) < AXES.one_piece * for_it
    return np.asarray(lasting & (against < AXES.against * for_it), np.bool_)
