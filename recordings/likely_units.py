"""Units that neither a name nor an option tells, from the values: of field, time, specific force and body rate."""

from __future__ import annotations

import numpy as np

from recordings.reading import COUNT
from recordings.units import STANDARD_GRAVITY_M_S2, UNITS, likely_unit
from scenarios.arrays import Array
from scenarios.text import figure

EARTH_EXTENT_NT = (8_000.0, 80_000.0)
"""Half the extent of an axis while a sensor is turned: the Earth's 20,000 to 70,000 nT, less in a level turn, more by
soft iron. A decade: of two units at most one fits."""
MOST_HARD_IRON_NT = 2e6
"""No magnetometer of a vehicle measures more; a unit that asks for more is wrong."""
TAIL = 0.04
"""Share of the values at each end that is left out of an extent: sentinels and wild values."""
SECOND_AXIS = 0.5
"""The second widest axis over the widest, above which a sensor was turned and the extent tells the unit."""
TURNED = 0.05
"""Extent over strength above which the extent tells the unit; below the strength does."""
EPOCHS = (("ns", 1e17), ("us", 1e14), ("ms", 1e11))
"""Least stamp since 1970 in each unit: later than 1973, and in a coarser unit thousands of years ahead."""
USUAL_RATE_RAD_S = (0.005, 10.0)
"""Median rates at which a sensor is turned, from a circle of 1,000 s to a shaken hand."""
SAMPLED = 20_000
"""Rows that are looked at."""


def half_extent(field: Array) -> Array:
    """Return half the extent (k,) of each axis of a field (n, k), without the outermost TAIL at each end."""
    finite = field[np.isfinite(field).all(axis=1)]
    some = finite[:: max(1, len(finite) // SAMPLED)]
    if not len(some):
        return np.zeros(field.shape[1])
    low, high = np.quantile(some, (TAIL, 1 - TAIL), axis=0)
    return np.asarray((high - low) / 2)


def field_unit(field: Array) -> str:
    """Return the unit in which a field (n, k) is the Earth's, by the extent or else the strength; COUNT for none."""
    field = field[:: max(1, len(field) // SAMPLED)]
    extents = np.sort(half_extent(field))
    with np.errstate(invalid="ignore", over="ignore"):
        strength = float(np.nanmedian(np.linalg.norm(field, axis=1))) if len(field) else 0.0
    by_strength = likely_unit(strength)
    widest = float(extents[-1])
    turned = extents[-2] > SECOND_AXIS * widest and widest > TURNED * strength
    for unit, (factor, _) in UNITS["mag"].items():
        if in_earth(factor * widest) and factor * strength < MOST_HARD_IRON_NT:
            return unit if turned or by_strength is None else by_strength
    if by_strength is not None and not turned:
        return by_strength
    return COUNT


def in_earth(extent_nT: float) -> bool:
    """Return whether an axis varies by what a sensor turned in the Earth's field shows."""
    return EARTH_EXTENT_NT[0] <= extent_nT < EARTH_EXTENT_NT[1]


def stamp_unit(stamps: Array) -> str | None:
    """Return the unit of stamps (n,) that count from 1970, None for other times."""
    finite = stamps[np.isfinite(stamps)]
    first = float(np.median(finite[:99])) if len(finite) else 0.0
    return next((unit for unit, least in EPOCHS if first >= least), None)


def time_unit(stamps: Array, field: Array) -> str:
    """Return the unit of stamps (n,) with which a field (n, k) turns at a usual rate; seconds where that is unknown.

    Steps below a second are seconds: whole milliseconds are 1 at least.
    """
    step = float(np.nanmedian(np.diff(stamps))) if len(stamps) > 2 else 0.0
    size = float(half_extent(field).max())
    if step < 1 or not size > 0 or not (stamps == np.round(stamps)).all():
        return "s"
    turn = float(np.nanmedian(np.linalg.norm(np.diff(field, axis=0), axis=1))) / size
    if turn > 1:  # poses far apart: their order tells nothing
        return "s"
    usual = [unit for unit in ("s", "ms", "us", "ns") if _is_usual(turn / (step * UNITS["time"][unit][0]))]
    return usual[0] if usual else "s"


def _is_usual(rate_rad_s: float) -> bool:
    return USUAL_RATE_RAD_S[0] < rate_rad_s < USUAL_RATE_RAD_S[1]


def accel_factor(accel: Array) -> tuple[float, str]:
    """Return the factor to m/s^2 and its words for a specific force (n, 3), whose median is gravity; 0 for none."""
    size = float(np.nanmedian(np.linalg.norm(accel, axis=1)))
    for unit in ("m/s^2", "g", "mg"):
        factor = UNITS["accel"][unit][0]
        if abs(size * factor / STANDARD_GRAVITY_M_S2 - 1) < 0.2:
            return factor, unit
    if size > 5 * STANDARD_GRAVITY_M_S2:
        return STANDARD_GRAVITY_M_S2 / size, f"counts, {figure(size, 4)} of them gravity"
    return 0.0, ""


def gyro_unit(rate: Array, field: Array, time_s: Array) -> str | None:
    """Return rad/s or deg/s for a rate (n, 3), by the rate at which the field turns; None for neither.

    Without a turn of the field: deg/s for rates that no vehicle reaches in rad/s.
    """
    size = np.linalg.norm(rate, axis=1)
    extent = float(half_extent(field).max())
    step_s = np.diff(time_s)
    with np.errstate(divide="ignore", invalid="ignore"):
        turned = np.linalg.norm(np.diff(field, axis=0), axis=1) / (extent * step_s)
    moving = np.isfinite(turned) & (size[1:] > np.nanmedian(size))
    seen = float(np.nanmedian(turned[moving])) if moving.any() else 0.0
    stated = float(np.nanmedian(size[1:][moving])) if moving.any() else 0.0
    if seen > USUAL_RATE_RAD_S[0] and stated > 0:
        ratio = stated / seen
        return "rad/s" if 0.1 < ratio < 7.5 else "deg/s" if 7.5 <= ratio < 400 else None
    return "deg/s" if float(np.nanquantile(size, 0.99)) > 20 else "rad/s"
