"""Likelihood of each axis map: a condition linear in the map, its nuisance parameters, and soft iron about the map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from validation.axes.maps import TURNS
from validation.axes.policy import AXES

ITERATIONS = 4
"""Repetitions of the estimate of the noise: each is closed."""

RIGID = 1e3
"""Weight of the map over the signal's squares in a fit without soft iron."""


@dataclass(frozen=True)
class Evidence:
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


def evidence(
    moments: Array, design: Array, signal: float, samples: float, prior_std: Array, error: float = AXES.least_error
) -> Evidence:
    """Compare the turns by the sum of squares of ``F B theta``.

    moments : (pieces, f, f) second moments of the functions F. design : (24, c, f, p) B of each turn, c components.
    signal : sum of squares without any model. samples : independent rows. prior_std : (p,) of theta about (P, 0);
    infinite for a free nuisance parameter. error : least rms error of the condition over the rms signal.
    """
    weight = min(1.0, AXES.most_samples / samples)
    moments, signal = weight * moments, weight * signal
    total = moments.sum(axis=0)
    forms = np.einsum("hcfp,hcfq->hpq", design, total @ design, optimize=True)
    count = weight * samples * design.shape[1]
    precision = 1.0 / prior_std**2 + 1e-9
    variance = signal / count
    for _ in range(ITERATIONS):
        fitted, cost = _fitted(forms, variance * precision)
        best = int(np.argmin(cost))
        squares = float(fitted[best] @ forms[best] @ fitted[best])
        variance = max(squares, error**2 * signal) / count
    std = np.sqrt(variance * np.diagonal(np.linalg.inv(forms + np.diag(variance * precision)), axis1=1, axis2=2))
    loss = 0.5 * (cost - cost[best]) / variance
    rigid, _ = _fitted(forms, np.where(np.arange(len(prior_std)) < 9, RIGID * signal, variance * precision))
    share = 1.0 - float(rigid[best] @ forms[best] @ rigid[best]) / signal
    if not share > AXES.least_share:
        return Evidence(np.ones(len(TURNS), np.bool_), share, loss, fitted, std)
    excluded = (loss > AXES.rejected_nats) & _steadily_worse(moments, design, rigid, best)
    return Evidence(~excluded, share, loss, fitted, std)


def _fitted(forms: Array, pull: Array) -> tuple[Array, Array]:
    """Return theta (24, p) of least ``theta' Q theta + (theta - theta_0)' L (theta - theta_0)``, and that least cost.

    forms : (24, p, p) Q of each turn. pull : (p,) diagonal of L. theta_0 = (P, 0).
    """
    start = np.zeros(forms.shape[:2])
    start[:, :9] = TURNS.reshape(-1, 9)
    fitted = np.asarray(np.linalg.solve(forms + np.diag(pull), (pull * start)[..., None])[..., 0], np.float64)
    return fitted, np.asarray(np.einsum("hp,p,hp->h", start, pull, start - fitted))


def _steadily_worse(moments: Array, design: Array, fitted: Array, best: int) -> NDArray[np.bool_]:
    """Return which turns (24,) leave larger residuals than the likeliest, consistently over the pieces of the log."""
    values = np.einsum("hcfp,hp->hcf", design, fitted)
    squares = np.einsum("hcf,bfg,hcg->hb", values, moments, values, optimize=True)
    worse = squares - squares[best]
    for_it, against = np.maximum(worse, 0.0).sum(axis=1), np.maximum(-worse, 0.0).sum(axis=1)
    lasting = worse.max(axis=1) < AXES.one_piece * for_it
    return np.asarray(lasting & (against < AXES.against * for_it), np.bool_)
