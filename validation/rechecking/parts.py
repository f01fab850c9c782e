"""Changes by part: offset, scale, soft iron, motor currents, each with interval, test and heading error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from calib import Calibration
from scenarios.arrays import Array
from validation.rechecking.change import ChangeEstimate
from validation.rechecking.heading import anywhere, heading_columns
from validation.rechecking.noise import WeightedCovariances
from validation.rechecking.old_claim import with_old
from validation.rechecking.tails import ROUNDING, chance_of, reach

FALSE_ALARM = 0.01
"""Chance at most that a change is called significant where there is none, shared among the tests."""
NEGLIGIBLE = 0.1
"""Share of the tolerance below which a significant change does not count, by the angle that the change can turn the
horizontal field in any attitude: a long log shows changes of a nanotesla."""
SCALE, OFFSET, SOFT_IRON, MOTORS, JOINT = "scale", "offset", "soft iron", "motor currents", "offset or soft iron"
OUTSIDE = 0.025
"""Chance on either side of a 95 % interval."""
INTERVAL_Z = float(-ndtri(OUTSIDE))


@dataclass(frozen=True, eq=False)
class PartChange:
    """Change of one part, with 95 % intervals.

    what : offset, scale, soft iron, motor currents. value, std : per component, in `unit`, std so that INTERVAL_Z std
    is half the interval; chance : of as large an
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
    old: Calibration, estimate: ChangeEstimate, spread: WeightedCovariances, dip_rad: float, unit: str
) -> tuple[PartChange, ...]:
    """Return the change of each part; offset and soft iron together where the motion does not separate them.

    spread : covariances with the old calibration's. unit : of an offset, nT or counts.
    """
    level, angle = heading_columns(estimate, dip_rad), anywhere(estimate, dip_rad)
    wanted = _parts(old, estimate, unit)
    limit = FALSE_ALARM / (len(wanted) + 1)
    joint = None if estimate.separated else _joint(wanted, estimate.values, spread.mean, unit)
    every = [*wanted, *([] if joint is None else [joint])]
    none = _chances(old, estimate.from_none, wanted, unit)
    found = [_change(one, (limit, none.get(one.what, 0.0)), estimate.values, spread, level, angle) for one in every]
    if joint is None or not any(part.significant for part in found[:-1] if part.what != SCALE):
        return tuple(found)
    return tuple(found[:-1])


def _chances(old: Calibration, none: ChangeEstimate | None, wanted: list[_Part], unit: str) -> dict[str, float]:
    """Return the chance of each part by the estimate about no change; empty without one."""
    if none is None:
        return {}
    spread = with_old(old, none)
    joint = _joint(wanted, none.values, spread.mean, unit)
    every = [*wanted, *([] if joint is None else [joint])]
    return {one.what: _chance(one, none.values, spread) for one in every}


def _chance(part: _Part, values: Array, spread: WeightedCovariances) -> float:
    spreads = part.rows @ spread.covariances @ part.rows.T
    return chance_of(part.rows @ values, spreads, spread.weights, part.freedom)


def motors_seen(estimate: ChangeEstimate) -> bool:
    """Return whether the motors' terms together are significant."""
    rows = np.eye(len(estimate.values))[3 + estimate.entries :]
    spreads = rows @ estimate.spread.covariances @ rows.T
    return chance_of(rows @ estimate.values, spreads, estimate.spread.weights, len(rows)) < FALSE_ALARM


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


def _change(
    part: _Part,
    limits: tuple[float, float],
    values: Array,
    spread: WeightedCovariances,
    level: Array,
    angle: Array,
) -> PartChange:
    """Return a part's change; limits : of the chance, and the least chance by the estimate about no change."""
    value, spreads = part.rows @ values, part.rows @ spread.covariances @ part.rows.T
    alone = np.linalg.pinv(part.rows) @ value
    chance = max(_chance(part, values, spread), limits[1])
    stds = np.sqrt(np.einsum("kmm->km", spreads).clip(0.0))
    return PartChange(
        part.what,
        value,
        reach(OUTSIDE, stds, spread.weights) / INTERVAL_Z,
        part.unit,
        chance,
        chance < limits[0],
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


def _sizes(spread: Array) -> Array:
    return np.sqrt(np.diag(spread)).clip(np.finfo(float).tiny)
