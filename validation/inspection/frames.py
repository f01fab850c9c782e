"""Do attitude, gyro, gravity and field agree: order and sense of the quaternion, unit of the rates, turned frames."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from validation.inspection.finding import Finding, Level
from validation.inspection.sensor_data import Look, attitude_of
from validation.signals.quaternion_conventions import (
    CONVENTIONS,
    EXPECTED,
    RateMatch,
    gyro_scale_from_field,
    match_rates,
    mean_direction,
    read_as,
)
from validation.text import duration, figure

SECTION = "frames"
AGREEING_SHARE, DISAGREEING_SHARE = 0.9, 0.7
"""Share of the gyro's variance that the attitude's derivative explains."""
AS_GOOD = 0.05
"""Two conventions whose shares differ by less explain the same."""
TURNED_DEG = 5.0
"""A turn between attitude and gyro that is more than the estimate's own error."""
UNIT_TOLERANCE, SCALE_TOLERANCE, FIELD_TOLERANCE = 0.2, 0.1, 0.3
"""How far a gyro's scale may be off: that of a unit, of none, and of one told by a field with soft iron in it."""
UPRIGHT_DEG = 30.0
"""The mean specific force of a motion with accelerations in it is upright to within this."""
OFF_NORTH_DEG, STEEP_DEG = 45.0, 80.0
"""Declinations are smaller but near the poles, where the field is steeper."""
KEPT_LENGTH, LOST_LENGTH = 0.95, 0.85
"""Length of the mean of unit vectors that keep, and do not keep, their direction."""
GYRO_FINDING = "gyro_and_attitude"
SERIOUS_LAG_S = 0.05
NORM_TOLERANCE = 0.02
GYRO_UNITS = {"deg/s": 180 / np.pi, "mrad/s": 1e3}
CALM_SHARE = 0.1
"""Largest deviation of the specific force from its median, of the samples whose direction is gravity's."""
LEAST_FIELD_SHARE = 0.5
"""Least share of the field's derivative that the gyro must explain before its unit is judged by it."""


def frame_findings(look: Look) -> list[Finding]:
    """What attitude, gyro, accelerometer and field say of each other."""
    q = attitude_of(look.series)
    if q is None:
        found = [_gyro_by_field(look)]
    else:
        found = [_norm(look), _gyro_by_attitude(look, q), _gravity(look, q), _field(look, q)]
    return [finding for finding in found if finding is not None]


def _norm(look: Look) -> Finding:
    assert look.series.att_q is not None
    off = np.abs(np.linalg.norm(look.series.att_q, axis=1) - 1)
    off = off[np.isfinite(off)]
    worst, wrong = float(off.max()), int(np.count_nonzero(off > NORM_TOLERANCE))
    if not wrong:
        return Finding(SECTION, "quaternion_norm", worst, "", "The quaternions have norm 1.")
    text = f"{wrong:,} quaternions are off norm 1, by {figure(worst)} at most: check order and scale of the columns."
    return Finding(SECTION, "quaternion_norm", worst, "", text, "warning")


def _gyro_by_attitude(look: Look, q: Array) -> Finding | None:
    """Convention of the quaternion, unit of the gyro, rotation and lag between the two, from the attitude's rate."""
    series = look.series
    if series.gyro_rad_s is None:
        return None
    tried = {text: match_rates(series.time_s, read_as(q, text), series.gyro_rad_s) for text in CONVENTIONS}
    matches = {text: match for text, match in tried.items() if match is not None}
    if EXPECTED not in matches:
        return Finding(SECTION, GYRO_FINDING, {}, "", "It turns too little to compare gyro and attitude.", "note")
    given, best = matches[EXPECTED], _likeliest(matches)
    value = {"share": given.share, "scale": given.scale, "angle_deg": given.angle_deg, "lag_s": given.lag_s}
    if best != EXPECTED:
        text = f"The quaternion looks like ({best}) where ({EXPECTED}) is expected: its rate explains "
        text += f"{100 * matches[best].share:.3g} % of the gyro's variance, read as expected {100 * given.share:.3g} %"
        text += "." if not given.angle_deg > TURNED_DEG else f" after a turn by {given.angle_deg:.3g} degrees."
        return Finding(SECTION, GYRO_FINDING, value, "", text, "warning")
    if given.share < DISAGREEING_SHARE:
        share = max(0.0, 100 * given.share)
        text = f"The attitude's rate explains {share:.2g} % of the gyro's variance: the two disagree."
        return Finding(SECTION, GYRO_FINDING, value, "", text, "warning")
    return _agreeing(value, given)


def _likeliest(matches: dict[str, RateMatch]) -> str:
    """The convention that explains most; of those as good the one that needs no turn, else the expected one.

    Two conventions always explain the same, after a turn by a multiple of 90 degrees about the axes.
    """
    most = max(match.share for match in matches.values())
    if most < AGREEING_SHARE:
        return EXPECTED
    good = {text: match for text, match in matches.items() if match.share > most - AS_GOOD}
    straight = [text for text, match in good.items() if match.angle_deg < TURNED_DEG]
    if EXPECTED in good and (EXPECTED in straight or not straight):
        return EXPECTED
    return (straight or list(good))[0]


def _agreeing(value: dict[str, float], given: RateMatch) -> Finding:
    """The finding where one rate explains the other: scale, lag and turn between them."""
    text = f"The attitude's rate explains {100 * given.share:.3g} % of the gyro's variance"
    unit, lag, turn = _wrong_unit(given.scale), _lag(given.lag_s), _turn(given.angle_deg)
    faults = [fault for fault in (unit, lag, turn) if fault]
    if not faults:
        return Finding(SECTION, GYRO_FINDING, value, "", text + ": order, sense, units and time agree.")
    level: Level = "warning" if unit or abs(given.lag_s) > SERIOUS_LAG_S else "note"
    return Finding(SECTION, GYRO_FINDING, value, "", f"{text}; {'; '.join(faults)}.", level)


def _wrong_unit(scale: float) -> str:
    """What is wrong with the gyro's scale, with the option that mends it; nothing where it is about 1."""
    for unit, factor in GYRO_UNITS.items():
        if abs(scale / factor - 1) < UNIT_TOLERANCE:
            return f"the gyro is {figure(scale)} times as large, as in {unit} ({_gyro_flag(unit)})"
    return f"the gyro is {figure(scale)} times as large: check its unit" if abs(scale - 1) > SCALE_TOLERANCE else ""


def _lag(lag_s: float) -> str:
    return f"the attitude comes {duration(abs(lag_s))} {'late' if lag_s > 0 else 'early'}" if lag_s else ""


def _turn(angle_deg: float) -> str:
    return f"its frame is turned by {angle_deg:.3g} degrees against the gyro's" if angle_deg > TURNED_DEG else ""


def _gyro_flag(unit: str) -> str:
    return f"--map gyro_x_rad_s=<column>,unit={unit}, y and z alike"


def _gyro_by_field(look: Look) -> Finding | None:
    """Unit of the gyro from the field's own turning, where there is no attitude."""
    series = look.series
    if series.gyro_rad_s is None:
        return None
    scale, share = gyro_scale_from_field(series.time_s, series.mag_nT, series.gyro_rad_s)
    if not share > LEAST_FIELD_SHARE:
        text = "The field's turning does not follow the gyro: another motion, another frame, or too little of it."
        return Finding(SECTION, "gyro_and_field", share, "", text, "note")
    for unit, factor in GYRO_UNITS.items():
        if abs(scale * factor - 1) < FIELD_TOLERANCE:
            text = f"The field turns {figure(scale)} times as fast as the gyro says: it looks like {unit} "
            return Finding(SECTION, "gyro_and_field", share, "", f"{text}({_gyro_flag(unit)}).", "warning")
    if abs(scale - 1) >= FIELD_TOLERANCE:
        text = f"The field turns {figure(scale)} times as fast as the gyro says: check its unit and axes."
        return Finding(SECTION, "gyro_and_field", share, "", text, "warning")
    return Finding(SECTION, "gyro_and_field", share, "", "The field turns as the gyro says: units and axes agree.")


def _gravity(look: Look, q: Array) -> Finding | None:
    """Direction of the specific force in the world, of the samples that are little accelerated."""
    body = look.series.accel_m_s2
    if body is None:
        return None
    size = np.linalg.norm(body, axis=1)
    calm = np.abs(size - np.nanmedian(size)) < CALM_SHARE * np.nanmedian(size)
    finding, mean = _kept(q, np.where(calm[:, None], body, np.nan), "gravity")
    if finding is not None:
        return finding
    tilt_deg = float(np.degrees(np.arccos(np.clip(mean[2] / np.linalg.norm(mean), -1, 1))))
    if tilt_deg < UPRIGHT_DEG:
        text = f"Turned to the world, the specific force points up, to within {tilt_deg:.2g} degrees."
        return Finding(SECTION, "gravity", tilt_deg, "deg", text)
    if tilt_deg > 180 - UPRIGHT_DEG:
        text = "Turned to the world, the specific force points down: its sign is wrong, or the world's z axis points "
        return Finding(SECTION, "gravity", tilt_deg, "deg", f"{text}down; east, north, up is expected.", "warning")
    text = f"Turned to the world, the specific force is {tilt_deg:.3g} degrees from up: the frames are turned."
    return Finding(SECTION, "gravity", tilt_deg, "deg", text, "warning")


def _field(look: Look, q: Array) -> Finding | None:
    body = look.series.mag_nT if look.corrected_nT is None else look.corrected_nT
    finding, mean = _kept(q, body, "field")
    if finding is not None:
        return finding
    east, north, up = mean
    down_deg = float(np.degrees(np.arctan2(-up, np.hypot(east, north))))
    from_north_deg = float(np.degrees(np.arctan2(east, north)))
    vertical = f"{abs(down_deg):.3g} degrees {'below' if down_deg >= 0 else 'above'} the horizon"
    side = f"{abs(from_north_deg):.3g} degrees {'east' if from_north_deg >= 0 else 'west'} of north"
    text = f"In the attitude's world the field points {vertical} and {side}"
    value = {"down_deg": down_deg, "east_of_north_deg": from_north_deg}
    if abs(from_north_deg) > OFF_NORTH_DEG and abs(down_deg) < STEEP_DEG:
        text += ": the heading is not counted from north, or the sensor is turned against the attitude's frame"
        return Finding(SECTION, "field_direction", value, "deg", text + ".", "note")
    return Finding(SECTION, "field_direction", value, "deg", text + ".")


def _kept(q: Array, body: Array, what: str) -> tuple[Finding | None, Array]:
    """Mean direction in the world as expected, and a finding where that direction is not kept."""
    means = {name: mean_direction(read_as(q, name), body) for name in CONVENTIONS}
    steady = {name: float(np.linalg.norm(mean)) for name, mean in means.items()}
    best = max(steady, key=lambda name: steady[name])
    if steady[EXPECTED] >= LOST_LENGTH:
        return None, means[EXPECTED]
    name = "gravity" if what == "gravity" else "field_direction"
    if steady[best] > KEPT_LENGTH:
        text = f"The {what} keeps its direction in the world only with the quaternion read as ({best})."
        return Finding(SECTION, name, steady, "", text, "warning"), means[EXPECTED]
    text = f"Turned to the world, the {what} does not keep its direction"
    text += ": accelerations, or frames that disagree." if what == "gravity" else ": hard iron, or turned frames."
    return Finding(SECTION, name, steady, "", text, "note"), means[EXPECTED]
