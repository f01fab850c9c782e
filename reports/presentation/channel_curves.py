"""Fitted curves of channels (effect `channel_effect`) with their 95 % bands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from diagnosis.result import NORMAL_95, Diagnosis, EvidenceKind, NamedEffect
from reports.presentation.series import block_length, block_means
from scenarios.arrays import Array
from sim.effects.channels import ChannelEffect, felt, powers

MOST_DOTS, POINTS = 1500, 200
"""Points of the data's cloud, and of a curve."""


@dataclass(frozen=True)
class ChannelCurve:
    """A curve against its channel: curve_nT (m, 3) about its middle, half_nT (m, 3): half its 95 % band.

    dots: block means of the lagged channel (k,) and of the gap without the curve (k, 3) in nT; None without attitude,
    and for a lag after the curve: the contribution is then no function of the channel's value.
    """

    label: str
    channel: Array
    curve_nT: Array
    half_nT: Array
    dots: tuple[Array, Array] | None

    @classmethod
    def of(cls, cause: NamedEffect, diagnosis: Diagnosis) -> Self:
        """Compute curve and band: ``half^2 = 1.96^2 t^T C t``, t the powers of u and C the covariance of an axis."""
        effect = cause.effect
        assert isinstance(effect, ChannelEffect)
        u, beta = np.linspace(-1, 1, POINTS), effect.coefficients().reshape(-1, 3)
        terms, shape = powers(u, len(beta)), (len(beta), 3, len(beta), 3)
        covariance = np.zeros(shape) if cause.covariance is None else cause.covariance.reshape(shape)
        half_nT = NORMAL_95 * np.sqrt(np.maximum(np.einsum("mi,iaja,mj->ma", terms, covariance, terms), 0.0))
        label = effect.channel + (f", {effect.lag_s:.3g} s late" if effect.lag_s else "")
        return cls(label, effect.centre + effect.scale * u, terms @ beta, half_nT, _dots(diagnosis, effect))


def channel_curves(diagnosis: Diagnosis) -> tuple[ChannelCurve, ...]:
    """Return the curves of all channels that stand for names."""
    return tuple(ChannelCurve.of(cause, diagnosis) for cause in diagnosis.of_kind(EvidenceKind.CURVE))


def _dots(diagnosis: Diagnosis, effect: ChannelEffect) -> tuple[Array, Array] | None:
    problem = diagnosis.problem
    if problem.mode != "vector" or (effect.lag_s and effect.late == "curve"):
        return None
    state = problem.state
    u = (state.channel(effect.channel) - effect.centre) / effect.scale
    x = effect.centre + effect.scale * felt(u, 1, effect.late, effect.lag_s, state.interval_s, {})[:, 0]
    own = effect.apply(state, state.field_nT, np.random.default_rng(0), {})
    length = block_length(len(x), MOST_DOTS)
    return block_means(x, length), block_means(diagnosis.after_nT + own, length, problem.usable)
