"""Motion of the vehicle, and the part of the sphere that the sensor has seen."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from calib.observability import Extent, axis_text, main_axis, planar_status
from scenarios.arrays import Array
from validation.inspection.finding import Finding, Level
from validation.inspection.sensor_data import SensorData
from validation.policy import POLICY
from validation.signals.quaternion_conventions import euler_deg
from validation.signals.sphere import cells, directions, largest_hole
from validation.text import figure, figures

SECTION = "motion"


def motion_findings(data: SensorData) -> list[Finding]:
    """Return findings on coverage, extent of the field, ranges of the angles, and constant rates."""
    if len(data.series) < 3:
        return []
    q = data.attitude
    found = [_coverage(data), _extent(data), _angles(data, q), _steady_turn(data, q)]
    return [finding for finding in found if finding is not None]


def _coverage(data: SensorData) -> Finding | None:
    """Return the share of equal-area cells with a measured field direction (body frame), and the largest hole."""
    corrected = data.corrected_nT
    seen = directions(data.series.mag_nT if corrected is None else corrected)
    if not len(seen):
        return None
    grid = cells()
    share = len(np.unique(grid.index(seen))) / grid.total
    hole_deg, middle = largest_hole(seen)
    of = "as measured" if corrected is None else "after an ellipsoid fit"
    text = f"The field directions in the body frame, {of}, cover {figure(100 * share, 2)} % of the sphere; "
    text += f"the largest hole has a radius of {figure(hole_deg, 2)} degrees, about {_pointing(middle)}"
    level: Level = "ok" if hole_deg <= POLICY.small_hole_deg else "note"
    value = {"share": share, "hole_deg": hole_deg, "hole_at": middle.tolist()}
    return Finding(SECTION, "coverage", value, "", text + ".", level, data.sensor)


def _pointing(direction: Array) -> str:
    """Return a unit vector (3,) in words: the nearest half axis, with components unless along that axis."""
    main = main_axis(direction)
    text = f"{'+' if direction[main] > 0 else '-'}{'xyz'[main]}"
    x, y, z = direction
    return text if abs(direction[main]) > POLICY.along_axis else f"{text} (direction {x:.2f}, {y:.2f}, {z:.2f})"


def _extent(data: SensorData) -> Finding:
    """Return singular values of the centred field over sqrt(n - 1), and whether the field lies in a plane."""
    extent = Extent.of(data.series.mag_nT)
    sizes = np.sqrt(np.clip(extent.variance[::-1], 0.0, None))
    text = f"Along its three main directions the field varies by {figures(sizes)} nT rms"
    noise = float(np.nanmax(data.white_nT, initial=0.0))
    if not np.ptp(data.series.mag_nT, axis=0).any():
        return Finding(SECTION, "extent", sizes.tolist(), "nT", "The field does not vary.", "note", data.sensor)
    if sizes[0] < POLICY.at_rest * data.strength_nT:
        text += ": the sensor was at rest, or nearly at rest"
        return Finding(SECTION, "extent", sizes.tolist(), "nT", text + ".", "note", data.sensor)
    if planar_status(extent, noise) is not None:
        text += f": the field lies in a plane perpendicular to {axis_text(extent.thinnest)}"
        return Finding(SECTION, "extent", sizes.tolist(), "nT", text + ".", "note", data.sensor)
    return Finding(SECTION, "extent", sizes.tolist(), "nT", text + ".", "ok", data.sensor)


def _angles(data: SensorData, q: Array | None) -> Finding | None:
    """Return ranges of roll, pitch and heading; from the accelerometer only of roll and pitch."""
    if q is not None:
        known = q[np.isfinite(q).all(axis=1)]
        yaw, pitch, roll = euler_deg(known).T
        value = {"roll_deg": _arc(roll), "pitch_deg": float(np.ptp(pitch)), "heading_deg": _arc(yaw)}
        text = f"Roll spans {figure(value['roll_deg'])}, pitch {figure(value['pitch_deg'])} and heading "
        text += f"{figure(value['heading_deg'])} degrees."
        return Finding(SECTION, "angles", value, "deg", text)
    accel = data.series.accel_m_s2
    if accel is None:
        return None
    x, y, z = accel[np.isfinite(accel).all(axis=1)].T
    pitch, roll = np.degrees(np.arctan2(-x, np.hypot(y, z))), np.degrees(np.arctan2(y, z))
    value = {"roll_deg": _arc(roll), "pitch_deg": float(np.ptp(pitch))}
    text = (
        f"By the accelerometer, roll spans {figure(value['roll_deg'])} and pitch {figure(value['pitch_deg'])} degrees."
    )
    return Finding(SECTION, "angles", value, "deg", text)


def _arc(angle_deg: Array) -> float:
    """Return the shortest arc in degrees that contains all angles."""
    turned = np.sort(angle_deg % 360.0)
    return 360.0 - float(np.max(np.diff(np.r_[turned, turned[0] + 360.0])))


def _steady_turn(data: SensorData, q: Array | None) -> Finding | None:
    """Return the rms rate, and whether the sensor turns at a constant rate most of the time."""
    rate = _body_rate(data, q)
    if rate is None or not len(rate):
        return None
    usual = np.median(rate, axis=0)
    size = float(np.linalg.norm(usual))
    steady = float(np.mean(np.linalg.norm(rate - usual, axis=1) < POLICY.steady_rate * size)) if size else 0.0
    rms_deg_s = float(np.degrees(np.sqrt(np.mean(np.sum(rate**2, axis=1)))))
    value = {"rate_deg_s": rms_deg_s, "steady_share": steady}
    if steady > POLICY.steady_share and np.degrees(size) > POLICY.least_steady_deg_s:
        turn = f"{figure(np.degrees(size))} deg/s about {axis_text(usual)}"
        text = f"{figure(100 * steady, 2)} % of the time the sensor turns at {turn}: at a constant rate eddy "
        text += "currents cannot be distinguished from soft iron; vary the rate."
        return Finding(SECTION, "rate", value, "deg/s", text, "note", data.sensor)
    text = f"The sensor turns at {figure(rms_deg_s)} deg/s rms, not at a constant rate."
    return Finding(SECTION, "rate", value, "deg/s", text, "ok", data.sensor)


def _body_rate(data: SensorData, q: Array | None) -> Array | None:
    """Return the body rate (m, 3) in rad/s, of the gyro, or of the attitude without a gyro."""
    series = data.series
    if series.gyro_rad_s is not None:
        return np.asarray(series.gyro_rad_s[np.isfinite(series.gyro_rad_s).all(axis=1)])
    if q is None:
        return None
    sound = np.isfinite(q).all(axis=1)
    attitude = Rotation.from_quat(q[sound], scalar_first=True)
    step = np.diff(series.time_s[sound])
    return np.asarray((attitude[:-1].inv() * attitude[1:]).as_rotvec() / step[:, None])
