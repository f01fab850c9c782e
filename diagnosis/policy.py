"""The numbers that decide a diagnosis: value, meaning, measured error rate, and origin of each."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from diagnosis.effort import TUNED, Effort
from scenarios.errors import InputError
from validation.policy import number, shared


@dataclass(frozen=True)
class Policy(Effort):
    """Limits of evidence in a diagnosis, and its `Effort`; ``Policy(alpha=0.001)`` is stricter.

    Shares lie between 0 and 1; sigma is the noise of one sample; alarms are probabilities of a false alarm. Raises
    InputError for a number that is not above zero and finite.
    """

    # fmt: off
    # a scale of words: what the rules call larger, a trace, or nearly all
    larger: float = number(1.1, "factor from which on one size is larger than another: more noise than stated, a gap "
        "that names let grow, the strength by the model's iron")
    somewhat_larger: float = number(1.5, "factor up to which slow errors are those stated by the model, and the median "
        "gap beside which far samples are wrong values")
    clearly_larger: float = number(2.0, "factor from which on a size is clearly larger: slow noise over the white "
        "level, the gap by the model's iron, another unit")
    far_larger: float = number(3.0, "factor from which on a size is far larger: the gap of a misread field, the power "
        "of a part of the run, an effect over its own size",
        run="a white hand-held log: a delay of 2.6 s at a millionth of its size had 8.8 nats, its gap was 471 sigma")
    much_larger: float = number(5.0, "factor from which on a size is much larger: the axes of a motion that does not "
        "show how a heading was made, channels beside iron at rest, repeated rows over those of rounding",
        run="28 to 65 for four gliders; 1.2 to 2 for two rods on a bench, on or off: iron fits any four fields")
    tenfold: float = number(10.0, "factor beyond which an error is of no account: the attitude's beside the field's "
        "spread, a wander's beside a moved mean",
        run="an independent hand-held log: a walk of 40 nT beside an iron that was 1790 nT off")
    hardly_any: float = number(0.02, "share that is hardly there: power above a falling spectrum, a held-out gap, "
        "repeated rows, an axis of the field, survival beside attitude errors",
        run="0.042 in a quadrotor's comb survey, 0.12 in tilted circles; 0.008 in three measured flights, 0.001 level; "
        "level circles with errors of 0.02 degrees: 1e-4 to 6e-3 of false names; true ones of tuning seeds 216 to 218 "
        "from 0.06 on")
    trace: float = number(0.05, "share below which something is a trace: the gap an effect adds in coloured noise, a "
        "vector left, what is left where an effect acts, a step of rounding over the noise, a level part of the field, "
        "the strength's change at rest",
        run="measured logs: 0.004 to 0.018 for four gliders with pitch and roll, 0.14 for torque rods at rest; bursts "
        "of noise leave 0.08 to 0.9 of what an effect takes, magnets that come within a second 0.0007 to 0.024")
    little: float = number(0.1, "share below which little is left: survival beside the iron, errors along the field, "
        "repeated attitudes, a channel beside time, a second axis at rest",
        run="tuning seeds: a clock's errors in a hand 0.09, spikes 0.5; an error of the attitude half its angle")
    fair_share: float = number(0.2, "share that counts: of the gap explained by names, of an effect in the held-out "
        "part, of outliers that are no failures, of an interval that an attitude is late",
        run="tuning seeds 0 and 1 of the bench: dipoles passed once, in 10 s, were explained to 0 or 99 % by chance; "
        "eddy currents of 1.5 ms at 10 Hz, uneven by a sixth, passed for an attitude 1.51 ms late; logs had 40 ms")
    quarter: float = number(0.25, "share of itself that a part keeps to be of the same kind: a channel in the "
        "residual, slow noise beside an effect, a rise in the spectrum, the scatter of spikes of one size",
        run="tuning seed 1: beside a core that saturates a motor's current keeps 0.3 to 0.5")
    half: float = number(0.5, "share above which most is there: of its evidence kept by a look-alike, of its size kept "
        "by a second effect, of the first channel's share, of a curve's or a compass' gap, of power between means, of "
        "a lateness, of variance explained at rest",
        run="a gradient of second order on a dive: a day's change of 0.95 sigma alone had 0.16 beside a gradient; four "
        "payloads of three tones on an AUV: two ripples left half of the gap, the curve a hundredth; measured logs: "
        "0.17 for a glider's own compass; 0.61 to 1.6 for ten logs with an optical heading; a measured quadrotor's "
        "attitude of 10 Hz: 25 ms by its gyro, 20 ms by the field, in rows of 8 ms")
    nearly_all: float = number(0.9, "share above which nearly all is there: of a difference explained by one factor, "
        "of a heading kept, of a course followed by another",
        run="a trial before this program: depth and temperature could not be told apart above it")
    far_sigma: float = number(5.0, "standard deviations beyond which a value is far off: beside a spike, in a row, "
        "from the course of its neighbours, in a run of innovations",
        run="loops of 100 nT on a turntable that rests, an attitude that errs by 0.01 to 0.05 degrees: 11 to 69 nats "
        "from the samples as they are")
    never_sigma: float = number(8.0, "deviations white noise never has: wrong values, an outlier of a fit, a kurtosis")
    test_alarm: float = number(1e-3, "probability of white noise to fail a test: of means, a band, its correlation")
    spectrum_alarm: float = number(1e-4, "probability of white noise to show a tone, or a spectrum that rises",
        alarms="8 of 20 000 white residuals of 6000 samples on three axes showed a tone: 4e-4; 2 of 20 000 white "
        "residuals of 6000 samples on three axes; none of 4000 each that were louder now and then, fell with "
        "frequency, or had gaps; none of 101 nulls of the bench, white and coloured, tuning seed 99",
        run="tuning seeds 0 and 1 of the bench: found in all 12 ripples of the noise's size and more, whose second "
        "harmonic is 0.03 to 0.3 % of the gap, on the spectrum's lines and between them; in none of 12 white nulls; "
        "tuning seed 99: of 404 trials 15 measured rests and three ripples that were left out of the library, all "
        "unknown or partial without it")

    # the reference, the motion, and the axes of the sensor
    still_spread: float = shared("still_spread")
    still_rate: float = number(0.02, "mean rate in rad/s above which a sensor turns")
    compass_noise: float = number(0.6, "noise towards magnetic east over the least of others: below, a heading is this "
        "sensor's own",
        run="measured logs: 0.41 for a glider's own compass; 1.06 to 1.97 for ten logs with an optical heading")
    earth_gradient_nT_m: float = number(0.005, "change of the Earth's own field along a level path",
        run="IGRF at 40 places: 1.6 to 13 nT/km, 5.3 in the median")
    turned_axes_deg: float = number(20.0, "largest angle of a sensor's fitted turn to a permutation that is reported")
    mount_share: float = number(0.99, "share of a change of the iron explained by a turn of the attitude's axes, above "
        "which the change is a turn", alarms="none of 100 000 soft irons drawn evenly up to 6 %; the nearest had 0.988",
        run="a hand and a boat, 3.9 degrees beside 6 % of iron")
    least_path_m: float = number(2.0, "shortest path along which the field may differ: navigation at rest wanders 1 m",
        run="catalogue scenarios: 3 m left out a quadrotor that calibrates on the spot")
    nearest_place_m: float = number(0.5, "distance to the path below which a dipole would be on the sensor")
    farthest_place_m: float = number(60.0, "distance from which on the field of a dipole is a gradient")

    # direct evidence
    same_step: float = number(0.01, "relative difference up to which a step is the model's own")
    same_full_scale: float = number(1e-3, "relative difference up to which a full scale is the model's own")
    least_spikes: int = number(3, "single wrong values from which on they are an effect")
    most_burst: int = number(4, "samples in a row that a burst of wrong values lasts at most")

    # effects in white noise, and look-alikes
    alpha: float = number(0.01, "probability of a false name: ln(names / alpha) nats name, ln(1 / alpha) tell apart",
        alarms="0.1 to 0.3 % of white noise (benchmarks.diagnosis.false_names); 5 of 1200 nulls, seeds 2008 to 2053",
        run="tuning seeds 0 and 1 of the bench: without counting the names 2 of 120 white nulls were named")
    same_size: float = number(0.01, "difference of ln(fitted size / own size) up to which neither delay nor low-pass "
        "is nearer",
        run="tuning seed 3: both come out within 0.0004 of their own sizes, and gain the same within 0.05 nats")
    least_loop: float = number(20.0, "least threshold in times the noise, where the field's course is itself measured",
        run="a white log of a rover without attitude: a loop of 1.7 times the noise had 9.9 nats")
    search_price_odds: float = number(2.0, "the best of n searched settings is priced at odds of 1 in this times n")
    window_share: float = number(0.75, "part of a window's evidence that no effect of the whole run may reach")
    same_gain: float = number(1e-6, "relative difference up to which two effects gain the same; the first is named",
        run="tuning seeds 0 and 1: the gains of hard iron and sensor offset differ by rounding alone")
    same_family: float = number(0.03, "as same_coloured, within a family in white noise: the gain of a form error",
        run="a trial before this program")
    same_constant: float = number(0.007, "as same_coloured, of a simpler effect contained in the best, in white noise",
        run="tuning seed 14: an error of the field that grows by 2 % on the way, 0.002 behind a gradient from afar; a "
        "gradient of 3 nT/m from 250 m on a hover leads a constant by 0.021")
    same_iron: float = number(1e-3, "part of the evidence of a change of iron within which an effect is a look-alike",
        run="level spirals: an error of the field of 33 sigma gains 1e-6 less, by the second order of both")
    form_share: float = number(0.15, "part of the first effect's size below which a further effect is its form error",
        run=TUNED)
    same_form_share: float = number(0.35, "as form_share, for an effect accepted before, or like the first", run=TUNED)
    sure_nats: float = number(50.0, "evidence from which a named effect stays, however small its share of the gap, if "
        "the residual is noise",
        run="independent recordings: 28 at most in 67 coloured nulls; 55 to 271 of effects of 0.1 and 0.3 sigma beside "
        "attitudes that walk and waves of up to 0.8")

    # iron and effects jointly, without attitude
    matrix_prior: float = number(0.25, "standard deviation of the iron's matrix about the unit matrix")
    offset_prior: float = number(0.5, "standard deviation of the iron's offset about zero, in strengths of the field",
        run="level turns with a current of 2000 nT: with 4 the offset went to three times the field")
    fastest_turn: float = number(6.0, "median rate in rad/s beyond which a field without attitude or gyro is in no "
        "sensor that turns",
        run="4.2 for a hand in a hurry; 7 to 9 for magnets that a wheel turns beside a satellite's sensor at rest")

    # coloured noise
    coloured_nats: float = number(25.0, "evidence above which an effect is accepted in coloured noise",
        run="a trial before this program: 7.5 nats gave false names")
    same_coloured: float = number(0.12, "part of the best's evidence within which a useless candidate is a look-alike, "
        "in coloured noise", run="a trial before this program")
    same_family_coloured: float = number(0.45, "as same_coloured, within a family in coloured noise",
        run="a hand-held optical log: its delay of 15 ms gains 0.57 to 0.70 of what nine free columns do")
    one_cause: float = number(0.97, "share of a slow course's power common to all axes, above which the course is a "
        "cause and no noise",
        run="tuning seeds 920 to 931: 0.57 to 0.93 of three noises of f^-3, 0.999 and more of drifts and temperatures")
    along_share: float = number(0.65, "share of the structure along the field explained by a source, above which no "
        "wander makes it",
        run="independent storms 0.74 to 0.88; a day's change in flicker noise beside an attitude that wanders 0.36")
    least_along_field: float = number(0.12, "share of slow power along the field below which it is a turn of the "
        "attitude; three equal axes have 1/3")
    least_noise_lines: float = number(30.0, "frequencies at which slow noise must stand out to be identified",
        run=TUNED)

    # several recordings
    alpha_pooled: float = number(0.001, "as alpha, for several recordings: coefficients predicted by the others")
    not_transferred_alarm: float = number(0.05, "probability of equal coefficients to differ as much between "
        "recordings as differing ones",
        alarms="4 of 196 lots of three with equal coefficients, white and coloured: see scatter_parts")
    same_coefficient: float = number(0.04, "share of an effect by which its form is in error from motion to motion")

    # what is told of the gap and of parameters
    part_price: float = number(4.0, "price of a further part, over ln(cells), in squares of the cells' noise")
    tail_excess: float = number(0.1, "excess kurtosis that is of no account in any long recording")
    least_channel_share: float = number(0.003, "share of the gap from which on a channel is listed")
    open_eigenvalue: float = number(1e-5, "eigenvalue of the parameters' correlation below which their combination is "
        "undetermined",
        run="an error of the field beside fitted iron, whose part along the field is open: 3e-13 to 9e-7, by the steps "
        "of the derivative")
    open_part: float = number(1e-3, "part of a parameter in such a combination from which on the parameter has no "
        "interval", run=TUNED)
    # fmt: on

    def __post_init__(self) -> None:
        for name, value in self.numbers().items():
            if not (np.isfinite(value).all() and (np.asarray(value) > 0).all()):
                raise InputError(f"{value!r} is not above zero and finite", where=f"policy: {name}")

    @property
    def apart(self) -> float:
        """Difference of nats that distinguishes two candidates: ``ln(1 / alpha)``."""
        return math.log(1 / self.alpha)

    def accepted_pooled(self, names: int) -> float:
        """Nats needed as in `accepted`, for several recordings together: ``ln(names / alpha_pooled)``."""
        return math.log(names / self.alpha_pooled)

    def accepted(self, names: int) -> float:
        """Nats of evidence above which the best of `names` effects is accepted: ``ln(names / alpha)``."""
        return math.log(names / self.alpha)

    def numbers(self) -> dict[str, float | tuple[float, ...]]:
        """All numbers by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}


STANDARD = Policy()
"""Default policy of a diagnosis."""


def changed(policy: Policy, assignments: Iterable[str]) -> Policy:
    """A policy with numbers set by texts ``name=value`` (``name=1,4,16`` for several).

    Raises InputError for an unknown name, or a value of another kind.
    """
    values, given = dict[str, Any](), policy.numbers()
    for text in assignments:
        name, _, value = text.partition("=")
        if name not in given:
            raise InputError(f"{name!r} is no number of the policy", where="--set", do="one of " + ", ".join(given))
        several = isinstance(like := given[name], tuple)
        kind = type(like[0] if isinstance(like, tuple) else like)
        try:
            parts = tuple(map(kind, value.split(",") if several else [value]))
        except ValueError as e:
            raise InputError(f"{value!r} is no {kind.__name__}", where=f"--set {name}") from e
        values[name] = parts if several else parts[0]
    return replace(policy, **values)
