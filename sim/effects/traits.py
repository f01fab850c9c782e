"""Traits of an effect for a diagnosis: identifiability, look-alikes, remedy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from scenarios.arrays import Array

Density = Callable[..., Array]
"""``(f, interval_s, **listed)``: one-sided power density at frequencies f (m,) in Hz, f > 0, of a sampled disturbance
at unit level; `listed`: the listed parameters of its effect.
"""
Sign = Literal["", "lattice", "full_scale", "repeats", "outliers", "white"]
"""What the measured values themselves show of an effect, without a model of the field."""


@dataclass(frozen=True)
class Traits:
    """Identifiability of an effect in a recording, its look-alikes, and the remedy.

    experiment : action that distinguishes the effect from its look-alikes on a single motion.
    remedy : action that removes the effect, or its contribution to the data.
    absorbed : fitted hard and soft iron absorb the effect completely; only a change of the given model is observable.
    equivalent_to : effect with equal contributions on every motion where iron is fitted too; reported first.
    family : effects of one family are equal to first order; only their forms, possibly in error, distinguish them.
    contains : simpler effects that are nearly special cases; preferred where the gain over them is small.
    constant : the contribution is a constant vector, whose change a slow wander imitates.
    one_run : an event of a single run, not observable in a second run.
    slow : an offset that follows time or a slow channel; the two are confounded where the channel only rises.
    whole_run : a course of the whole run, without a begin or an end.
    correlates_noise : the noise of neighbouring samples is correlated behind the effect.
    first_form : fuller form of the first search, where the plain form explains too little for acceptance.
    converter : acts on each value in the converter: observable in the values, left out of a smooth prediction.
    field_source : a magnetic field with a part along the Earth's, in contrast to errors of the attitude.
    attitude_error : an error of the attitude, which turns the field without a part along the field.
    max_rate_nT_s : largest natural rate of change, mean over a recording.
    spectrum : density of a slow random disturbance at unit level.
    sign : structure of the measured values that shows the effect; its parameters, in order, are read from the values.
    """

    experiment: str = ""
    remedy: str = ""
    absorbed: bool = False
    equivalent_to: str = ""
    family: str = ""
    contains: tuple[str, ...] = ()
    constant: bool = False
    one_run: bool = False
    slow: bool = False
    whole_run: bool = False
    correlates_noise: bool = False
    first_form: str = ""
    converter: bool = False
    field_source: bool = False
    attitude_error: bool = False
    max_rate_nT_s: float | None = None
    spectrum: Density | None = None
    sign: Sign = ""


LATE = "late"
"""The family of delays: low-pass, latency, eddy currents."""
IN_ITS_MOUNT = "turn the sensor in its mount, which turns its own errors and not the vehicle's"
AT_SEVERAL_RATES = (
    "turn and shake at several rates: a delay grows with the rate, a low-pass and eddy currents fall behind it"
)
WARM_AND_COOL = "let the temperature rise and fall again within one run"
THE_TRACK_AGAIN = "fly the track again at another height and heading"
LONG_AT_REST = "log a longer run at rest"
ANOTHER_INSTRUMENT = "measure the field there with another instrument, or check the attitude against a known bearing"
OTHER_THRUST = "change the thrust while the attitude is held"
"""Experiments that distinguish look-alikes."""
