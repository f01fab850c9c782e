"""Wild values: samples that stand out from the samples before and after, left out of a fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from calib.acceptance import in_time, residual_of
from calib.models.ellipsoid import Ellipsoid, Standardised
from calib.models.linked import mean_rates, steps, unturned
from calib.models.quadric import fit_ellipsoid_specific, refit
from calib.numerics.noise import NORMAL_MEDIAN
from calib.numerics.outliers import away_from_line, away_from_median, bridged, changes, short_runs
from calib.numerics.points import lengths, mapped
from calib.reference import Reference
from calib.result import Calibration
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

Mask = NDArray[np.bool_]
ALARM = 1e-3
"""Expected wild values in a recording of Gaussian noise alone, whatever the length; see tests/calib/test_robust."""
SUSPICIOUS = 5.0
"""Largest change between neighbours, in its standard deviations, up to which nothing further is looked at: a single
wild value of seven standard deviations of a sample. It keeps the search within a twentieth of the quickest fit."""
SAMPLED = 1000
"""Changes that the standard deviation of all is taken from at first."""
MOST_SHARE = 0.15
"""Share of wild values above which none is left out: so many are a property of the sensor or of the vehicle."""
HALF_WINDOW = 7
"""Neighbours on either side whose median a value is compared with: half of them may be wild too. The noise beside a
value is that of twice as many before or after: noise that comes and goes is not wild."""
NEAREST = 3
"""Distance of the nearest neighbours through which a line is taken: half of a run of wild values."""
LONGEST = 5
"""Neighbouring wild values at most: a longer disturbance is physics (a motor's current, iron beside the way)."""
MOST_NEAR = 10
"""Wild values at most within HALF_WINDOW on either side: more are a noisy stretch."""
EDGE = 0.5
"""Share of a change that begins a run of wild values by which values beside the run may change: a slope is part of
more. Peaks beyond this share of the highest are bridged together."""
FREEDOM = 0.37
"""Degrees of freedom a value of a standard deviation by the median: its efficiency for Gaussian noise."""
LEAST = 1e-7
"""Least standard deviation, as a fraction of the field: what rounding leaves of a record without noise is not wild."""
LEAST_ROWS = 30
"""Samples below which none is called wild: the fit follows single samples, and poses have no neighbours."""
PASSES = 10
"""Times that the highest peaks are bridged at most, each down to half of the one before."""
ROUNDS = 6
"""Fits at most; each leaves out what the wild values of the fit before have hidden."""


@dataclass(frozen=True, eq=False)
class Wild:
    """Wild samples of a recording: mask (n,), and how far the furthest is off, nT."""

    rows: Mask
    furthest_nT: float

    @property
    def count(self) -> int:
        """Number of wild samples."""
        return int(np.count_nonzero(self.rows))

    @property
    def share(self) -> float:
        """Part of all samples."""
        return self.count / len(self.rows)

    def told(self, left_out: bool) -> str:
        """Number, share and size in words."""
        found = (
            f"{self.count} of {len(self.rows)} samples ({figure(100 * self.share, 2)} %) are wild, "
            f"up to {figure(self.furthest_nT)} nT off"
        )
        if left_out:
            return f"{found}, and were left out"
        return f"{found}: more than the {100 * MOST_SHARE:g} % that can be left out; check sensor and wiring"


def without_wild(
    first: Calibration,
    recording: Recording,
    reference: Reference,
    again: Callable[[Recording], Calibration],
    *,
    vector: bool,
    carries: bool,
) -> Calibration:
    """The fit repeated without wild values, until these are settled; the first fit where that gives no estimate.

    A value is wild where the residual of the fit stands out from its neighbours in time, see `wild_rows`. A first fit
    without an estimate is replaced by an ellipsoid. again : the fit to another recording. vector, carries : as of
    `columns_of`.
    """
    if first.status.kind == "not_applicable" or len(recording) < LEAST_ROWS:
        return first
    with np.errstate(all="ignore"):
        wild = _wild(first, recording, reference, vector, carries)
        if wild is None:
            return first
        for _ in range(ROUNDS):
            if wild.share > MOST_SHARE:
                return _told(first, wild, left_out=False)
            found = again(_without(recording, wild.rows, carries))
            further = _wild(found, recording, reference, vector, carries)
            if further is None:
                break
            settled, wild = np.array_equal(further.rows, wild.rows), further
            if settled:
                break
    return _told(found, wild, left_out=True) if found.has_estimate else first


def _told(fit: Calibration, wild: Wild, *, left_out: bool) -> Calibration:
    """The fit with the wild values in parameters and reason."""
    reason = "; ".join(part for part in (fit.status.reason, wild.told(left_out)) if part)
    told = {"wild_samples": float(wild.count)} if left_out else {}
    rows = wild.rows if left_out else None
    return replace(fit, status=replace(fit.status, reason=reason), parameters=fit.parameters | told, left_out=rows)


def _without(recording: Recording, rows: Mask, carries: bool) -> Recording:
    """The recording without rows; with NaN in the place of their measurements where the method carries a state."""
    if not carries:
        return recording.taken(~rows)
    return replace(recording, mag_nT=np.where(rows[:, None], np.nan, recording.mag_nT))


def _wild(fit: Calibration, recording: Recording, reference: Reference, vector: bool, carries: bool) -> Wild | None:
    """Wild samples by the residual of a fit, or of an ellipsoid where the fit has no estimate."""
    if fit.covariance is None and fit.status.kind != "ok":
        return _wild_of_ellipsoid(recording, reference)
    columns = columns_of(fit, recording, reference, vector=vector, carries=carries)
    return wild_rows(columns, recording, reference.strength_nT)


def columns_of(fit: Calibration, recording: Recording, reference: Reference, *, vector: bool, carries: bool) -> Array:
    """Residual (n, k) in order of time, nT, of a fit: |h| of a field that varies slowly, and vectors where known.

    vector : h - R_wb^T F instead, with known attitude. carries : h turned back by the gyro too, Q_i h_i. An array :
    |h| of each sensor, and each component minus the median of the sensors.
    """
    if fit.array_matrix is not None and recording.array_mag_nT is not None:
        fields = fit.apply_array(recording)
        apart = fields - np.median(fields, axis=0)
        sizes = [lengths(np.ascontiguousarray(field)) for field in fields]
        return in_time(recording, np.column_stack((*sizes, *apart)))
    residual = residual_of(fit, recording, reference, vector=vector)
    if not carries:
        return residual.reshape(len(residual), -1)
    assert recording.gyro_rad_s is not None
    field = in_time(recording, fit.apply(recording))
    step_s = steps(in_time(recording, recording.time_s))
    rate = mean_rates(in_time(recording, recording.gyro_rad_s), step_s)
    return np.column_stack((residual, unturned(field, rate, step_s)))


def wild_rows(columns: Array, recording: Recording, strength_nT: float) -> Wild | None:
    """Wild samples of a residual (n, k) in order of time; None for no such sample.

    |r_i - median(r_i-7 ... r_i+7)| > t sigma,  sigma local, by the median; t for ALARM values by chance

    Values beyond the limit in a run of more than LONGEST, on the slope of a longer disturbance, or where half of the
    neighbours are beyond the limit too, are no wild values. Repeated measurements count as one.
    """
    if not _suspicious(columns, strength_nT):
        return None
    order = np.argsort(recording.time_s, kind="stable")
    fresh = _fresh(recording, order)
    which = np.cumsum(fresh) - 1
    values = np.ascontiguousarray(columns[fresh])
    smooth, limit = _smooth(values, LEAST * strength_nT)
    wild = short_runs(values, smooth, limit, LONGEST, HALF_WINDOW, MOST_NEAR, EDGE)
    if not wild.any():
        return None
    furthest = float(np.max(np.where(wild[:, None], np.abs(values - smooth), 0.0)))
    rows = np.empty(len(columns), np.bool_)
    rows[order] = wild[which]
    return Wild(rows, furthest)


def _smooth(columns: Array, least_nT: float) -> tuple[Array, Array]:
    """What the neighbours of columns (n, k) say of them (n, k), and the limit (n, k) of the difference.

    A wild value moves the median of its neighbours: peaks are bridged before that is taken, the highest first.
    """
    smooth, times = columns, _limit(*columns.shape)
    for _ in range(PASSES):
        away, std = _deviation(smooth)
        limit = times * np.maximum(std, least_nT)
        smooth, count = bridged(smooth, away, limit, HALF_WINDOW, EDGE)
        if not count:
            break
    return smooth - _deviation(smooth)[0], limit


def _deviation(columns: Array) -> tuple[Array, Array]:
    """Deviation (n, k) from the neighbours' median or their line, whichever is nearer, and its standard deviation.

    The median of the neighbours follows a step, their line a slope.
    """
    level = away_from_median(columns, HALF_WINDOW)
    line = away_from_line(columns, NEAREST, HALF_WINDOW)
    away = np.where(np.abs(level) < np.abs(line), level, line)
    return away, np.maximum(_local_std(away), np.median(np.abs(line), axis=0) / NORMAL_MEDIAN)


def _suspicious(columns: Array, strength_nT: float) -> bool:
    """Whether a value changes by more than neighbours of Gaussian noise do."""
    largest, median = changes(columns, SAMPLED)
    limit = max(SUSPICIOUS, _limit(*columns.shape))
    return bool(np.any(largest > limit * np.maximum(median / NORMAL_MEDIAN, LEAST * strength_nT)))


def _fresh(recording: Recording, order: NDArray[np.intp]) -> Mask:
    """Rows (n,) with a new measurement, in order of time."""
    sensors = recording.mag_nT[None] if recording.array_mag_nT is None else recording.array_mag_nT
    values = np.hstack(list(sensors))[order]
    new = np.ones(len(values), np.bool_)
    new[1:] = np.any(values[1:] != values[:-1], axis=1)
    return new


def _limit(rows: int, columns: int) -> float:
    """Limit t of |away| / sigma for ALARM values by chance; sigma is not known exactly."""
    return float(-stdtrit(FREEDOM * rows, ALARM / (2 * rows * columns)))


def _local_std(away: Array) -> Array:
    """Robust standard deviations (n, k) of deviations (n, k) before or after a row, whichever is larger."""
    size = np.abs(away)
    around = size - away_from_median(size, HALF_WINDOW)
    edge = np.zeros((HALF_WINDOW + 1, size.shape[1]))
    before, after = np.vstack((edge, around))[: len(size)], np.vstack((around, edge))[len(edge) :]
    return np.asarray(np.maximum(before, after) / NORMAL_MEDIAN)


def _wild_of_ellipsoid(recording: Recording, reference: Reference) -> Wild | None:
    """Wild samples by the distance from an algebraic ellipsoid through the rest, of any sensor of an array."""
    sensors = recording.array_mag_nT
    parts = [recording] if sensors is None else [recording.sensor(i) for i in range(len(sensors))]
    found = [wild for part in parts if (wild := _wild_of_sensor(part, reference)) is not None]
    if not found:
        return None
    return Wild(np.any([wild.rows for wild in found], axis=0), max(wild.furthest_nT for wild in found))


def _wild_of_sensor(recording: Recording, reference: Reference) -> Wild | None:
    """Wild samples by the distance from an ellipsoid; at first those that stand out by themselves are left out."""
    x = recording.mag_nT
    wild = wild_rows(in_time(recording, x), recording, reference.strength_nT)
    for _ in range(ROUNDS):
        distance_nT = _distances(x, slice(None) if wild is None else ~wild.rows)
        if distance_nT is None:
            return wild
        found = wild_rows(in_time(recording, distance_nT)[:, None], recording, reference.strength_nT)
        if found is None or (wild is not None and np.array_equal(found.rows, wild.rows)):
            return found
        wild = found
    return wild


def _distances(x: Array, kept: slice | Mask) -> Array | None:
    """Distances (n,) of points (n, 3) from the algebraic ellipsoid through the kept ones; None where none fits.

    The ellipsoid is refitted where the refit is an ellipsoid too.
    """
    try:
        scaled = Standardised.of(x[kept])
        theta = fit_ellipsoid_specific(scaled.x)
        found = Ellipsoid.of_quadric(refit(scaled.x, theta).theta) or Ellipsoid.of_quadric(theta)
    except (ArithmeticError, np.linalg.LinAlgError):
        return None
    if found is None:
        return None
    points = mapped(x, scaled.middle_nT + scaled.scale_nT * found.centre, np.linalg.inv(found.root))
    return np.asarray(lengths(points) - scaled.scale_nT)
