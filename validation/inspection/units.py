"""Units that look wrong, with the option that says so."""

from __future__ import annotations

import numpy as np

from recordings.checks import FIELD_RANGE_NT
from recordings.columns import mag_names
from recordings.units import STANDARD_GRAVITY_M_S2
from validation.inspection.finding import Finding
from validation.inspection.log import RawLog, Series
from validation.inspection.sensor_data import Look
from validation.text import figure

SECTION = "units"
EARTH_NT = (20_000.0, 70_000.0)
"""Strengths of the Earth's field, rounded outwards."""
USUAL_NT = 50_000.0
GRAVITY_TOLERANCE = 0.2
"""How far the median specific force may be from gravity."""


def unit_findings(log: RawLog, look: Look, raw: Series) -> list[Finding]:
    """Strength of the field and of gravity against what they can be; `raw` is the series in the file's own unit."""
    if not len(raw):
        return []
    return [_field(log, look, raw), *_gravity(log, look)]


def _field(log: RawLog, look: Look, raw: Series) -> Finding:
    strength = float(np.median(np.linalg.norm(raw.mag_nT, axis=1)))
    names = mag_names(look.sensor)

    def found(text: str, level: str) -> Finding:
        return Finding(SECTION, "strength", strength, "nT", text, "warning" if level else "ok", look.sensor)

    if look.unit != "nT":
        maps = " ".join(f"--map {name}={log.sources.get(name, name)},unit={look.unit}" for name in names)
        text = f"The median strength, {figure(strength)}, is no field in nT but one in {look.unit}: {maps}. "
        return found(text + f"This report takes it as {look.unit}.", "warning")
    if not FIELD_RANGE_NT[0] <= strength <= FIELD_RANGE_NT[1]:
        scale = figure(USUAL_NT / strength) if strength > 0 else "<nT a count>"
        maps = f"--map {names[0]}={log.sources.get(names[0], names[0])},scale={scale}"
        text = (
            f"The median strength, {figure(strength)}, is no field in any unit, perhaps raw counts: {maps} and alike "
        )
        return found(text + "for y and z would make it 50,000 nT.", "warning")
    if not EARTH_NT[0] <= strength <= EARTH_NT[1]:
        text = f"The median strength is {figure(strength, 4)} nT; the Earth's field has 20,000 to 70,000: "
        return found(text + "a strong magnet or iron nearby, or a scale factor.", "warning")
    return found(f"The median strength, {figure(strength, 5)} nT, is one of the Earth's field.", "")


def _gravity(log: RawLog, look: Look) -> list[Finding]:
    """Strength of the specific force: most of the time near gravity."""
    accel = look.series.accel_m_s2
    if accel is None:
        return []
    size = float(np.nanmedian(np.linalg.norm(accel, axis=1)))
    if abs(size / STANDARD_GRAVITY_M_S2 - 1) < GRAVITY_TOLERANCE:
        text = f"The median specific force, {size:.3f} m/s^2, is gravity."
        return [Finding(SECTION, "gravity", size, "m/s^2", text)]
    for unit, gravity in (("g", 1.0), ("mg", 1000.0)):
        if abs(size / gravity - 1) < GRAVITY_TOLERANCE:
            name = log.sources.get("accel_x_m_s2", "accel_x_m_s2")
            text = f"The median specific force is {figure(size)}: it looks like {unit} "
            text += f"(--map accel_x_m_s2={name},unit={unit}, y and z alike)."
            return [Finding(SECTION, "gravity", size, "m/s^2", text, "warning")]
    text = f"The median specific force is {figure(size)} m/s^2, not gravity's 9.8: check its unit."
    return [Finding(SECTION, "gravity", size, "m/s^2", text, "warning")]
