"""Changes by part: offset, scale, soft iron, motor currents, each with interval, test and heading error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from calib import Calibration
from calib.observability import MAX_STD_FRACTION
from scenarios.arrays import Array
from validation.rechecking.change import ChangeEstimate
from validation.rechecking.heading import anywhere, heading_columns

FALSE_ALARM = 0.01
"""Chance at most that a change is called significant where there is none, shared among the tests."""
NEGLIGIBLE = 0.1
"""Share of the tolerance below which a significant change does not count, by the angle that the change can turn the
horizontal field in any attitude: a long log shows changes of a nanotesla."""
SCALE, OFFSET, SOFT_IRON, MOTORS, JOINT = "scale", "offset", "soft iron", "motor currents", "offset or soft iron"
ROUNDING = 1e-10
"""Eigenvalue of a scaled covariance below which a direction is a sum that is zero, as of the diagonal of soft iron."""


@dataclass(frozen=True, eq=False)
class PartChange:
    """Change of one part, with 95 % intervals.

    what : offset, scale, soft iron, motor currents. value, std : per component, in `unit`; chance : of as large an
    estimate without a change; significant : below the limit of the tests. heading_deg : the largest heading error that
    this part makes by itself.
    """

    what: str
    value: Array
    std: Array
    unit: str
    chance: float
    significant: bool
    heading_deg: float
    angle_deg: float

    def shows(self, tolerance_deg: float) -> bool:
        """Return whether the change is significant and not negligible; a scale turns no heading."""
        counts = self.what != SCALE and self.angle_deg > NEGLIGIBLE * tolerance_deg
        return self.significant and counts


@dataclass(frozen=True, eq=False)
class _Part:
    """A part's rows (k, p): value = rows (values of the estimate), with the unit, and the number of free values."""

    what: str
    rows: Array
    unit: str
    freedom: int


def changed_parts(
    old: Calibration, estimate: ChangeEstimate, covariance: Array, dip_rad: float, unit: str
) -> tuple[PartChange, ...]:
    """Return the change of each part; offset and soft iron together where the motion does not separate them.

    covariance (p, p) : with the old calibration's. unit : of an offset, nT or counts.
    """
    wanted = _parts(old, estimate, unit)
    limit = FALSE_ALARM / (len(wanted) + 1)
    level, angle = heading_columns(estimate, dip_rad), anywhere(estimate, dip_rad)
    found = [_change(one, limit, estimate.values, covariance, level, angle) for one in wanted]
    joint = None if _separated(estimate) else _joint(wanted, estimate.values, covariance, unit)
    if any(part.significant for part in found if part.what != SCALE) or joint is None:
        return tuple(found)
    return (*found, _change(joint, limit, estimate.values, covariance, level, angle))


def _separated(estimate: ChangeEstimate) -> bool:
    """Return whether the motion determines offset and soft iron each, as well as an accepted calibration does."""
    both = slice(0, 3 + estimate.entries)
    worst_nT2 = float(np.linalg.eigvalsh(estimate.covariance[both, both])[-1])
    return worst_nT2 < (MAX_STD_FRACTION * estimate.strength_nT) ** 2


def motors_seen(estimate: ChangeEstimate) -> bool:
    """Return whether the motors' terms together are significant."""
    rows = np.eye(len(estimate.values))[3 + estimate.entries :]
    return _chance(rows @ estimate.values, rows @ estimate.covariance @ rows.T, len(rows)) < FALSE_ALARM


def _parts(old: Calibration, estimate: ChangeEstimate, unit: str) -> list[_Part]:
    """Return the parts: the offset of the measurement, E's mean gain, the rest of E, and the motors' terms."""
    p, m, to_percent = len(estimate.values), estimate.entries, 100.0 / estimate.strength_nT
    offset, trace = np.zeros((3, p)), np.zeros((1, p))
    offset[:, :3] = np.linalg.inv(old.matrix)
    diagonal = np.einsum("mii->m", estimate.slots)
    trace[0, 3 : 3 + m] = diagonal / 3.0
    soft = np.eye(p)[3 : 3 + m] - diagonal[:, None] * trace
    found = [
        _Part(OFFSET, offset, unit, 3),
        _Part(SCALE, to_percent * trace, "%", 1),
        _Part(SOFT_IRON, to_percent * soft, "%", m - 1),
    ]
    if estimate.motors:
        amperes = np.repeat([largest for _, largest in estimate.motors], 3)
        found.append(_Part(MOTORS, np.eye(p)[3 + m :] / amperes[:, None], f"{unit}/A", len(amperes)))
    return found


def _change(part: _Part, limit: float, values: Array, covariance: Array, level: Array, angle: Array) -> PartChange:
    value, spread = part.rows @ values, part.rows @ covariance @ part.rows.T
    alone = np.linalg.pinv(part.rows) @ value
    chance = _chance(value, spread, part.freedom)
    return PartChange(
        part.what,
        value,
        np.sqrt(np.diag(spread)),
        part.unit,
        chance,
        chance < limit,
        float(np.abs(level @ alone).max()),
        float(np.linalg.norm(angle @ alone, axis=1).max()),
    )


def _joint(parts: list[_Part], values: Array, covariance: Array, unit: str) -> _Part | None:
    """Return offset and soft iron together, along the direction in which the log shows most; None for no direction."""
    rows = np.concatenate([parts[0].rows, parts[2].rows])
    freedom = parts[0].freedom + parts[2].freedom
    value, spread = rows @ values, rows @ covariance @ rows.T
    size = _sizes(spread)
    along = (np.linalg.pinv(spread / np.outer(size, size), rcond=ROUNDING, hermitian=True) @ (value / size)) / size
    direction = along @ rows
    length = float(np.linalg.norm(direction))
    return _Part(JOINT, direction[None] / length, unit, freedom) if length > 0 else None


def _chance(value: Array, spread: Array, freedom: int) -> float:
    """Return the chance of as large an estimate of zeros: Wald's test, chi squared."""
    size = _sizes(spread)
    inverse = np.linalg.pinv(spread / np.outer(size, size), rcond=ROUNDING, hermitian=True)
    return float(chi2.sf(value / size @ inverse @ (value / size), freedom))


def _sizes(spread: Array) -> Array:
    return np.sqrt(np.diag(spread)).clip(np.finfo(float).tiny)
