"""Motion of a recording: recorded inputs of effects, attitude at its time, and the body rate with the least noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from calib.numerics.noise import SECOND, clipped_mean, white_noise_std
from calib.numerics.rates import body_rate, smoothed_derivative
from diagnosis.policy import Policy
from diagnosis.problem.known import FieldTrack
from recordings import Recording
from recordings.assemble import scalars_of
from recordings.channels import current_name
from scenarios.arrays import Array
from sim.rotation import cross, matrix_from_q, to_body
from sim.state import State

LEAST_NOISE = 1e-6
"""Least noise in nT, for a vanishing residual."""


def pauses_after(time_s: Array, policy: Policy) -> NDArray[np.intp]:
    """Indices of samples at times (n,) followed by a pause of more than `pause` intervals."""
    step = np.diff(time_s)
    return np.flatnonzero(step > policy.pause * np.median(step))


def sample_noise(residual: Array, gaps: NDArray[np.intp] | None = None) -> Array:
    """White noise (q,) of a residual (n, q) without motion, at least `LEAST_NOISE`.

    gaps : indices of samples followed by a gap.
    """
    return np.maximum(white_noise_std(residual, gaps, orders=SECOND, pooled=clipped_mean), LEAST_NOISE)


def repeated(mag_nT: Array) -> NDArray[np.bool_]:
    """Mask (n,) of rows of values (n, 3) equal to the row before."""
    return np.asarray(np.concatenate([[False], (mag_nT[1:] == mag_nT[:-1]).all(axis=1)]), dtype=np.bool_)


def held(mag_nT: Array, residual: Array, policy: Policy) -> NDArray[np.bool_]:
    """Mask (n,) of repeated rows, where more frequent than rounding explains; residual (n, q): without motion.

    Two values with noise s round to one step d of a lattice with probability ``d / (2 sqrt(pi) s)``, at most 1.
    """
    again = repeated(mag_nT)
    if np.count_nonzero(again) < policy.least_spikes:
        return np.zeros(len(mag_nT), np.bool_)
    steps = np.array([np.diff(np.unique(axis)).min(initial=np.inf) for axis in mag_nT.T])
    chance = float(np.prod(np.minimum(1.0, steps / (2 * np.sqrt(np.pi) * sample_noise(residual)))))
    return again & (float(again.mean()) > policy.much_larger * chance)


def outliers(off: Array, policy: Policy) -> NDArray[np.bool_]:
    """Mask (n,) of rows of deviations (n, q) far beyond the median; none where they are too many to be failures."""
    size = np.abs(off)
    far = (size > policy.never_sigma * np.maximum(np.median(size, axis=0), 1e-9)).any(axis=1)
    return np.asarray(far & (far.mean() < policy.fair_share))


def noise_of_neighbours(residual: Array, mag_nT: Array, time_s: Array, policy: Policy) -> Array:
    """White noise (q,) of a residual (n, q) without motion, from rows that are not repeated, and not across pauses.

    From all rows where too few are new: a noiseless vehicle at rest repeats every row.
    """
    fresh = ~held(mag_nT, residual, policy)
    sigma = sample_noise(residual[fresh], pauses_after(time_s[fresh], policy))
    return sigma if np.isfinite(sigma).all() else sample_noise(residual, pauses_after(time_s, policy))


def measured(recording: Recording) -> frozenset[str]:
    """Inputs of effects that a recording holds."""
    present = {
        "attitude": recording.att_q is not None,
        "rate": recording.gyro_rad_s is not None or recording.att_q is not None,
        "position": recording.pos_enu_m is not None,
    }
    motors = {current_name(1)} if recording.motors else set()  # to an effect of the currents any motor will do
    return frozenset(name for name, there in present.items() if there) | motors | frozenset(scalars_of(recording))


def attitude_course(time_s: Array, q: Array) -> CubicSpline:
    """Quaternions (n, 4) as a cubic spline of time, with signs made continuous."""
    signs = np.cumprod(np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0))
    return CubicSpline(time_s, q * np.concatenate([[1.0], signs])[:, None])


def attitude_at(course: CubicSpline, time_s: Array) -> Array:
    """Quaternions (n, 4) of a spline at given times, constant after the last knot."""
    q = course(np.minimum(time_s, course.x[-1]))
    return np.ascontiguousarray(q / np.linalg.norm(q, axis=1, keepdims=True))


def attitude_at_its_time(
    recording: Recording, delay_s: float, policy: Policy
) -> tuple[Recording, float, NDArray[np.bool_]]:
    """A recording with its attitude interpolated between new values and moved by a delay, if either is needed.

    Further the share of interpolated rows, and the rows (n,) whose attitude is not known.
    """
    q, time_s = recording.att_q, recording.time_s
    if q is None:
        return recording, 0.0, np.zeros(len(recording), np.bool_)
    (known, share), then_s = _known_rows(recording.mag_nT, q, policy), time_s + delay_s
    if share or delay_s:
        recording = replace(recording, att_q=attitude_at(attitude_course(time_s[known], q[known]), then_s))
    return recording, share, unknown_attitude(time_s[known], then_s, policy)


def unknown_attitude(known_s: Array, then_s: Array, policy: Policy) -> NDArray[np.bool_]:
    """Mask (n,) of times after the last known attitude (m,), or within a pause of the known ones."""
    after, pauses = np.searchsorted(known_s, then_s), [*pauses_after(known_s, policy), len(known_s) - 1]
    return np.isin(after - 1, pauses) & (np.append(known_s, np.inf)[after] > then_s)


def _known_rows(mag_nT: Array, q: Array, policy: Policy) -> tuple[NDArray[np.intp], float]:
    """Rows (m,) of an attitude (n, 4) that was logged from a slower navigation system, and the share of repeated rows.

    Requires new values at a constant interval, within a row, and few longer rests; else all rows are known. In a rest
    the attitude is constant up to one interval before the end.
    """
    n = len(q)
    new = np.flatnonzero(np.concatenate([[True], (np.diff(q, axis=0) != 0).any(axis=1)]))
    again = np.delete(~repeated(mag_nT), new)  # a whole row that is repeated is told by the magnetometer
    rows = np.diff(new)
    pace = int(np.median(rows)) if len(rows) else 0
    share = float(min(again.sum(), (rows[rows <= pace + 1] - 1).sum())) / n
    if share <= policy.little or np.mean(np.abs(rows - pace) > 1) > policy.little:
        return np.arange(n), 0.0
    rests = np.flatnonzero(rows > pace + 1)
    return np.unique(np.concatenate([new, *(np.arange(new[i], new[i + 1] - pace + 1) for i in rests)])), share


def state_of(
    recording: Recording,
    field_enu_nT: Array,
    field_nT: Array,
    rate_rad_s: Array | None = None,
    field_rate_nT_s: Array | None = None,
    R_wb: Array | None = None,
) -> State:
    """State of a sensor that sees a field (n, 3), with the inputs that a recording holds; zero where not measured.

    The field's rate (n, 3) is ``-w x T`` with a body rate w (n, 3), else the derivative of the field.
    """
    n, time_s = len(recording), recording.time_s - recording.time_s[0]
    if field_rate_nT_s is None:
        field_rate_nT_s = smoothed_derivative(field_nT, time_s) if rate_rad_s is None else -cross(rate_rad_s, field_nT)
    return State(
        time_s=time_s,
        interval_s=float(np.median(np.diff(time_s))),  # of what was sampled, not of gaps and bursts
        R_wb=np.tile(np.eye(3), (n, 1, 1)) if R_wb is None else R_wb,
        rate_rad_s=np.zeros((n, 3)) if rate_rad_s is None else rate_rad_s,
        field_enu_nT=field_enu_nT,
        field_nT=field_nT,
        field_rate_nT_s=field_rate_nT_s,
        pos_enu_m=np.zeros((n, 3)) if recording.pos_enu_m is None else recording.pos_enu_m,
        channels=scalars_of(recording),
        attitude="navigation",
    )


def motion_of(recording: Recording, field_enu_nT: Array, policy: Policy, track: FieldTrack | None) -> State:
    """State of the recorded motion, ``dT/dt = R^T dF/dt - w x T``, F the field along the track."""
    assert recording.att_q is not None
    rate, R_wb = quieter_rate(recording, policy), matrix_from_q(np.ascontiguousarray(recording.att_q))
    change = np.zeros((len(recording), 3)) if track is None else track.change_enu_nT
    field = to_body(R_wb, field_enu_nT + change)
    on_the_way = to_body(R_wb, np.gradient(change, recording.time_s, axis=0))
    return state_of(recording, field_enu_nT, field, rate, on_the_way - cross(rate, field), R_wb)


def quieter_rate(recording: Recording, policy: Policy) -> Array:
    """Body rate (n, 3): gyroscope or derivative of a non-repeating attitude, whichever has less noise."""
    gyro, q = recording.gyro_rad_s, recording.att_q
    derived = body_rate(replace(recording, gyro_rad_s=None))
    assert derived is not None
    assert q is not None
    if gyro is None:
        return derived
    again = np.mean((np.diff(q, axis=0) == 0).all(axis=1))
    return gyro if again > policy.little or sample_noise(gyro).sum() < sample_noise(derived).sum() else derived
