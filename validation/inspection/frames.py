"""Agreement of attitude, gyro, gravity and field: convention of the quaternion, unit of the rates, frames."""

from __future__ import annotations

import numpy as np

from calib import Reference
from scenarios.arrays import Array
from validation.axes.estimate import axes_of, field_down
from validation.axes.frame import frame_of
from validation.axes.wording import axes_verdict
from validation.inspection.finding import Finding, Level
from validation.inspection.sensor_data import SensorData
from validation.policy import POLICY
from validation.signals.quaternion_conventions import (
    CONVENTIONS,
    EXPECTED,
    RateMatch,
    gyro_scale_from_field,
    match_rates,
    mean_direction,
    read_as,
)
from validation.text import duration, figure, sentence

SECTION = "frames"
LEAST_TOLD_DEG = 0.01
"""Smallest tilt that is told in degrees: a smaller one is rounding."""
GYRO_FINDING = "gyro_and_attitude"
GYRO_UNITS = {"deg/s": 180 / np.pi, "mrad/s": 1e3}


def frame_findings(data: SensorData, stated: str = "", reference: Reference | None = None) -> list[Finding]:
    """Return findings on the agreement of attitude, gyro, accelerometer and field.

    stated : body frame of the log as stated, "flu", "frd" or "". reference : the field there, if known.
    """
    q = data.attitude
    if q is None:
        found = [_gyro_by_field(data)]
    else:
        found = [_norm(data), _gyro_by_attitude(data, q), _gravity(data, q), _field(data, q)]
    return [*(finding for finding in found if finding is not None), *_axes_and_frame(data, q, stated, reference)]


def _axes_and_frame(data: SensorData, q: Array | None, stated: str, reference: Reference | None) -> list[Finding]:
    """Return the findings on order, sense and handedness of the magnetometer's axes, and on the body frame."""
    series = data.series
    if not len(series):
        return []
    read = None if q is None else read_as(q, EXPECTED)
    measured = {"gyro": series.gyro_rad_s, "accel": series.accel_m_s2, "q": read}
    axes = axes_of(series.time_s, series.mag_nT, **measured, down=field_down(reference), stated=stated)
    verdict, frame = axes_verdict(axes), frame_of(series.accel_m_s2, read, axes)
    level: Level = "ok" if verdict.kind == "agree" else "note" if verdict.harmless else "warning"
    value = {"verdict": verdict.kind, "axes": [axes.option(one) for one in axes.maps] if axes.speaking else []}
    taken: Level = "ok" if frame.name == "flu" else "warning" if frame.wrong else "note"
    return [
        Finding(SECTION, "axes", value, "", sentence(verdict.text), level),
        Finding(SECTION, "body_frame", frame.name, "", frame.text, taken),
    ]


def _norm(data: SensorData) -> Finding:
    assert data.series.att_q is not None
    off = np.abs(np.linalg.norm(data.series.att_q, axis=1) - 1)
    off = off[np.isfinite(off)]
    worst, wrong = float(off.max()), int(np.count_nonzero(off > POLICY.norm_tolerance))
    if not wrong:
        return Finding(SECTION, "quaternion_norm", worst, "", "The quaternions have norm 1.")
    text = f"{wrong} quaternions are off norm 1, by at most {figure(worst)}: check order and scale of the columns."
    return Finding(SECTION, "quaternion_norm", worst, "", text, "warning")


def _gyro_by_attitude(data: SensorData, q: Array) -> Finding | None:
    """Return convention of the quaternion, unit of the gyro, and rotation and lag of attitude against gyro."""
    series = data.series
    if series.gyro_rad_s is None:
        return None
    tried = {text: match_rates(series.time_s, read_as(q, text), series.gyro_rad_s) for text in CONVENTIONS}
    matches = {text: match for text, match in tried.items() if match is not None}
    if EXPECTED not in matches:
        text = "The sensor turns too little to compare gyro and attitude."
        return Finding(SECTION, GYRO_FINDING, {}, "", text, "note")
    given, best = matches[EXPECTED], _likeliest(matches)
    value = {"share": given.share, "scale": given.scale, "angle_deg": given.angle_deg, "lag_s": given.lag_s}
    if best != EXPECTED:
        text = f"The quaternion is probably ({best}), but ({EXPECTED}) is expected: the rate explains "
        text += (
            f"{figure(100 * matches[best].share)} % of the gyro's variance, read as expected "
            f"{figure(100 * given.share)} %"
        )
        text += (
            "." if not given.angle_deg > POLICY.turned_deg else f" after a turn by {figure(given.angle_deg)} degrees."
        )
        return Finding(SECTION, GYRO_FINDING, value, "", text, "warning")
    if given.share < POLICY.disagreeing_share:
        share = max(0.0, 100 * given.share)
        text = f"The attitude's rate explains {figure(share, 2)} % of the gyro's variance: attitude and gyro disagree."
        return Finding(SECTION, GYRO_FINDING, value, "", text, "warning")
    return _agreeing(value, given)


def _likeliest(matches: dict[str, RateMatch]) -> str:
    """Return the convention with the largest explained share; without a turn if several are as good.

    Two conventions always explain equal shares after a turn by a multiple of 90 degrees about the axes.
    """
    most = max(match.share for match in matches.values())
    if most < POLICY.agreeing_share:
        return EXPECTED
    good = {text: match for text, match in matches.items() if match.share > most - POLICY.as_good}
    straight = [text for text, match in good.items() if match.angle_deg < POLICY.turned_deg]
    if EXPECTED in good and (EXPECTED in straight or not straight):
        return EXPECTED
    return (straight or list(good))[0]


def _agreeing(value: dict[str, float], given: RateMatch) -> Finding:
    """Return the finding for a gyro that the attitude explains: scale, lag and turn."""
    text = f"The attitude's rate explains {figure(100 * given.share)} % of the gyro's variance"
    unit, lag, turn = _wrong_unit(given.scale), _lag(given.lag_s), _turn(given.angle_deg)
    faults = [fault for fault in (unit, lag, turn) if fault]
    if not faults:
        return Finding(SECTION, GYRO_FINDING, value, "", text + ": order, sense, units and time agree.")
    level: Level = "warning" if unit or abs(given.lag_s) > POLICY.serious_lag_s else "note"
    return Finding(SECTION, GYRO_FINDING, value, "", f"{text}; {'; '.join(faults)}.", level)


def _wrong_unit(scale: float) -> str:
    """Return the fault of the gyro's scale and the option that corrects it, "" for a scale near 1."""
    for unit, factor in GYRO_UNITS.items():
        if abs(scale / factor - 1) < POLICY.unit_tolerance:
            return f"the gyro is {figure(scale)} times as large, as in {unit} ({_gyro_flag(unit)})"
    doubtful = abs(scale - 1) > POLICY.scale_tolerance
    return f"the gyro is {figure(scale)} times as large: check its unit" if doubtful else ""


def _lag(lag_s: float) -> str:
    return f"the attitude comes {duration(abs(lag_s))} {'late' if lag_s > 0 else 'early'}" if lag_s else ""


def _turn(angle_deg: float) -> str:
    turned = angle_deg > POLICY.turned_deg
    return f"the attitude's frame is turned by {figure(angle_deg)} degrees against the gyro's" if turned else ""


def _gyro_flag(unit: str) -> str:
    return f"--map gyro_x_rad_s=<column>,unit={unit}, y and z alike"


def _gyro_by_field(data: SensorData) -> Finding | None:
    """Return the unit of the gyro from the turning of the field, for a log without attitude."""
    series = data.series
    if series.gyro_rad_s is None:
        return None
    scale, share = gyro_scale_from_field(series.time_s, series.mag_nT, series.gyro_rad_s)
    if not share > POLICY.least_explained:
        text = "The field does not follow the gyro: wrong axes, a wrong time, or too little motion."
        return Finding(SECTION, "gyro_and_field", share, "", text, "note")
    for unit, factor in GYRO_UNITS.items():
        if abs(scale * factor - 1) < POLICY.scale_by_field:
            text = f"The field turns {figure(scale)} times as fast as the gyro measures: probably {unit} "
            return Finding(SECTION, "gyro_and_field", share, "", f"{text}({_gyro_flag(unit)}).", "warning")
    if abs(scale - 1) >= POLICY.scale_by_field:
        text = f"The field turns {figure(scale)} times as fast as the gyro measures: check its unit and axes."
        return Finding(SECTION, "gyro_and_field", share, "", text, "warning")
    return Finding(SECTION, "gyro_and_field", share, "", "The field turns as the gyro measures: units and axes agree.")


def _gravity(data: SensorData, q: Array) -> Finding | None:
    """Return the direction of the specific force in the world, from samples with little acceleration."""
    body = data.series.accel_m_s2
    if body is None:
        return None
    size = np.linalg.norm(body, axis=1)
    calm = np.abs(size - np.nanmedian(size)) < POLICY.calm_share * np.nanmedian(size)
    finding, mean = _kept(q, np.where(calm[:, None], body, np.nan), "gravity")
    if finding is not None:
        return finding
    tilt_deg = float(np.degrees(np.arccos(np.clip(mean[2] / np.linalg.norm(mean), -1, 1))))
    if tilt_deg < POLICY.upright_deg:
        within = f", to within {figure(tilt_deg, 2)} degrees" if tilt_deg >= LEAST_TOLD_DEG else ""
        text = f"In the world frame the specific force points up{within}."
        return Finding(SECTION, "gravity", tilt_deg, "deg", text)
    upside_down_deg = 180 - tilt_deg
    if upside_down_deg < POLICY.upright_deg:
        text = "In the world frame the specific force points down: its sign is wrong, or the world's z axis points "
        return Finding(SECTION, "gravity", tilt_deg, "deg", f"{text}down; east, north, up is expected.", "warning")
    text = f"In the world frame the specific force is {figure(tilt_deg)} degrees from up: the frames are turned."
    return Finding(SECTION, "gravity", tilt_deg, "deg", text, "warning")


def _field(data: SensorData, q: Array) -> Finding | None:
    body = data.series.mag_nT if data.corrected_nT is None else data.corrected_nT
    finding, mean = _kept(q, body, "field")
    if finding is not None:
        return finding
    east, north, up = mean
    down_deg = float(np.degrees(np.arctan2(-up, np.hypot(east, north))))
    from_north_deg = float(np.degrees(np.arctan2(east, north)))
    vertical = f"{figure(abs(down_deg))} degrees {'below' if down_deg >= 0 else 'above'} the horizon"
    side = f"{figure(abs(from_north_deg))} degrees {'east' if from_north_deg >= 0 else 'west'} of north"
    text = f"In the attitude's world frame the field points {vertical} and {side}"
    value = {"down_deg": down_deg, "east_of_north_deg": from_north_deg}
    if abs(from_north_deg) > POLICY.off_north_deg and abs(down_deg) < POLICY.steep_deg:
        text += ": the heading is not counted from north, or the sensor is turned against the attitude's frame"
        return Finding(SECTION, "field_direction", value, "deg", text + ".", "note")
    return Finding(SECTION, "field_direction", value, "deg", text + ".")


def _kept(q: Array, body: Array, what: str) -> tuple[Finding | None, Array]:
    """Return the mean direction in the world, and a finding if the direction is not constant."""
    means = {name: mean_direction(read_as(q, name), body) for name in CONVENTIONS}
    steady = {name: float(np.linalg.norm(mean)) for name, mean in means.items()}
    best = max(steady, key=lambda name: steady[name])
    if steady[EXPECTED] >= POLICY.lost_length:
        return None, means[EXPECTED]
    name = "gravity" if what == "gravity" else "field_direction"
    if steady[best] > POLICY.kept_length:
        text = f"The {what} has a constant direction in the world only with the quaternion read as ({best})."
        return Finding(SECTION, name, steady, "", text, "warning"), means[EXPECTED]
    text = f"In the world frame the {what} has no constant direction"
    text += ": accelerations, or frames that disagree." if what == "gravity" else ": hard iron, or turned frames."
    return Finding(SECTION, name, steady, "", text, "note"), means[EXPECTED]
