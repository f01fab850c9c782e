"""Numbers that decide about axes and frames: value, meaning, and origin of each."""

from __future__ import annotations

from dataclasses import dataclass

from validation.policy import number

RUN = "benchmarks/axes_alarms.py"


@dataclass(frozen=True)
class AxesPolicy:
    """Limits that `validation.axes` applies; shares lie between 0 and 1."""

    # rows that are evaluated
    most_rows: int = number(6000, "rows evaluated at most", run=RUN)
    pieces: int = number(16, "stretches of the log that are compared with one another", run=RUN)
    least_rows: int = number(20, "rows below which axes are not judged", run=RUN)
    mean_s: float = number(0.04, "time over which fast rows are averaged")
    turn_share: float = number(
        0.5, "change of the field over its spread that a window of the gyro should have", run=RUN
    )
    longest_window_s: float = number(20.0, "length of such a window at most")
    lags_s: tuple[float, ...] = number((0.0, -0.2, -0.1, 0.1, 0.2), "delays of the gyro that are tried first")
    finer_lags_s: tuple[float, ...] = number((-0.05, 0.05), "delays beside the best of these that are tried next")

    # model of the instruments
    distortion: float = number(0.12, "standard deviation of each element of soft iron, scale and mounting", run=RUN)
    bias_share: float = number(0.2, "standard deviation of the gyro's bias over the rms rate", run=RUN)
    least_error: float = number(0.05, "rms error of the model over the rms of the signal at least", run=RUN)

    most_samples: float = number(
        50.0, "independent samples counted at most: errors of instruments and motion last longer than noise", run=RUN
    )
    tilt_over_error: float = number(
        4.0,
        "rms change of gravity's direction over the relative rms change of its size, above which it shows tilts; "
        "below, accelerations would count as tilts",
        run=RUN,
    )
    level: float = number(0.3, "rms change of gravity's direction, in radians, of a motion taken as level", run=RUN)

    # decision
    least_share: float = number(0.6, "share of the signal that the likeliest map explains at least", run=RUN)
    rejected_nats: float = number(8.0, "loss of log-likelihood from which on a map is excluded", run=RUN)
    against: float = number(
        0.2, "residuals of pieces that speak for a map over those against it, from which on it is kept", run=RUN
    )
    one_piece: float = number(0.5, "share of a single piece in that sum from which on a map is kept", run=RUN)
    clear_sign: float = number(0.25, "component of the unit field whose sign is taken as known", run=RUN)
    clear_sign_sigma: float = number(4.0, "the same component in standard deviations", run=RUN)
    meridian: float = number(3.0, "north component over east component from which a heading is counted from north")
    equator: float = number(0.1, "vertical component of the unit field below which its sign tells nothing")
    upright: float = number(0.7, "component of the mean direction of gravity along z from which on z is upright")


AXES = AxesPolicy()
"""The limits in use."""
