"""Plots of fitted curves of channels (effect `channel_effect`)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from diagnosis.decision.sentence import channel_curves
from diagnosis.result import NORMAL_95, Diagnosis, NamedEffect
from reports.gap_series import block_length, block_means
from reports.palette import RAW, XYZ
from reports.plots.style import panels
from scenarios.arrays import Array
from sim.effects.channels import ChannelEffect, felt, powers

MOST_POINTS, POINTS = 1500, 200
"""Points of the data's cloud, and of a curve."""


def draw_curves(diagnosis: Diagnosis) -> Figure:
    """Draw each curve with its 95 % band against the channel, a panel per sensor axis; dots: gap without the curve.

    Dots are drawn with attitude only, and not for a lag after the curve: the contribution is then no function of the
    channel's value.
    """
    several = channel_curves(diagnosis)
    figure, rows = panels(2.6 * len(several) + 0.3, len(several), 3, sharey="row", squeeze=False)
    for row, one in zip(rows, several, strict=True):
        assert isinstance(one.effect, ChannelEffect)
        x, curve_nT, half_nT = band(one.effect, one)
        dots = _dots(diagnosis, one.effect)
        for a, axis in enumerate(row):
            if dots is not None:
                axis.plot(dots[0], dots[1][:, a], ".", markersize=2, color=RAW, alpha=0.4, zorder=1)
            _draw(axis, x, curve_nT[:, a], half_nT[:, a], XYZ[a])
            axis.set_xlabel(one.effect.channel + (f", {one.effect.lag_s:.3g} s late" if one.effect.lag_s else ""))
            axis.set_title("xyz"[a])
        row[0].set_ylabel("nT")
    return figure


def band(effect: ChannelEffect, one: NamedEffect) -> tuple[Array, Array, Array]:
    """Return channel (m,), curve (m, 3) in nT about its middle, and half the curve's 95 % band (m, 3).

    ``half^2 = 1.96^2 t^T C t``, t the powers of u and C the covariance of the coefficients of an axis.
    """
    u = np.linspace(-1, 1, POINTS)
    terms = powers(u, len(effect.coefficients()) // 3)
    curve_nT = terms @ effect.coefficients().reshape(-1, 3)
    half = np.zeros_like(curve_nT)
    if one.covariance is not None:
        for a in range(3):
            variance = np.einsum("mi,ij,mj->m", terms, one.covariance[a::3, a::3], terms)
            half[:, a] = NORMAL_95 * np.sqrt(np.maximum(variance, 0.0))
    return effect.centre + effect.scale * u, curve_nT, half


def _draw(axis: Any, x: Array, curve: Array, half: Array, colour: str) -> None:
    axis.fill_between(x, curve - half, curve + half, color=colour, alpha=0.3, linewidth=0)
    axis.plot(x, curve, color=colour, linewidth=2.0, zorder=2)


def _dots(diagnosis: Diagnosis, effect: ChannelEffect) -> tuple[Array, Array] | None:
    """Return the lagged channel (m,) and the gap (m, 3) in nT without the curve's correction, as block means."""
    problem = diagnosis.problem
    if problem.mode != "vector" or (effect.lag_s and effect.late == "curve"):
        return None
    state = problem.state
    u = (state.channel(effect.channel) - effect.centre) / effect.scale
    x = effect.centre + effect.scale * felt(u, 1, effect.late, effect.lag_s, state.interval_s, {})[:, 0]
    own = effect.apply(state, state.field_nT, np.random.default_rng(0), {})
    length = block_length(len(x), MOST_POINTS)
    return block_means(x, length), block_means(diagnosis.after_nT + own, length, problem.usable)
