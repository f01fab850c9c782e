"""What a diagnosis must know of an effect beside its equation and its parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scenarios.arrays import Array

Density = Callable[[Array], Array]
"""One-sided power density at frequencies f (m,) in Hz, f > 0."""


@dataclass(frozen=True)
class Traits:
    """How an effect shows in a recording, how it is told from others, and what helps.

    apart : what to do that tells it from the effects that look like it on one motion.
    remedy : what takes it away, or out of the data.
    absorbed : a fit of hard and soft iron takes it up whole, so that it shows only as a change of the given model.
    same_as : name of an effect that does the same on every motion where iron is fitted too, and that is named first.
    kin : effects of one kin are the same to first order: their forms alone, which may be in error, tell them apart.
    contains : names of simpler effects that it nearly makes too: it is one of these where it gains hardly more.
    constant : it adds one constant vector, whose change a slow wander imitates.
    one_run : an event of one run, which another run cannot show.
    slow : an offset that follows time, or one slow channel: where that only rises the one may be the other.
    lasting : a course of the whole run, which no switch begins or ends.
    memory : after it the noise of neighbouring samples is correlated.
    first_form : a fuller form that it is also looked for with, where its plain one explains too little to be found.
    converter : done by the converter to each value: seen in the values themselves, left out of a smooth prediction.
    source : a field of its own, with a part along the earth's, which no error of the attitude has.
    turns : an error of the attitude itself, which turns the field and adds nothing along it.
    fastest_nT_s : rate of change, the mean over a recording, that nature does not exceed.
    spectrum : of a slow random disturbance, its density at a level of one.
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


LATE = "late"
"""The kin of what makes a measurement follow the field late."""
IN_ITS_MOUNT = "turn the sensor in its mount, which turns its own errors and not the vehicle's"
AT_SEVERAL_RATES = (
    "turn and shake at several rates: a delay grows with the rate, a low-pass and eddy currents fall behind it"
)
WARM_AND_COOL = "let the temperature rise and fall again within one run"
THE_TRACK_AGAIN = "fly the track again at another height and heading"
LONG_AT_REST = "log a longer run at rest"
ANOTHER_INSTRUMENT = "measure the field there with another instrument, or check the attitude against a known bearing"
OTHER_THRUST = "change the thrust while the attitude is held"
"""What to do that tells effects apart which look alike on one motion."""
