"""What the sections of an inspection share about one magnetometer, computed once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, get
from calib.numerics.noise import white_noise
from recordings import Recording
from recordings.checks import FIELD_RANGE_NT
from recordings.units import UNITS, likely_unit
from scenarios.arrays import Array
from validation.inspection.log import Series
from validation.inspection.rates import stale
from validation.signals.faults import runs
from validation.signals.intervals import gaps_after, usual_interval
from validation.signals.lattice import Lattice, find_lattice

MOST_NOISE_SHARE = 0.05
"""Differences of neighbours above this share of the field are motion between samples, not noise."""
MOST_SPREAD = 0.1
"""Spread of the strength after the ellipsoid fit, beyond which the fit has not found the field."""
LEAST_ROWS = 30
UNEVEN_INTERVAL, MOST_UNEVEN_SHARE = 0.3, 0.2
"""A spectrum bears intervals off by so much, for so large a share of the samples."""


@dataclass(frozen=True)
class Residual:
    """The part (n, k) of the field that a base model leaves, at rows `index` of the series, nT.

    base : "attitude": field = S R^T h + b fitted, x, y, z are left; "strength": |h| of the ellipsoid fit less its mean;
    "mean": field less its mean, with the motion still in it.
    """

    base: Literal["attitude", "strength", "mean"]
    index: NDArray[np.intp]
    time_s: Array
    values: Array


@dataclass(frozen=True)
class Look:
    """One magnetometer's series, taken in `unit` (nT, or what its strength suggests), and what was derived from it.

    fresh : rows of the series that are not mere repeats of a slower sensor, `fresh_s` their times. white_nT : (3,), NaN
    where the motion between samples hides it, an upper bound unless `settled`. ellipsoid : that fit, the reference
    being the median strength.
    """

    sensor: int | None
    series: Series
    unit: str
    lattices: tuple[Lattice | None, ...]
    fresh: NDArray[np.intp]
    fresh_s: Array
    white_nT: Array
    settled: bool
    ellipsoid: Calibration
    residual: Residual | None

    @property
    def even(self) -> bool:
        """Whether the samples follow at even enough intervals for a spectrum."""
        step = np.diff(self.fresh_s)
        return len(step) > 2 and bool(np.mean(np.abs(step / np.median(step) - 1) > UNEVEN_INTERVAL) < MOST_UNEVEN_SHARE)

    @property
    def rate_hz(self) -> float:
        """Samples a second between gaps, NaN of fewer than three."""
        return 1.0 / usual_interval(self.fresh_s) if len(self.fresh) > 2 else float("nan")

    @property
    def strength_nT(self) -> float:
        """Median strength of the measured field."""
        return median_strength(self.series.mag_nT)

    @property
    def corrected_nT(self) -> Array | None:
        """The field (n, 3) after the ellipsoid fit, None where that did not succeed."""
        if self.ellipsoid.status.kind != "ok":
            return None
        field_nT = self.ellipsoid.apply(Recording(self.series.time_s, self.series.mag_nT))
        strength = np.linalg.norm(field_nT, axis=1)
        return field_nT if strength.std() < MOST_SPREAD * strength.mean() else None


def look_at(series: Series, sensor: int | None) -> Look:
    """Derive what the sections need from one magnetometer's sound rows."""
    unit = _unit(series)
    series = series.scaled(UNITS["mag"][unit][0])
    lattices = tuple(find_lattice(column) for column in series.mag_nT.T)
    slower = stale(series.mag_nT)
    fresh = runs(series.mag_nT)[0] if slower else np.arange(len(series))
    fresh_s = _spread_evenly(series.time_s[fresh]) if slower else series.time_s
    white_nT, settled = white_noise(series.mag_nT[fresh], gaps_after(fresh_s))
    white_nT = np.where(white_nT < MOST_NOISE_SHARE * median_strength(series.mag_nT), white_nT, np.nan)
    known = (fresh, fresh_s, white_nT, bool(settled.all()))
    look = Look(sensor, series, unit, lattices, *known, _ellipsoid(series), None)
    return replace(look, residual=_residual(look))


def median_strength(mag_nT: Array) -> float:
    """Median norm of a field (n, 3); NaN of none."""
    return float(np.median(np.linalg.norm(mag_nT, axis=1))) if len(mag_nT) else float("nan")


def attitude_of(series: Series) -> Array | None:
    """Unit quaternions (n, 4), a held attitude interpolated between its changes; None where there is none."""
    if series.att_q is None:
        return None
    norm = np.linalg.norm(series.att_q, axis=1)
    known = np.isfinite(norm) & (norm > 0.5) & (norm < 2)
    if known.sum() < LEAST_ROWS:
        return None
    q = series.att_q[known]
    keep = runs(q)[0] if stale(q) else np.arange(len(q))
    nodes = q[keep] / np.linalg.norm(q[keep], axis=1, keepdims=True)
    signs = np.cumprod(np.r_[1.0, np.where(np.sum(nodes[1:] * nodes[:-1], axis=1) < 0, -1.0, 1.0)])
    at_s = series.time_s[known][keep]
    filled = np.column_stack([np.interp(series.time_s, at_s, column) for column in (nodes * signs[:, None]).T])
    filled[(series.time_s < at_s[0]) | (series.time_s > at_s[-1])] = np.nan
    return np.asarray(filled / np.linalg.norm(filled, axis=1, keepdims=True))


def _unit(series: Series) -> str:
    strength = median_strength(series.mag_nT)
    low, high = FIELD_RANGE_NT
    return "nT" if low <= strength <= high or not strength > 0 else likely_unit(strength) or "nT"


def _spread_evenly(time_s: Array) -> Array:
    """Times (n,) of a slower sensor's values, which the rows know to a row only: evenly between gaps."""
    step = np.diff(time_s)
    breaks = np.flatnonzero(step > 2.5 * step.mean()) + 1
    parts = np.split(time_s, breaks)
    return np.concatenate([np.linspace(part[0], part[-1], len(part)) for part in parts])


def _ellipsoid(series: Series) -> Calibration:
    strength = median_strength(series.mag_nT)
    reference = Reference(strength if strength > 0 else 1.0)
    return get("ellipsoid").fit(Recording(series.time_s, series.mag_nT), reference)


def _residual(look: Look) -> Residual | None:
    series = look.series
    if len(look.fresh) < LEAST_ROWS:
        return None
    q = attitude_of(series)
    if q is not None:
        known = np.isfinite(q[look.fresh]).all(axis=1)
        index = look.fresh[known]
        if len(index) >= LEAST_ROWS:
            values = _unexplained(q[index], series.mag_nT[index])
            return Residual("attitude", index, look.fresh_s[known], values)
    field_nT = look.corrected_nT
    if field_nT is not None:
        strength = np.linalg.norm(field_nT[look.fresh], axis=1)
        return Residual("strength", look.fresh, look.fresh_s, (strength - strength.mean())[:, None])
    values = series.mag_nT[look.fresh]
    return Residual("mean", look.fresh, look.fresh_s, values - values.mean(axis=0))


def _unexplained(q: Array, mag_nT: Array) -> Array:
    """Field (n, 3) less its regression on the nine elements of R and a constant: any S, h and b of m = S R^T h + b."""
    columns = np.column_stack([Rotation.from_quat(q, scalar_first=True).as_matrix().reshape(-1, 9), np.ones(len(q))])
    return np.asarray(mag_nT - columns @ np.linalg.lstsq(columns, mag_nT, rcond=1e-10)[0])
