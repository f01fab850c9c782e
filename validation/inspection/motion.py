"""How the vehicle moved, and how much of the sphere it showed the sensor."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from calib.observability import Extent, axis_text, planar_status
from scenarios.arrays import Array
from validation.inspection.finding import Finding, Level
from validation.inspection.sensor_data import Look, attitude_of
from validation.signals.quaternion_conventions import euler_deg
from validation.signals.sphere import cells, directions, largest_hole
from validation.text import figure, figures

SECTION = "motion"
SMALL_HOLE_DEG = 65.0
"""Radius of a hole that a calibration bears."""
AT_REST_SHARE = 0.01
"""A field that varies by less than this share of its strength is that of a sensor at rest."""
ALONG = 0.98
"""Cosine of the angle to an axis, above which a direction is the axis'."""
STEADY_RATE = 0.1
"""Relative deviation from the median rate that is still constant."""
STEADY_SHARE = 0.8
LEAST_RATE_DEG_S = 1.0


def motion_findings(look: Look) -> list[Finding]:
    """Coverage, singular values, ranges of roll, pitch and heading, constant rates."""
    if len(look.series) < 3:
        return []
    q = attitude_of(look.series)
    found = [_coverage(look), _extent(look), _angles(look, q), _steady_turn(look, q)]
    return [finding for finding in found if finding is not None]


def _coverage(look: Look) -> Finding | None:
    """Share of equal-area cells that the field's direction in the body frame has entered, and the largest hole."""
    corrected = look.corrected_nT
    seen = directions(look.series.mag_nT if corrected is None else corrected)
    if not len(seen):
        return None
    grid = cells()
    share = len(np.unique(grid.index(seen))) / grid.total
    hole_deg, middle = largest_hole(seen)
    of = "as measured" if corrected is None else "after an ellipsoid fit"
    text = f"The field's direction in the body frame, {of}, was in {100 * share:.2g} % of the sphere; the largest hole "
    text += f"has a radius of {figure(hole_deg, 2)} degrees, about {_pointing(middle)}"
    level: Level = "ok" if hole_deg <= SMALL_HOLE_DEG else "note"
    value = {"share": share, "hole_deg": hole_deg, "hole_at": middle.tolist()}
    return Finding(SECTION, "coverage", value, "", text + ".", level, look.sensor)


def _pointing(direction: Array) -> str:
    """A unit vector (3,) in words: the half axis that is nearest, and its components where it is not along it."""
    main = int(np.argmax(np.abs(direction)))
    text = f"{'+' if direction[main] > 0 else '-'}{'xyz'[main]}"
    x, y, z = direction
    return text if abs(direction[main]) > ALONG else f"{text} (direction {x:.2f}, {y:.2f}, {z:.2f})"


def _extent(look: Look) -> Finding:
    """Singular values of the centred field over sqrt(n - 1), and whether it lies in a plane."""
    extent = Extent.of(look.series.mag_nT)
    sizes = np.sqrt(np.clip(extent.variance[::-1], 0.0, None))
    text = f"Along its three main directions the field varies by {figures(sizes)} nT rms"
    noise = float(np.nanmax(look.white_nT, initial=0.0))
    if not np.ptp(look.series.mag_nT, axis=0).any():
        return Finding(SECTION, "extent", sizes.tolist(), "nT", "The field does not vary.", "note", look.sensor)
    if sizes[0] < AT_REST_SHARE * look.strength_nT:
        text += ": the sensor was at rest, or nearly so"
        return Finding(SECTION, "extent", sizes.tolist(), "nT", text + ".", "note", look.sensor)
    if planar_status(extent, noise) is not None:
        text += f": it lies in a plane perpendicular to {axis_text(extent.thinnest)}"
        return Finding(SECTION, "extent", sizes.tolist(), "nT", text + ".", "note", look.sensor)
    return Finding(SECTION, "extent", sizes.tolist(), "nT", text + ".", "ok", look.sensor)


def _angles(look: Look, q: Array | None) -> Finding | None:
    """Ranges of roll, pitch and heading; of roll and pitch alone from the accelerometer."""
    if q is not None:
        known = q[np.isfinite(q).all(axis=1)]
        yaw, pitch, roll = euler_deg(known).T
        value = {"roll_deg": _arc(roll), "pitch_deg": float(np.ptp(pitch)), "heading_deg": _arc(yaw)}
        text = f"Roll spans {value['roll_deg']:.3g}, pitch {value['pitch_deg']:.3g} and heading "
        text += f"{value['heading_deg']:.3g} degrees."
        return Finding(SECTION, "angles", value, "deg", text)
    accel = look.series.accel_m_s2
    if accel is None:
        return None
    x, y, z = accel[np.isfinite(accel).all(axis=1)].T
    pitch, roll = np.degrees(np.arctan2(-x, np.hypot(y, z))), np.degrees(np.arctan2(y, z))
    value = {"roll_deg": _arc(roll), "pitch_deg": float(np.ptp(pitch))}
    text = f"By the accelerometer roll spans {value['roll_deg']:.3g} and pitch {value['pitch_deg']:.3g} degrees."
    return Finding(SECTION, "angles", value, "deg", text)


def _arc(angle_deg: Array) -> float:
    """Degrees of the circle less the widest arc without an angle."""
    turned = np.sort(angle_deg % 360.0)
    return 360.0 - float(np.max(np.diff(np.r_[turned, turned[0] + 360.0])))


def _steady_turn(look: Look, q: Array | None) -> Finding | None:
    """Whether most of the time passes in a turn at one constant rate."""
    rate = _body_rate(look, q)
    if rate is None or not len(rate):
        return None
    usual = np.median(rate, axis=0)
    size = float(np.linalg.norm(usual))
    steady = float(np.mean(np.linalg.norm(rate - usual, axis=1) < STEADY_RATE * size)) if size else 0.0
    rms_deg_s = float(np.degrees(np.sqrt(np.mean(np.sum(rate**2, axis=1)))))
    value = {"rate_deg_s": rms_deg_s, "steady_share": steady}
    if steady > STEADY_SHARE and np.degrees(size) > LEAST_RATE_DEG_S:
        turn = f"{np.degrees(size):.3g} deg/s about {axis_text(usual)}"
        text = f"{100 * steady:.2g} % of the time it turns at {turn}: at a constant rate eddy "
        text += "currents look like soft iron; vary the rate to tell them apart."
        return Finding(SECTION, "rate", value, "deg/s", text, "note", look.sensor)
    text = f"It turns at {figure(rms_deg_s)} deg/s rms, at no constant rate."
    return Finding(SECTION, "rate", value, "deg/s", text, "ok", look.sensor)


def _body_rate(look: Look, q: Array | None) -> Array | None:
    """Body rate (m, 3), rad/s, of the gyro or else of the attitude."""
    series = look.series
    if series.gyro_rad_s is not None:
        return np.asarray(series.gyro_rad_s[np.isfinite(series.gyro_rad_s).all(axis=1)])
    if q is None:
        return None
    sound = np.isfinite(q).all(axis=1)
    attitude = Rotation.from_quat(q[sound], scalar_first=True)
    step = np.diff(series.time_s[sound])
    return np.asarray((attitude[:-1].inv() * attitude[1:]).as_rotvec() / step[:, None])
