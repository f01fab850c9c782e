"""Data of a magnetometer that all sections of an inspection use, computed once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference, get
from calib.numerics.noise import white_noise
from recordings import Recording
from recordings.checks import FIELD_RANGE_NT
from recordings.streams import Interpolation, interpolated
from recordings.units import UNITS, likely_unit
from scenarios.arrays import Array
from validation.inspection.log import Series
from validation.policy import POLICY
from validation.screening.screening import ScreenedRecording, screen
from validation.signals.faults import runs
from validation.signals.held import stale
from validation.signals.intervals import gaps_after, usual_interval
from validation.signals.lattice import Lattice, find_lattice


@dataclass(frozen=True)
class Residual:
    """Residual (n, k) in nT of a simple model, at rows `index` of the series.

    base : "attitude": x, y, z after a fit of ``field = S R^T h + b``; "strength": strength after the ellipsoid fit,
    less the mean; "mean": field less the mean, motion included.
    """

    base: Literal["attitude", "strength", "mean"]
    index: NDArray[np.intp]
    time_s: Array
    values: Array


@dataclass(frozen=True)
class SensorData:
    """Series of a magnetometer, read in `unit` (nT, or as the strength suggests), and derived quantities.

    fresh, fresh_s : rows and times (m,) without repeats of a slower sensor.
    white_nT : white noise (3,), an upper bound unless `settled`, NaN where motion between samples hides the noise.
    judged : the recording that is calibrated. reference : the field there, or the median strength.
    ellipsoid : ellipsoid fit to both.
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
    judged: ScreenedRecording
    reference: Reference

    @cached_property
    def residual(self) -> Residual | None:
        """Return the residual of a simple model, None for too few rows."""
        return _residual(self)

    @cached_property
    def attitude(self) -> Array | None:
        """Return `attitude_of` the series."""
        return attitude_of(self.series)

    @cached_property
    def even(self) -> bool:
        """Return whether the intervals are even enough for a spectrum."""
        step = np.diff(self.fresh_s)
        if len(step) <= 2:
            return False
        uneven = np.abs(step / np.median(step) - 1) > POLICY.uneven_interval
        return bool(uneven.mean() < POLICY.most_uneven)

    @property
    def rate_hz(self) -> float:
        """Return samples per second between gaps, NaN for fewer than three samples."""
        return 1.0 / usual_interval(self.fresh_s) if len(self.fresh) > 2 else float("nan")

    @cached_property
    def strength_nT(self) -> float:
        """Return the median strength of the measured field."""
        return median_strength(self.series.mag_nT)

    @cached_property
    def corrected_nT(self) -> Array | None:
        """Return the field (n, 3) after the ellipsoid fit, None for a failed fit."""
        if self.ellipsoid.status.kind != "ok":
            return None
        field_nT = self.ellipsoid.apply(Recording(self.series.time_s, self.series.mag_nT))
        strength = np.linalg.norm(field_nT, axis=1)
        return field_nT if strength.std() < POLICY.most_spread * strength.mean() else None


def derive(
    series: Series, sensor: int | None, judged: ScreenedRecording | None = None, reference: Reference | None = None
) -> SensorData:
    """Derive the data of a magnetometer from the sound rows.

    judged : the sensor's recording as `magbench calibrate` screens it; the rows themselves where that refuses the file.
    """
    unit = "nT" if judged else _unit(series)
    series = series.scaled(UNITS["mag"][unit][0])
    judged = judged or screen(Recording(series.time_s, series.mag_nT))
    lattices = tuple(find_lattice(column) for column in series.mag_nT.T)
    slower = stale(series.mag_nT)
    fresh = runs(series.mag_nT)[0] if slower else np.arange(len(series))
    fresh_s = _spread_evenly(series.time_s[fresh]) if slower else series.time_s
    white_nT, settled = white_noise(series.mag_nT[fresh], gaps_after(fresh_s))
    white_nT = np.where(white_nT < POLICY.most_noise_share * median_strength(series.mag_nT), white_nT, np.nan)
    known = (fresh, fresh_s, white_nT, bool(settled.all()))
    reference = reference or _own_strength(judged.recording)
    ellipsoid = judged.judged(get("ellipsoid").fit(judged.recording, reference))
    return SensorData(sensor, series, unit, lattices, *known, ellipsoid, judged, reference)


def without_faults(data: SensorData) -> SensorData:
    """Return the data of the rows without a fault of the sensor, of which motion and noise are told."""
    found = _screened_alone(data)
    if all(fault.remedy == "none" or fault.kind == "held" for fault in found.faults):
        return data
    clean = data.series.taken(found.keep, found.recording.mag_nT)
    return replace(derive(clean, data.sensor, data.judged, data.reference), unit=data.unit)


def _screened_alone(data: SensorData) -> ScreenedRecording:
    """Return the series screened without other instruments, as judged where the log has none and rows are sound."""
    series, judged = data.series, data.judged
    others = (series.gyro_rad_s, series.accel_m_s2, series.att_q)
    bare = data.sensor is None and all(other is None for other in others) and judged.recording.current_A is None
    if bare and len(judged.keep) == len(series):
        return judged
    return screen(Recording(series.time_s, series.mag_nT))


def median_strength(mag_nT: Array) -> float:
    """Return the median norm of a field (n, 3), NaN for no rows."""
    return float(np.median(np.linalg.norm(mag_nT, axis=1))) if len(mag_nT) else float("nan")


def attitude_of(series: Series) -> Array | None:
    """Return unit quaternions (n, 4), interpolated where the attitude is held; None without attitude."""
    if series.att_q is None:
        return None
    norm = np.linalg.norm(series.att_q, axis=1)
    known = np.isfinite(norm) & (norm > POLICY.attitude_norm[0]) & (norm < POLICY.attitude_norm[1])
    if known.sum() < POLICY.least_rows:
        return None
    q = series.att_q[known]
    keep = runs(q)[0] if stale(q) else np.arange(len(q))
    nodes = q[keep] / np.linalg.norm(q[keep], axis=1, keepdims=True)
    at_s = series.time_s[known][keep]
    filled = interpolated(series.time_s, at_s, nodes, Interpolation.CHORD)
    filled[(series.time_s < at_s[0]) | (series.time_s > at_s[-1])] = np.nan
    return np.asarray(filled)


def _unit(series: Series) -> str:
    strength = median_strength(series.mag_nT)
    low, high = FIELD_RANGE_NT
    return "nT" if low <= strength <= high or not strength > 0 else likely_unit(strength) or "nT"


def _spread_evenly(time_s: Array) -> Array:
    """Return times (n,) of a slower sensor's values, evenly spread between gaps: rows give times to one row."""
    step = np.diff(time_s)
    breaks = np.flatnonzero(step > POLICY.held_pause * step.mean()) + 1
    parts = np.split(time_s, breaks)
    return np.concatenate([np.linspace(part[0], part[-1], len(part)) for part in parts])


def _own_strength(recording: Recording) -> Reference:
    """Return the median strength of a recording as reference: no status depends on the reference's size."""
    strength = median_strength(recording.mag_nT)
    return Reference(strength if strength > 0 else 1.0)


def _residual(data: SensorData) -> Residual | None:
    series = data.series
    if len(data.fresh) < POLICY.least_rows:
        return None
    q = data.attitude
    if q is not None:
        known = np.isfinite(q[data.fresh]).all(axis=1)
        index = data.fresh[known]
        if len(index) >= POLICY.least_rows:
            values = _unexplained(q[index], series.mag_nT[index])
            return Residual("attitude", index, data.fresh_s[known], values)
    field_nT = data.corrected_nT
    if field_nT is not None:
        strength = np.linalg.norm(field_nT[data.fresh], axis=1)
        return Residual("strength", data.fresh, data.fresh_s, (strength - strength.mean())[:, None])
    values = series.mag_nT[data.fresh]
    return Residual("mean", data.fresh, data.fresh_s, values - values.mean(axis=0))


def _unexplained(q: Array, mag_nT: Array) -> Array:
    """Return the field (n, 3) less the fit of ``m = S R^T h + b``: a regression on the nine elements of R and 1."""
    columns = np.column_stack([Rotation.from_quat(q, scalar_first=True).as_matrix().reshape(-1, 9), np.ones(len(q))])
    return np.asarray(mag_nT - columns @ np.linalg.lstsq(columns, mag_nT, rcond=1e-10)[0])
