"""Empirical disturbance by a channel: a polynomial without a physical law."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from sim.effects.base import ZERO3, Effect, Memory, array, frozen
from sim.effects.kernels import first_order_lag
from sim.effects.parameters import ChannelName, OneOf, Quantity, Vec3
from sim.effects.traits import Traits
from sim.state import State

Late = Literal["channel", "curve"]
HIGHEST = 3
"""The highest power of a curve: higher powers fit the ends of the channel's range without predicting them."""
LAGS_S = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)


@frozen
class ChannelEffect(Effect):
    """Curve of any channel x: ``c1 u + c2 u^2 + c3 u^3``, ``u = (x - centre) / scale``, x or the curve late by a lag.

    The effect identifies the channel, not the mechanism. Where |u| > 1 the curve continues along the tangent at the
    end. Several channels are several effects, whose curves add up.
    """

    name = "channel_effect"
    stage = "sensor"
    static = True
    example = {
        "channel": TEMPERATURE,
        "centre": 18.0,
        "scale": 4.0,
        "linear_nT": (20.0, -10.0, 30.0),
        "square_nT": (4.0, 3.0, -5.0),
        "cube_nT": (-6.0, 2.0, 1.0),
        "lag_s": 3.0,
    }
    traits = Traits(
        experiment="change the channel while all else is held",
        remedy="log the channel and take its curve off, or look for what it drives",
    )

    channel: Annotated[str, ChannelName("column of x: a recorded or simulated channel")] = ""
    centre: Annotated[float, Quantity("", -1e12, 1e12, "x at which it contributes nothing", role="fixed")] = 0.0
    scale: Annotated[float, Quantity("", 1e-12, 1e12, "x - centre that is u = 1, in the unit of x", role="fixed")] = 1.0
    order: Annotated[int, Quantity("", 1, HIGHEST, "highest power that is in use", role="fixed")] = HIGHEST
    linear_nT: Annotated[Vec3, Quantity("nT", -1e9, 1e9, "c1 of the axes x, y, z", role="linear")] = ZERO3
    square_nT: Annotated[Vec3, Quantity("nT", -1e9, 1e9, "c2 of the axes x, y, z", role="linear")] = ZERO3
    cube_nT: Annotated[Vec3, Quantity("nT", -1e9, 1e9, "c3 of the axes x, y, z", role="linear")] = ZERO3
    lag_s: Annotated[
        float, Quantity("s", 0.0, 1e5, "time constant of the lag; 0: at once", role="listed", tried=LAGS_S)
    ] = 0.0
    late: Annotated[Late, OneOf("what comes late: the channel before its curve, or the curve")] = "channel"

    def problem(self) -> str | None:
        acts = any(value != 0 for power in (self.linear_nT, self.square_nT, self.cube_nT) for value in power)
        return "it has a curve, but no channel" if acts and not self.channel else None

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if not self.channel:
            return np.zeros((len(state), 3))
        u = (state.channel(self.channel) - self.centre) / self.scale
        terms = felt(u, self.order, self.late, self.lag_s, state.interval_s, memory)
        return np.asarray(terms @ array((self.linear_nT, self.square_nT, self.cube_nT))[: self.order])

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Constant on each axis: a different value of x without contribution."""
        return np.tile(np.eye(3), (len(state), 1, 1))


def curve_of(channel: str, centre: float, scale: float, lag_s: float, late: Late) -> ChannelEffect:
    """The effect of a channel at the highest order, its coefficients zero."""
    return ChannelEffect(channel, centre, scale, HIGHEST, lag_s=lag_s, late=late)


def felt(u: Array, order: int, late: Late, lag_s: float, interval_s: float, memory: Memory) -> Array:
    """Powers (n, order) of u (n,) behind a first-order lag of u or of the powers, at rest at the start."""
    if lag_s == 0:
        return powers(u, order)
    if late == "channel":
        return powers(first_order_lag(u[:, None], lag_s, interval_s, memory)[:, 0], order)
    return first_order_lag(powers(u, order), lag_s, interval_s, memory)


def powers(u: Array, order: int) -> Array:
    """Powers 1 to `order` (n, order) of u (n,), continued along the tangents beyond -1 and 1.

    ``w^p + p w^(p-1) (u - w)``, w = u clipped to -1 and 1.
    """
    w = np.clip(u, -1.0, 1.0)
    out, lower = np.empty((len(u), order)), np.ones(len(u))
    for p in range(1, order + 1):
        out[:, p - 1] = lower * (w + p * (u - w))
        lower = lower * w
    return out
