"""Numbers that decide findings about measured values: value, meaning, false-alarm rate, and origin of each."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

APART = "not measured apart"
BY_HAND = "set by hand, not measured"
NONE = "none of 3000 white recordings: benchmarks/inspection_alarms.py"


def number(value: float | tuple[float, ...], meaning: str, *, alarms: str = APART, run: str = BY_HAND) -> Any:
    """Return a policy's field: value, meaning, measured false-alarm rate, and the run that set the value."""
    return field(default=value, metadata={"meaning": meaning, "alarms": alarms, "run": run})


def shared(name: str) -> Any:
    """Return the field `name` of `InspectionPolicy` for use in another policy."""
    one = InspectionPolicy.__dataclass_fields__[name]
    return field(default=one.default, metadata=one.metadata)


@dataclass(frozen=True)
class InspectionPolicy:
    """Limits that `validation.signals` and `validation.inspection` apply to a recording.

    Shares lie between 0 and 1; a sigma is the standard deviation of the noise of one sample.
    """

    # sampling
    gap: float = number(1.5, "median intervals beyond which two samples are not neighbours")
    few_samples: int = number(100, "samples below which noise, tones and slow changes are not judged")
    constant_jitter: float = number(1e-6, "rms deviation of the intervals over the median that is rounding")
    jitter_note: float = number(0.05, "relative rms deviation of the intervals above which a note is given")
    jitter_warning: float = number(0.3, "relative rms deviation of the intervals above which spectra do not hold")
    most_gaps: float = number(0.01, "share of the recording in gaps above which gaps are a warning")
    few_lengths: int = number(3, "different intervals at most of an even clock with rounded time stamps")
    uneven_interval: float = number(0.3, "relative deviation from the median above which an interval is uneven")
    most_uneven: float = number(0.2, "share of uneven intervals from which on no spectrum is computed")
    least_rows: int = number(30, "rows below which rates, attitude and residual are not evaluated")

    # unit of the time stamps
    least_interval_s: float = number(
        1.0, "median interval below which time stamps are not read as milliseconds: a log of 1 kHz is rare"
    )
    least_explained: float = number(
        0.5, "share of the gyro's variance, or the field's derivative, to explain before a unit is judged by the gyro"
    )
    scale_by_field: float = number(
        0.3, "deviation from 1 of a gyro's scale within which units agree: soft iron changes the scale"
    )
    usual_rad_s: tuple[float, float] = number(
        (0.005, 2.0), "median turning rates of a vehicle's field: circles at 1 degree/s 0.009, a tumbled sensor 1"
    )
    still_spread: float = number(0.05, "rms of the field over its mean below which a sensor is at rest")

    # columns slower than the rows
    least_rate_rows: int = number(20, "rows below which the rate of a column is not judged")
    stale_share: float = number(0.02, "share of repeated rows below which a column is new in every row")
    stale_ratio: float = number(
        3.0,
        "ratio of repeats in next rows to repeats further apart that a held column has",
        alarms=NONE,
    )
    stale_lag: int = number(3, "mean lengths of a run of equal rows between rows further apart")
    least_bends: int = number(50, "second differences below which interpolation is not looked for")
    kink_share: float = number(
        0.97,
        "share of the sum of second differences in the kinks of an interpolated column",
        alarms=NONE,
    )
    most_kinks: float = number(0.6, "share of rows with a kink above which a column is rough, not interpolated")
    kink_height: float = number(0.1, "second difference over the median kink's above which a row is a kink")
    least_kinks: int = number(10, "kinks below which interpolation is not stated")
    least_kink_rows: float = number(6.0, "mean distance of kinks in rows below which kinks merge")
    regular: float = number(0.5, "relative deviation from the mean distance within which a kink is regular")
    least_regular: float = number(0.5, "share of regular kinks above which a column is interpolated")
    sparse: float = number(0.9, "share of rows with a value below which a column is sparse")
    varying: float = number(0.8, "share of new values above which a column is checked for interpolation")
    new: float = number(0.9, "share of new values above which a column is new in every row")

    # repeated rows and full scale
    tie_free: float = number(0.01, "share of equal values below which equal rows cannot be chance")
    frozen_alarm: float = number(
        1e-3,
        "expected runs of equal rows as long by chance, below which a run is frozen",
        alarms=NONE,
    )
    frozen_jump: float = number(3.0, "usual steps above which the value after a run of equal rows has jumped")
    noisy_step: float = number(1.0, "noise over the step from which on neighbours differ by chance, wherever the value")
    most_alike: float = number(0.999, "chance at most that neighbours round alike, where a step hides the noise")
    least_frozen: int = number(3, "equal rows at least of a frozen run whose values repeat by chance too")
    least_at_level: int = number(3, "equal extreme values below which no full scale is stated")
    overshoot: float = number(4.0, "steps or sigmas that the course extends beyond a cut-off level at least")
    moved_on: float = number(0.3, "motion of the other axes over the expected motion that a cut-off stretch has")
    least_visits: int = number(2, "visits to a full scale at least where values repeat by chance")
    pile_ratio: float = number(
        4.0,
        "count of the outermost code over the next code's that a full scale has",
        alarms=NONE,
    )
    least_pile: int = number(10, "samples at the outermost code at least where noise exceeds the step")

    # screening before a fit
    least_kept: int = number(4, "rows that screening leaves at least: with fewer no calibrator has a solution")

    near_end_sigma: float = number(
        4.0, "standard deviations below a full scale within which a row is left out, by the values of its neighbours"
    )
    sentinel_gap: float = number(0.1, "distance of a sentinel to the next value over the span of the others at least")
    sentinel_steps: float = number(10.0, "usual steps between a sentinel without a known code and the next value")
    wrap_usual: float = number(0.9, "quantile of the steps between samples that is the usual largest step")
    wrap_smooth: float = number(0.15, "usual largest step over the range above which a wrap is not looked for")
    wrap_quarter: float = number(0.25, "range to either side of its middle where a wrapping axis has values too")
    wrap_middle: float = number(0.1, "share of such values at least")
    wrap_ends: float = number(3.0, "usual largest steps by which a wrap may fall short of the range")
    wrap_heading: float = number(0.6, "share of wraps before and after which the course heads on")
    alike_noise: float = number(1.5, "difference of two axes over their noise up to which they measure the same")
    alike_share: float = number(1e-4, "the same difference over the motion, for axes without noise")
    alike_motion: float = number(20.0, "motion over the difference of two axes from which on they are compared")
    unwired_noise: float = number(1.2, "spread of an axis over its noise up to which there is noise only")
    cut_off_usual: float = number(3.0, "usual steps within which the value after a full scale follows")
    unwired_motion: float = number(20.0, "motion of the other axes over that spread at least")
    on_ellipse: float = number(0.2, "scatter of a fitted conic below which two axes draw a turn about the third")
    step_rows: int = number(20, "rows on either side of a step at least")
    step_gain: float = number(1.5, "scatter of one ellipsoid over that of two with their own offsets, for a step")
    step_sigma: float = number(12.0, "local standard deviations of a fitted step from which on the offset steps")
    step_left: float = number(0.5, "what is left of a step once taken out, over the step, at most")
    most_steps: int = number(20, "largest candidates that are tested for a step on an axis")

    # spikes
    spike_sigma: float = number(
        8.0,
        "local standard deviations of the interpolation error from which on a value is a spike",
        alarms=NONE,
    )
    spike_step: float = number(0.4, "least standard deviation of that error, in least significant bits")
    spike_peak: float = number(1.2, "ratio of a spike's interpolation error to each neighbour's")
    spike_opposite: float = number(0.2, "neighbours' interpolation error of opposite sign over the spike's")
    spike_slope: float = number(0.25, "difference of the slopes beside and across a spike, over the spike")
    spike_slope_sigma: float = number(3.0, "the same limit in standard deviations, whichever is larger")
    most_gap_share: float = number(0.1, "share of samples before a gap above which spikes are not looked for")

    # converter's steps
    least_codes: int = number(4, "distinct values below which a least significant bit is not looked for")
    on_lattice: float = number(0.2, "distance from a multiple of the step, in steps, within which a value lies on it")
    on_coarse_lattice: float = number(0.05, "the same for large values on a multiple of the step: floating point")
    least_on_lattice: float = number(0.85, "share of the values on a lattice at least")
    least_in_window: float = number(0.8, "share of the values on the lattice in each window of the fit at least")
    lattice_alarm: float = number(
        1e-9,
        "probability that values without a lattice lie as close to one",
        alarms=NONE,
    )
    least_large: int = number(16, "large and small values at least to recognise floating-point steps")
    small_values: float = number(20.0, "ratio of the largest value to values that count as small there")
    least_groups: int = number(8, "groups of eight codes at least before a preference for even codes is judged")
    least_in_group: int = number(40, "samples in such a group at least")
    preferred: float = number(
        0.1,
        "deviation of the share of odd codes from one half above which codes are preferred",
        alarms=NONE,
    )
    same_side: float = number(0.9, "share of groups with the same preference at least")
    all_on_lattice: float = number(0.999, "share of values on the lattice from which on strays are not reported")
    coarse_step: float = number(2.0, "least significant bit over the noise above which a note is given")
    fine_step: float = number(0.1, "least significant bit over the noise below which rounding does no harm")
    hidden_noise: float = number(0.3, "noise over the least significant bit below which noise is hidden by rounding")

    # noise and tones
    most_noise_share: float = number(0.05, "noise over the field's strength above which differences are motion")
    mean_lengths_s: tuple[float, ...] = number((1.0, 5.0, 20.0), "lengths of the means that are tested")
    filled_mean: float = number(0.8, "share of its samples that such a mean needs")
    excess_sigma: float = number(
        4.0,
        "standard deviations of the variance of means above which noise is not white",
        alarms="27 of 3000 white recordings of 60 s at any of the lengths: benchmarks/inspection_alarms.py",
    )
    residual_ratio: float = number(2.0, "residual over its white noise above which a note is given")
    still_noise: float = number(3.0, "spread of the field over its noise below which a sensor does not move")
    least_spectrum: int = number(64, "samples below which no spectrum is computed")
    tone_alarm: float = number(
        1e-5,
        "tones expected in white noise over all frequencies; the diagnosis has its own",
        alarms=NONE,
    )
    mains_drift: float = number(1e-3, "relative deviation of the mains' frequency from its nominal value at most")
    mains_width: float = number(0.02, "width of a mains line over the sampling rate above which no tone is attributed")
    least_mains_rate_hz: float = number(2.0, "sampling rate above which aliases of the mains are listed")
    slow_mains: float = number(0.002, "alias of the mains over the sampling rate below which it resembles drift")
    motion_ratio: float = number(10.0, "power over the noise floor above which a frequency belongs to the motion")

    # neighbours' course
    neighbours_weight: float = number(
        2.0, "sum of a cubic's absolute weights from which on uneven times amplify noise: 5/3 for even times"
    )

    # attitude, gyro and gravity
    attitude_norm: tuple[float, float] = number((0.5, 2.0), "norms of quaternions that are normalised and used")
    norm_tolerance: float = number(0.02, "deviation of a quaternion's norm from 1 that is a warning")
    held_pause: float = number(2.5, "mean intervals above which a slower sensor's values are not evenly spaced")
    least_rate_rad_s: float = number(0.01, "rms turning rate below which attitude and gyro are not compared")
    least_directions: int = number(10, "rows below which rates and directions are not averaged")
    longest_lag_s: float = number(5.0, "delay of the attitude up to which one is looked for")
    lag_gain: float = number(0.01, "gain of explained share below which the attitude is not called late")
    second_axis: float = number(0.02, "variance of the rate about a second axis over the first that shows a turn")
    agreeing_share: float = number(0.9, "share of the gyro's variance from which on a convention is accepted")
    disagreeing_share: float = number(0.7, "share of the gyro's variance below which gyro and attitude disagree")
    as_good: float = number(0.05, "difference of explained shares below which conventions explain the same")
    turned_deg: float = number(5.0, "angle between attitude and gyro above which their frames differ")
    unit_tolerance: float = number(0.2, "relative deviation from a unit's factor within which a gyro has that unit")
    scale_tolerance: float = number(0.1, "deviation of the gyro's scale from 1 above which its unit is doubted")
    serious_lag_s: float = number(0.05, "delay of the attitude above which it is a warning")
    calm_share: float = number(0.1, "relative deviation of the specific force from its median while not accelerated")
    upright_deg: float = number(30.0, "angle of the mean specific force to the vertical within which it is upright")
    off_north_deg: float = number(45.0, "declination above which the heading is doubted, but near the poles")
    steep_deg: float = number(80.0, "inclination above which a declination may have any size")
    kept_length: float = number(0.95, "length of the mean of unit vectors above which they keep their direction")
    lost_length: float = number(0.85, "length of the mean of unit vectors below which they do not")

    # units of the measured vectors
    earth_nT: tuple[float, float] = number((20_000.0, 70_000.0), "strengths of the Earth's field, rounded outwards")
    gravity_tolerance: float = number(0.2, "relative deviation of the median specific force from gravity")

    # motion and what a recording suffices for
    small_hole_deg: float = number(65.0, "radius of a hole in the directions that a calibration tolerates")
    at_rest: float = number(0.01, "largest standard deviation of the field over its strength of a sensor at rest")
    along_axis: float = number(0.98, "cosine of the angle to an axis above which a direction is called that axis")
    steady_rate: float = number(0.1, "relative deviation from the median rate within which a turn is steady")
    steady_share: float = number(0.8, "share of steady rows above which the turn is called steady")
    least_steady_deg_s: float = number(1.0, "rate above which a steady turn is reported")
    most_spread: float = number(0.1, "relative spread of the strength after an ellipsoid fit that failed")
    least_direction: float = number(0.5, "length of the mean of unit vectors below which no field vector is taken")
    field_change: float = number(20.0, "residual of an attitude fit over the noise above which the field changes")


POLICY = InspectionPolicy()
"""The limits in use."""
