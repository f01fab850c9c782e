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

    # the linear problem
    held_attitude: float = number(0.1, "share of repeated attitudes above which their derivative is no rate")
    still_spread: float = shared("still_spread")
    still_share: float = number(0.5, "share of the field's variance that channels explain at rest at least")
    still_strength: float = number(
        0.05, "rms of the strength over the field's, with fitted iron, below which a sensor turns",
        run="measured logs: 0.004 to 0.018 for four gliders with pitch and roll, 0.14 for torque rods at rest",
    )  # fmt: skip
    still_residual: float = number(
        5.0, "residual of channels over residual of such iron, of the strength, below which a sensor is at rest",
        run="28 to 65 for four gliders; 1.2 to 2 for two rods on a bench, on or off: iron fits any four fields",
    )  # fmt: skip
    still_line: float = number(
        0.1, "second axis of the field's spread over the first below which the field moves on a line, as by one coil"
    )
    still_rate: float = number(0.02, "mean rate in rad/s above which a sensor turns")
    held_rows: float = number(0.02, "share of repeated rows from which on repeated rows are no measurements")
    held_odds: float = number(5.0, "times that rounding alone explains so many repeated rows")
    least_lead: float = number(
        0.2, "intervals of a sample by which the attitude is late at least; less is an eddy current of the usual size",
        run="eddy currents of 1.5 ms at 10 Hz, uneven by a sixth, passed for an attitude 1.51 ms late; logs had 40 ms",
    )  # fmt: skip
    same_lateness: float = number(
        0.5, "relative difference up to which a gyro gives the attitude the same lateness as the field does",
        run="a measured quadrotor's attitude of 10 Hz: 25 ms by its gyro, 20 ms by the field, in rows of 8 ms",
    )  # fmt: skip
    base_outlier: float = number(
        8.0, "medians of the residual beyond which a sample is left out of the first fit of iron"
    )
    most_base_outliers: float = number(
        0.2, "share of such samples above which the samples are a gap, not failures, and stay"
    )

    # is the reference wrong?
    misread_gap: float = number(
        3.0, "factor by which another reading of the given field, or of the attitude's time, lowers the gap if right"
    )
    compass_noise: float = number(
        0.6, "noise towards magnetic east over the least of others below which a heading is this magnetometer's own",
        run="measured logs: 0.41 for a glider's own compass; 1.06 to 1.97 for ten logs with an optical heading",
    )  # fmt: skip
    compass_gap: float = number(
        0.5, "as compass_noise, of the whole gap, which must hold as well",
        run="measured logs: 0.17 for a glider's own compass; 0.61 to 1.6 for ten logs with an optical heading",
    )  # fmt: skip
    compass_condition: float = number(
        5.0, "ratio of its axes to the calibration's above which a motion does not determine how a heading was made"
    )
    least_level: float = number(
        0.05, "level part of a given field over its strength below which there is no dip to compare: 87 degrees"
    )
    earth_gradient_nT_m: float = number(
        0.005, "change of the Earth's own field along a level path",
        run="IGRF at 40 places: 1.6 to 13 nT/km, 5.3 in the median",
    )  # fmt: skip
    turned_axes_deg: float = number(
        20.0,
        "angle between the fitted turn of a sensor and a permutation of axes up to which the permutation is reported",
    )
    mount_share: float = number(
        0.99,
        "share of a change of the iron explained by a turn of the attitude's axes, above which the change is a turn",
        alarms="none of 100 000 soft irons drawn evenly up to 6 %; the nearest had 0.988",
        run="a hand and a boat, 3.9 degrees beside 6 % of iron",
    )  # fmt: skip
    shown_axis: float = number(
        0.02,
        "spread of the field along its least direction over its strength from which on an axis' sign is known",
        run="0.042 in a quadrotor's comb survey, 0.12 in tilted circles; 0.008 in three measured flights, 0.001 level",
    )
    shown_beside_attitude: float = number(
        10.0,
        "spread of the field along a direction over what the stated error of the attitude turns it by, from which on a "
        "fitted matrix holds along it: an error of a tenth leaves 0.99 of a coefficient",
    )
    other_iron: float = number(
        1.1,
        "residual of the strength by the model's iron over that by fitted iron, above which both differ",
    )
    unfit_iron: float = number(
        2.0, "as other_iron, of all compared quantities, from which on a remark is made where no effect is named"
    )
    scale_share: float = number(
        0.9, "share of the difference explained by a factor alone, above which the strength is wrong"
    )

    # blocks and splits
    least_held: float = number(
        0.2, "share of the accepted effects shown by the segments held out for the final gap, two fifths of the run",
        run="tuning seeds 0 and 1 of the bench: dipoles passed once, in 10 s, were explained to 0 or 99 % by chance",
    )  # fmt: skip

    # direct evidence
    least_step_sigma: float = number(0.05, "least significant bit below which rounding is of no account")
    same_step: float = number(0.01, "relative difference up to which a step is the model's own")
    same_full_scale: float = number(1e-3, "relative difference up to which a full scale is the model's own")
    least_spikes: int = number(3, "single wrong values from which on they are an effect")
    one_size: float = number(
        0.25,
        "mean excess of spikes over the least spike, over their mean, below which spikes have one size: half is usual",
    )
    far_sigma: float = number(5.0, "distance from the base beyond which a sample near a spike is wrong as well")
    burst_sigma: float = number(8.0, "distance of wrong samples in a row: never reached by white noise")
    most_burst: int = number(4, "samples in a row that a burst of wrong values lasts at most")
    off_along: float = number(
        0.1, "share along the field of the error of wrong values, below which the error is the attitude's",
        run="tuning seeds: a clock's errors in a hand 0.09, spikes 0.5; an error of the attitude half its angle",
    )  # fmt: skip
    quiet_sigma: float = number(1.5, "median gap after the base below which a far sample is wrong")
    more_noise: float = number(1.1, "ratio to the model's noise from which on there is more of it")

    # searches
    least_path_m: float = number(
        2.0, "shortest path on which a field may differ by place: a fixed sensor's navigation wanders by 1 m",
        run="catalogue scenarios: 3 m left out a quadrotor that calibrates on the spot",
    )  # fmt: skip
    nearest_place_m: float = number(0.5, "distance to the path below which a dipole would be on the sensor")
    farthest_place_m: float = number(60.0, "distance from which on the field of a dipole is a gradient")

    # evidence
    alpha: float = number(
        0.01, "probability of a false name: ln(names / alpha) nats are needed, look-alikes are within ln(1 / alpha)",
        alarms="0.3 % of 300 white nulls and none of 200 coloured ones were named (scoring seeds 2000 to 2009)",
        run="tuning seeds 0 and 1 of the bench: without counting the names 2 of 120 white nulls were named",
    )  # fmt: skip
    own_size: float = number(
        3.0, "factor between own and fitted size beyond which an effect without coefficients is rejected",
        run="a white hand-held log: a delay of 2.6 s at a millionth of its size had 8.8 nats, its gap was 471 sigma",
    )  # fmt: skip
    same_size: float = number(
        0.01, "difference of ln(fitted size / own size) up to which neither a delay nor a low-pass is nearer",
        run="tuning seed 3: both come out within 0.0004 of their own sizes, and gain the same within 0.05 nats",
    )  # fmt: skip
    least_loop: float = number(
        20.0, "least threshold in times the noise, where the course of the field is itself a measurement",
        run="a white log of a rover without attitude: a loop of 1.7 times the noise had 9.9 nats",
    )  # fmt: skip
    own_course: float = number(
        5.0, "deviation of a sample from its neighbours' course, in times the noise, from which on it is motion",
        run="loops of 100 nT on a turntable that rests, an attitude that errs by 0.01 to 0.05 degrees: 11 to 69 nats "
        "from the samples as they are",
    )  # fmt: skip
    search_price_odds: float = number(
        2.0, "the best of n searched settings is priced at odds of 1 in this number times n"
    )

    # iron and effects jointly, without attitude
    matrix_prior: float = number(0.25, "standard deviation of the iron's matrix about the unit matrix")
    offset_prior: float = number(
        0.5, "standard deviation of the iron's offset about zero, in strengths of the field",
        run="level turns with a current of 2000 nT: with 4 the offset went to three times the field",
    )  # fmt: skip
    fastest_turn: float = number(
        6.0, "rate in rad/s, in the median, beyond which a field without attitude or gyro is in no sensor that turns",
        run="4.2 for a hand in a hurry; 7 to 9 for magnets that a wheel turns beside a satellite's sensor at rest",
    )  # fmt: skip
    other_unit: float = number(2.0, "factor between measurements and the field from which on their units differ")

    # coloured noise models
    kept_by_rows: float = number(
        0.5, "share of an effect's power in such means below which its gain between their samples counts as well"
    )
    coloured_nats: float = number(
        25.0, "evidence above which an effect is accepted in coloured noise",
        run="a trial before this program: 7.5 nats gave false names",
    )  # fmt: skip
    same_coloured: float = number(
        0.12, "part of the best's evidence within which a useless candidate is a look-alike, in coloured noise",
        run="a trial before this program",
    )  # fmt: skip
    same_family: float = number(
        0.03,
        "as same_coloured, within a family in white noise: the gain of a form error",
        run="a trial before this program",
    )
    same_constant: float = number(
        0.007, "as same_coloured, of a simpler effect contained in the best, in white noise",
        run="tuning seed 14: an error of the field that grows by 2 % on the way, 0.002 behind a gradient from afar; a "
        "gradient of 3 nT/m from 250 m on a hover leads a constant by 0.021",
    )  # fmt: skip
    same_family_coloured: float = number(
        0.45, "as same_coloured, within a family in coloured noise",
        run="a hand-held optical log: its delay of 15 ms gains 0.57 to 0.70 of what nine free columns do",
    )  # fmt: skip
    one_cause: float = number(
        0.97, "share of a slow course's power common to all axes, above which the course is a cause and no noise",
        run="tuning seeds 920 to 931: 0.57 to 0.93 of three noises of f^-3, 0.999 and more of drifts and temperatures",
    )  # fmt: skip
    look_alike_kept: float = number(0.5, "part of its evidence that a look-alike keeps at most once the best is in")
    least_added: float = number(0.05, "share of the gap that an effect must explain in coloured noise")

    # several recordings
    alpha_pooled: float = number(
        0.001, "as alpha, for several recordings together: nats of coefficients predicted by the other recordings"
    )
    not_transferred_alarm: float = number(
        0.05, "probability of equal coefficients to differ as much between recordings as differing ones",
        alarms="4 of 196 lots of three with equal coefficients, white and coloured: see scatter_parts",
    )  # fmt: skip
    same_coefficient: float = number(0.04, "share of an effect by which its form is in error from motion to motion")

    # a curve of a channel, where no effect is accepted
    curve_residual: float = number(
        0.5, "part of the named effects' residual that a curve of another channel may leave to replace them",
        run="four payloads of three tones on an AUV: two ripples left half of the gap, the curve a hundredth",
    )  # fmt: skip

    # effects in a part of the run
    window_share: float = number(
        0.75, "part of a window's evidence that no effect of the whole run may reach",
    )  # fmt: skip

    # parts with a large gap
    part_price: float = number(4.0, "price of a further part, over ln(cells), in squares of the cells' noise")
    far_larger: float = number(3.0, "ratio to the rest's power above which the gap is large in one part")
    steady_heading: float = number(
        0.9, "length of the mean heading vector of a part from which on the part has one heading"
    )

    # tests of the residual
    means_alarm: float = number(1e-3, "probability that white noise fails the test of means at any length")
    tone_alarm: float = number(
        1e-4, "tones that white noise is expected to show over all frequencies, were its level known exactly",
        alarms="8 of 20 000 white residuals of 6000 samples on three axes showed a tone: 4e-4",
        run="tuning seeds 0 and 1 of the bench: found in all 12 ripples of the noise's size and more, whose second "
        "harmonic is 0.03 to 0.3 % of the gap, on the spectrum's lines and between them; in none of 12 white nulls",
    )  # fmt: skip
    tail_sigma: float = number(8.0, "standard deviations of a normal kurtosis that heavy tails lie beyond")
    tail_excess: float = number(0.1, "excess kurtosis that is of no account in any long recording")
    rise_alarm: float = number(
        1e-4, "probability that white noise, or noise that falls with frequency, shows a spectrum that rises",
        alarms="2 of 20 000 white residuals of 6000 samples on three axes; none of 4000 each that were louder now and "
        "then, fell with frequency, or had gaps; none of 101 nulls of the bench, white and coloured, tuning seed 99",
        run="tuning seed 99: of 404 trials 15 measured rests and three ripples that were left out of the library, "
        "all unknown or partial without it",
    )  # fmt: skip
    least_rise: float = number(
        0.02, "share of the power that lies above every falling spectrum, below which a rise is of no account"
    )
    rise_part: float = number(
        0.25, "part of the largest excess over lower frequencies from which on a frequency belongs to a rise"
    )
    far_row: float = number(5.0, "standard deviations from the middle beyond which a value counts as so far in it")

    # channels followed by the gap
    least_channel_share: float = number(0.003, "share of the gap from which on a channel is listed")

    # slow noise
    band_alarm: float = number(1e-3, "probability of a band of noise to deviate as far from the spectrum")
    along_share: float = number(
        0.65, "share of the structure along the field explained by a source, above which no wander makes it",
        run="independent storms 0.74 to 0.88; a day's change in flicker noise beside an attitude that wanders 0.36",
    )  # fmt: skip
    least_along_field: float = number(
        0.12, "share of slow power along the field below which it is a turn of the attitude; three equal axes have 1/3"
    )
    stands_out: float = number(2.0, "ratio to the white level from which on a slow noise stands out at a frequency")
    least_noise_lines: float = number(
        30.0, "number of frequencies at which slow noise must stand out for its nature to be identified", run=TUNED
    )
    course_sigma: float = number(
        5.0, "standard deviations of a run of innovations above which the run is a jump or a course", run=TUNED
    )
    swing_alarm: float = number(1e-3, "probability that random innovations correlate as much", run=TUNED)
    stated_margin: float = number(1.5, "ratio by which slow errors may exceed those stated by the model")

    # selection of effects
    same_gain: float = number(
        1e-6, "relative difference up to which two effects gain the same, and the chain's first is named",
        run="tuning seeds 0 and 1: the gains of hard iron and sensor offset differ by rounding alone",
    )  # fmt: skip
    form_share: float = number(
        0.15, "part of the first effect's size below which a further effect is its form error", run=TUNED
    )
    same_form_share: float = number(
        0.35, "as form_share, for an effect accepted before, or resembling the first effect", run=TUNED
    )
    shrunk_form: float = number(
        0.5, "part of its size alone that an effect must keep next to the first, or it resembles the first",
        run="a gradient of second order on a dive: a day's change of 0.95 sigma alone had 0.16 beside a gradient",
    )  # fmt: skip
    absorbed_survival: float = number(0.1, "survival of an effect below which the effect is not observable")
    survival_of_errors: float = number(
        0.02,
        "survival of an effect turning with the attitude, below which attitude errors of up to a degree imitate it",
        run="level circles with errors of 0.02 degrees: 1e-4 to 6e-3 of false names; true ones of tuning seeds 216 to "
        "218 from 0.06 on",
    )
    same_iron: float = number(
        1e-3, "part of the evidence of a change of iron within which an effect is a look-alike",
        run="level spirals: an error of the field of 33 sigma gains 1e-6 less, by the second order of both",
    )  # fmt: skip
    least_left: float = number(
        0.05, "rms of a constant vector of the earth's frame, in units of the noise, that names leave and nobody misses"
    )

    # doubts
    least_share: float = number(0.2, "share of the gap that accepted effects must explain to be named")
    sure_nats: float = number(
        50.0, "evidence from which a named effect stays, however small its share of the gap, if the residual is noise",
        run="independent recordings: 28 at most in 67 coloured nulls; 55 to 271 of effects of 0.1 and 0.3 sigma beside "
        "attitudes that walk and waves of up to 0.8",
    )  # fmt: skip
    larger_gap: float = number(1.1, "factor of growth of the gap from which on the named effects are wrong")
    least_held_excess: float = number(
        0.02, "excess of held-out power over the noise below which its share is undefined", run=TUNED
    )
    beside_time: float = number(
        0.1, "share explained by a channel beyond the share of time, from which on a gap is no noise"
    )
    form_noise: float = number(
        0.25, "part of the first effect's size below which slow noise is its form error", run=TUNED
    )
    wander_moves: float = number(
        10.0, "largest change of the mean by a wander, in times its rms: fitted iron absorbs most of it",
        run="an independent hand-held log: a walk of 40 nT beside an iron that was 1790 nT off",
    )  # fmt: skip
    channel_kept: float = number(
        0.25, "part of its share of the gap kept by a channel beyond the share of time, if a named effect is wrong",
        run="tuning seed 1: beside a core that saturates a motor's current keeps 0.3 to 0.5",
    )  # fmt: skip
    leading_share: float = number(0.5, "part of the first channel's share from which on a further channel leads too")
    one_course: float = number(
        0.9, "correlation of an effect's contribution with time, or a channel, above which either may drive it",
        run="a trial before this program: depth and temperature could not be told apart above it",
    )  # fmt: skip

    # parameters
    open_eigenvalue: float = number(
        1e-5, "eigenvalue of the parameters' correlation below which their combination is undetermined",
        run="an error of the field beside fitted iron, whose part along the field is open: 3e-13 to 9e-7, by the steps "
        "of the derivative",
    )  # fmt: skip
    open_part: float = number(
        1e-3, "part of a parameter in such a combination from which on the parameter has no interval", run=TUNED
    )

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
    values: dict[str, Any] = {}
    given = policy.numbers()
    for text in assignments:
        name, _, value = text.partition("=")
        if name not in given:
            raise InputError(f"{name!r} is no number of the policy", where="--set", do="one of " + ", ".join(given))
        values[name] = _read(value, given[name], name)
    return replace(policy, **values)


def _read(text: str, like: float | tuple[float, ...], name: str) -> float | tuple[float, ...]:
    try:
        if isinstance(like, tuple):
            return tuple(type(like[0])(part) for part in text.split(","))
        return type(like)(text)
    except ValueError as e:
        kind = type(like[0] if isinstance(like, tuple) else like).__name__
        raise InputError(f"{text!r} is no {kind}", where=f"--set {name}") from e
