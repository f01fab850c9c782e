"""When a fit says nothing: from the covariance it claims, to a cause and a manoeuvre that would help."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

import numpy as np

from calib.numerics.points import mean_and_spread
from calib.result import Calibration, Status
from scenarios.arrays import Array
from scenarios.text import figure

MAX_STD_FRACTION = 0.01
"""Unobservable: a claimed offset less certain than 1 % of the field in any direction, or S than 1 %."""
ALTERNATIONS = 10
"""Rounds in which the two directions of the largest deviation of S are found."""
SOFT_IRON = re.compile("S_[xyz][xyz]")
"""Names of the entries of S."""
SIGNIFICANT_THICKNESS = 5.0
"""Motion out of a plane counts when its rms is this many times the noise."""
SIGNIFICANT_ANGLE = 5.0
"""Motion counts when its rms angle is this many times the attitude's own error."""
ROUNDING = 1e-7
"""Thickness that rounding alone gives exactly planar measurements, as a fraction of their extent."""
DIGITS = 2
"""Digits of a direction's components in words, so that the words do not depend on the processor's rounding."""
MANOEUVRES = (
    "yaw and pitch further, nose up and down",
    "yaw and roll further, on either side",
    "roll and pitch further away from level",
)
"""Manoeuvres that vary the field along body x, y, z: turns about the remaining two axes."""


def rounded_sizes(values: Array) -> Array:
    """Sizes of values (n,) as parts of the largest, on DIGITS digits: equal where only rounding differs."""
    size = np.abs(values)
    return np.asarray(np.round(size / size.max(), DIGITS))


def main_axis(direction: Array) -> int:
    """The axis of a body direction (3,), judged by `rounded_sizes`: of components equal to rounding, the first."""
    return int(np.argmax(rounded_sizes(direction)))


def axis_text(direction: Array) -> str:
    """A body direction (3,) in words: the main axis, with components where the direction is not along the axis."""
    unit = direction / np.linalg.norm(direction)
    main = main_axis(direction)
    unit = np.round(unit * np.sign(unit[main]), DIGITS) + 0.0  # never -0.00
    text = f"body {'xyz'[main]}"
    return text if unit[main] > 0.98 else f"{text} (direction {unit[0]:.2f}, {unit[1]:.2f}, {unit[2]:.2f})"


def remedy_text(direction: Array) -> str:
    """The manoeuvre that excites a body direction (3,)."""
    return MANOEUVRES[main_axis(direction)]


def unobservable(direction: Array, why: str) -> Status:
    """Status for an offset not observable along a body direction (3,)."""
    return Status(
        "unobservable", f"the offset along {axis_text(direction)} cannot be determined: {why}; {remedy_text(direction)}"
    )


@dataclass(frozen=True, eq=False)
class Extent:
    """How far measurements extend: variance (3,), nT^2, rising, along their principal axes (3, 3), in columns."""

    variance: Array
    axes: Array

    @classmethod
    def of(cls, mag_nT: Array) -> Extent:
        """Of measurements (n, 3); raises LinAlgError where their squares overflow."""
        return cls(*np.linalg.eigh(mean_and_spread(np.ascontiguousarray(mag_nT))[1]))

    @property
    def thickness_nT(self) -> float:
        """Rms distance of the measurements from the nearest plane."""
        return float(np.sqrt(max(self.variance[0], 0.0)))

    @property
    def thinnest(self) -> Array:
        """The body direction (3,) of smallest extent."""
        return np.asarray(self.axes[:, 0])


def planar_status(extent: Extent, noise_std_nT: float = 0.0) -> Status | None:
    """Unobservable when the measurements leave a plane by no more than five times the noise, rms; else None."""
    thickness_nT = extent.thickness_nT
    if thickness_nT > max(SIGNIFICANT_THICKNESS * noise_std_nT, ROUNDING * float(np.sqrt(extent.variance[-1]))):
        return None
    return unobservable(extent.thinnest, f"the measurements lie in a plane to within {figure(thickness_nT)} nT rms")


def motion_status(h_nT: Array, strength_nT: float, attitude_std_rad: float) -> Status | None:
    """Unobservable when the known field h (n, 3) moves along some body direction by less than the attitude's errors."""
    variance, axes = np.linalg.eigh(np.cov(h_nT.T))
    angle_rad = np.sqrt(max(variance[0], 0.0)) / strength_nT
    if angle_rad > max(SIGNIFICANT_ANGLE * attitude_std_rad, 1e-9):
        return None
    return unobservable(axes[:, 0], f"the field along it varies by only {figure(np.degrees(angle_rad), 2)} degrees rms")


def covariance_status(fit: Calibration, strength_nT: float) -> Status | None:
    """Unobservable when the claimed covariance exceeds MAX_STD_FRACTION; None when fine or none is claimed.

    Judged in the calibrated field, h = A (m - b) with A = S^-1: A C_b A^T against F^2, and A dS against 1.
    """
    offset_nT2 = fit.offset_covariance_nT2
    if fit.covariance is None or offset_nT2 is None:
        return None
    loose = _loose_soft_iron(fit)
    variance, axes = np.linalg.eigh(fit.matrix @ offset_nT2 @ fit.matrix.T)
    worst = float(np.sqrt(max(variance[-1], 0.0)))
    if worst > MAX_STD_FRACTION * strength_nT:
        share = f"{figure(100 * worst / strength_nT)} % of the field, the limit is {100 * MAX_STD_FRACTION:g} %"
        limits = (
            "this motion and noise cannot rule out soft iron, and with it" if loose else "with this motion and noise"
        )
        return unobservable(axes[:, -1], f"{limits} its standard deviation is {figure(worst)} nT ({share})")
    if loose:
        return Status(
            "unobservable",
            f"the soft iron is uncertain by more than {100 * MAX_STD_FRACTION:g} % along some direction, standard "
            f"deviation {', '.join(loose)}: turn about more axes, at varying rate, through larger angles",
        )
    return None


def _loose_soft_iron(fit: Calibration) -> list[str]:
    """Entries of S, with their standard deviations in parts of S, where S is less certain than MAX_STD_FRACTION.

    In any axes: the largest deviation of v^T A dS u over unit vectors u and v.
    """
    assert fit.covariance is not None
    names = [name for name in fit.covariance_names if SOFT_IRON.fullmatch(name)]
    if not names:
        return []
    rows = [fit.covariance_names.index(name) for name in names]
    covariance = fit.covariance[np.ix_(rows, rows)]
    moved = fit.matrix @ _entries(tuple(names))
    if _largest_variance(moved, covariance, MAX_STD_FRACTION**2) <= MAX_STD_FRACTION**2:
        return []
    std = np.sqrt(np.clip(np.diag(covariance), 0.0, None)) / np.linalg.norm(np.linalg.inv(fit.matrix), 2)
    told = std >= min(MAX_STD_FRACTION, std.max())
    return [f"{name} ({figure(s, 2)})" for name, s, tell in zip(names, std, told, strict=True) if tell]


def _largest_variance(moved: Array, covariance: Array, enough: float) -> float:
    """Variance of v^T (sum_p moved_p dp) u, u and v in turn those of the largest; moved (k, 3, 3).

    A bound of it, the largest mean square of |(sum_p moved_p dp) u|, where that is at most `enough`.
    """
    k = len(moved)
    rows = (covariance @ moved.reshape(k, 9)).reshape(k, 3, 3)
    bound, axes = np.linalg.eigh(moved.reshape(-1, 3).T @ rows.reshape(-1, 3))
    if bound[-1] <= enough:
        return float(bound[-1])
    u, variance = axes[:, -1], 0.0
    for _ in range(ALTERNATIONS):
        for side in (moved, moved.transpose(0, 2, 1)):
            seen = side @ u
            values, directions = np.linalg.eigh(seen.T @ covariance @ seen)
            variance, u = float(values[-1]), directions[:, -1]
    return variance


@cache
def _entries(names: tuple[str, ...]) -> Array:
    """dS / d S_ij (k, 3, 3) of parameters S_ij: both entries where S is symmetric."""
    steps = np.zeros((len(names), 3, 3))
    for step, name in zip(steps, names, strict=True):
        i, j = ("xyz".index(axis) for axis in name[2:])
        step[i, j] = 1.0
        if f"S_{'xyz'[j]}{'xyz'[i]}" not in names:
            step[j, i] = 1.0
    return steps
