"""Units that are probably wrong, with the option that sets the right unit."""

from __future__ import annotations

import numpy as np

from recordings.checks import FIELD_RANGE_NT
from recordings.columns import mag_names
from recordings.likely_units import half_extent, in_earth
from recordings.reading import COUNT
from recordings.units import STANDARD_GRAVITY_M_S2
from validation.inspection.finding import Finding
from validation.inspection.log import RawLog, Series
from validation.inspection.sensor_data import SensorData
from validation.policy import POLICY
from validation.text import figure

SECTION = "units"
USUAL_NT = 50_000.0
"""Typical strength of the Earth's field."""
EARTH = " to ".join(figure(one) for one in POLICY.earth_nT) + " nT"


def unit_findings(log: RawLog, data: SensorData, raw: Series) -> list[Finding]:
    """Return findings on strength and gravity; `raw` is the series in the file's unit."""
    if not len(raw):
        return []
    return [_field(log, data, raw), *_gravity(log, data)]


def _field(log: RawLog, data: SensorData, raw: Series) -> Finding:
    strength = float(np.median(np.linalg.norm(raw.mag_nT, axis=1)))
    names = mag_names(data.sensor)

    def found(text: str, level: str) -> Finding:
        return Finding(SECTION, "strength", strength, "nT", text, "warning" if level else "ok", data.sensor)

    if log.origin.unit == COUNT:
        text = (
            "No unit fits the values: they count as raw counts, also where this report says nT. Calibrators find the "
        )
        return found(text + "gain by the field's strength; --unit or --map state a unit.", "")
    if data.unit != "nT":
        maps = " ".join(f"--map {name}={log.sources.get(name, name)},unit={data.unit}" for name in names)
        text = f"The median strength, {figure(strength)}, is a plausible field in {data.unit}, not in nT: {maps}. "
        return found(text + f"This report assumes {data.unit}.", "warning")
    hard_iron = "" if log.refusal else _hard_iron(raw, strength)
    if hard_iron:
        return found(hard_iron, "")
    if not FIELD_RANGE_NT[0] <= strength <= FIELD_RANGE_NT[1]:
        scale = figure(USUAL_NT / strength) if strength > 0 else "<nT a count>"
        maps = f"--map {names[0]}={log.sources.get(names[0], names[0])},scale={scale}"
        text = f"The median strength, {figure(strength)}, is not plausible in any unit, perhaps raw counts: {maps} "
        return found(text + f"and alike for y and z would make it {figure(USUAL_NT)} nT.", "warning")
    if not POLICY.earth_nT[0] <= strength <= POLICY.earth_nT[1]:
        text = f"The median strength is {figure(strength, 4)} nT, but the Earth's field has {EARTH}: "
        return found(text + "a strong magnet or iron nearby, or a wrong scale factor.", "warning")
    text = f"The median raw strength, {figure(strength, 5)} nT with iron, lies where the Earth's field does ({EARTH})."
    return found(text, "")


def _hard_iron(raw: Series, strength: float) -> str:
    """Return why a strength beyond the Earth's is one of hard iron, "" where the field does not vary as the Earth's."""
    varies = float(half_extent(raw.mag_nT).max())
    if strength <= POLICY.earth_nT[1] or not in_earth(varies):
        return ""
    text = f"The median strength, {figure(strength)} nT, is mostly hard iron: an axis varies by {figure(varies)} nT on "
    return f"{text}either side, as in the Earth's field."


def _gravity(log: RawLog, data: SensorData) -> list[Finding]:
    """Return a finding on the median specific force, which is near gravity."""
    accel = data.series.accel_m_s2
    if accel is None:
        return []
    size = float(np.nanmedian(np.linalg.norm(accel, axis=1)))
    if abs(size / STANDARD_GRAVITY_M_S2 - 1) < POLICY.gravity_tolerance:
        text = f"The median specific force, {size:.3f} m/s^2, agrees with gravity."
        return [Finding(SECTION, "gravity", size, "m/s^2", text)]
    for unit, gravity in (("g", 1.0), ("mg", 1000.0)):
        if abs(size / gravity - 1) < POLICY.gravity_tolerance:
            name = log.sources.get("accel_x_m_s2", "accel_x_m_s2")
            text = f"The median specific force is {figure(size)}: probably in {unit} "
            text += f"(--map accel_x_m_s2={name},unit={unit}, y and z alike)."
            return [Finding(SECTION, "gravity", size, "m/s^2", text, "warning")]
    text = f"The median specific force is {figure(size)} m/s^2, not gravity's 9.8: check its unit."
    return [Finding(SECTION, "gravity", size, "m/s^2", text, "warning")]
