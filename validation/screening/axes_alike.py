"""Axes that measure nothing of their own: two that measure the same, and an axis that shows noise only."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from calib.numerics.noise import white_noise_std
from calib.numerics.points import mean_and_spread
from recordings import Recording
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.screening.fault import AXES, Fault
from validation.text import figure, listed


def alike(recording: Recording) -> list[Fault]:
    """Return pairs of axes that differ by a constant and noise only; the sign may be opposite."""
    mag_nT, found = recording.mag_nT, []
    if len(mag_nT) < POLICY.least_rows:
        return []
    spreads = mean_and_spread(np.ascontiguousarray(mag_nT))[1]
    for one, other in combinations(range(3), 2):
        if not _follow(spreads[one, one], spreads[other, other], spreads[one, other]):
            continue
        x, y = mag_nT[:, one], mag_nT[:, other]
        rest, spread = min(float(np.std(x - y)), float(np.std(x + y))), float(np.std(x))
        if spread > POLICY.alike_motion * max(rest, 1e-300) and _as_noise(mag_nT[:, [one, other]], rest, spread):
            text = f"axes {AXES[one]} and {AXES[other]} measure the same: check columns and wiring"
            found.append(Fault("alike", text, np.zeros(len(mag_nT), np.bool_), "none", doubtful=True))
    return found


def _follow(one: float, other: float, both: float) -> bool:
    """Return whether two axes of these variances and covariance differ, or add up, to less than twice the limit."""
    return bool(one + other - 2 * abs(both) < (2 / POLICY.alike_motion) ** 2 * one)


def _as_noise(pair: Array, rest: float, spread: float) -> bool:
    """Return whether the difference of two axes (n, 2) is their noise, or nothing."""
    floor = float(np.hypot(*white_noise_std(pair)))
    return rest < POLICY.alike_noise * floor or rest < POLICY.alike_share * spread


def unwired(recording: Recording) -> list[Fault]:
    """Return an axis of noise only while the other two move off the ellipse of a level turn."""
    mag_nT, found = recording.mag_nT, []
    if len(mag_nT) < POLICY.least_rows:
        return []
    spread = np.sqrt(np.diag(mean_and_spread(np.ascontiguousarray(mag_nT))[1]))
    for axis in range(3):
        if POLICY.unwired_motion * spread[axis] >= np.delete(spread, axis).min():
            continue
        noise = float(white_noise_std(mag_nT[:, [axis]])[0])
        if spread[axis] < POLICY.unwired_noise * noise and not _on_ellipse(np.delete(mag_nT, axis, axis=1)):
            text = f"axis {AXES[axis]} shows only noise, {figure(float(spread[axis]))} nT rms, while "
            text += f"{listed([name for name in AXES if name != AXES[axis]])} move: check the wiring"
            found.append(Fault("unwired", text, np.zeros(len(mag_nT), np.bool_), "none", doubtful=True))
    return found


def _on_ellipse(plane: Array) -> bool:
    """Return whether points (n, 2) lie on a conic, as those of a turn about the third axis do."""
    x, y = ((plane - plane.mean(axis=0)) / plane.std(axis=0)).T
    columns = np.column_stack([x * x, x * y, y * y, x, y])
    rest = columns @ np.linalg.lstsq(columns, np.ones(len(x)), rcond=None)[0] - 1.0
    return bool(rest.std() < POLICY.on_ellipse)
