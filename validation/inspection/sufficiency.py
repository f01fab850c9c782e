"""Calibrations that a recording suffices for: the simplest calibrator of each kind is tried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib import Reference, Status, get
from calib.methods.vector_least_squares import VectorLeastSquares
from calib.observability import Extent, planar_status
from recordings import Recording
from scenarios.arrays import Array
from validation.inspection.finding import Finding
from validation.inspection.sensor_data import SensorData
from validation.policy import POLICY
from validation.signals.quaternion_conventions import mean_direction
from validation.text import figure, listed

SECTION = "calibration"


@dataclass(frozen=True)
class CalibrationKind:
    """Kind of calibration: name of the calibrator, and its result in words."""

    key: str
    what: str


SPHERE = CalibrationKind("sphere", "An offset alone, from the strength (sphere)")
ELLIPSOID = CalibrationKind("ellipsoid", "Offset and symmetric matrix, from the strength (ellipsoid)")
PLANAR = CalibrationKind("planar", "Centre and ellipse in x and y, from a level turn (planar)")
VECTOR = CalibrationKind(
    "vector_least_squares", "Offset and full matrix, from attitude and field vector (vector_least_squares)"
)
EDDY = CalibrationKind("eddy", "Eddy currents as well, from attitude and field vector")


def calibration_findings(data: SensorData) -> list[Finding]:
    """Return findings on the spread of the strength and on each kind of calibration."""
    if len(data.series) < 3:
        return []
    statuses = _tried(data)
    found, said = [_spread(data), *_own_change(data, statuses), _enough(data, statuses)], ""
    for kind, status in statuses.items():
        value, name = {"status": status.kind, "reason": status.reason}, f"enough_for_{kind.key}"
        if status.kind == "ok":
            found.append(Finding(SECTION, name, value, "", f"{kind.what}: data suffice.", "ok", data.sensor))
        else:
            reason = status.reason
            text = f"{kind.what}: data do not suffice, {'for the same reason' if reason == said else reason}."
            found.append(Finding(SECTION, name, value, "", text, "note", data.sensor))
            said = reason
    return found


def _enough(data: SensorData, statuses: dict[CalibrationKind, Status]) -> Finding:
    """Return the kinds of calibration that the recording suffices for; a warning if none."""
    kinds = [kind.key for kind, status in statuses.items() if status.kind == "ok"]
    if kinds:
        text = f"The recording suffices for {listed(kinds)}."
        return Finding(SECTION, "enough_for", kinds, "", text, "ok", data.sensor)
    reason = next(iter(statuses.values())).reason
    text = f"The recording suffices for no calibration: {reason}."
    return Finding(SECTION, "enough_for", kinds, "", text, "warning", data.sensor)


def _spread(data: SensorData) -> Finding:
    """Return the relative standard deviation of the strength in percent, as measured and after the ellipsoid fit."""
    raw = _percent(data.series.mag_nT)
    corrected = data.corrected_nT
    left = None if corrected is None else _percent(corrected)
    value = {"raw_percent": raw, "ellipsoid_percent": left}
    text = f"The strength as measured varies by {figure(raw)} % rms"
    if left is not None:
        text += f", after an ellipsoid fit to these data by {figure(left)} %"
    return Finding(SECTION, "strength_spread", value, "%", text + ".", "ok", data.sensor)


def _percent(field_nT: Array) -> float:
    strength = np.linalg.norm(field_nT, axis=1)
    return float(100 * strength.std() / strength.mean()) if strength.mean() > 0 else float("nan")


def _own_change(data: SensorData, statuses: dict[CalibrationKind, Status]) -> list[Finding]:
    """Return a note where a field that changes, and not the motion, is why a calibration is unobservable."""
    noise, residual = float(np.nanmax(data.white_nT, initial=0.0)), data.residual
    unobservable = any(status.kind == "unobservable" for status in statuses.values())
    if not (unobservable and noise > 0 and residual is not None and residual.base == "attitude"):
        return []
    rms = float(np.sqrt(np.mean(residual.values**2)))
    if rms <= POLICY.field_change * noise or planar_status(Extent.of(data.series.mag_nT), noise) is not None:
        return []
    text = f"{figure(rms)} nT rms, {figure(rms / noise, 2)} times the noise, are not of the attitude: the field itself "
    return [Finding(SECTION, "field_change", rms, "nT", f"{text}changes.", "note", data.sensor)]


def _tried(data: SensorData) -> dict[CalibrationKind, Status]:
    series = data.series
    strength = data.strength_nT if data.strength_nT > 0 else 1.0
    statuses = {SPHERE: _status(data, SPHERE), ELLIPSOID: data.ellipsoid.status}
    planar = _status(data, PLANAR)
    if data.judged.recording.origin.axes == "xy":
        return {PLANAR: planar}
    statuses |= {} if planar.kind == "not_applicable" else {PLANAR: planar}
    q = data.attitude
    vector = None if q is None else _field_vector(data, q, strength)
    if q is not None and vector is not None:
        known = np.isfinite(q).all(axis=1)
        recording = Recording(series.time_s[known], series.mag_nT[known], att_q=q[known])
        statuses[VECTOR] = VectorLeastSquares().fit(recording, Reference.of_vector(vector)).status
        statuses[EDDY] = VectorLeastSquares(eddy=True).fit(recording, Reference.of_vector(vector)).status
    return statuses


def _status(data: SensorData, kind: CalibrationKind) -> Status:
    """Return the status that `magbench calibrate` gives."""
    return data.judged.judged(get(kind.key).fit(data.judged.recording, data.reference)).status


def _field_vector(data: SensorData, q: Array, strength: float) -> tuple[float, float, float] | None:
    """Estimate the field vector in the attitude's world frame; None if the direction is not constant."""
    corrected = data.corrected_nT
    mean = mean_direction(q, data.series.mag_nT if corrected is None else corrected)
    size = float(np.linalg.norm(mean))
    if size < POLICY.least_direction:
        return None
    east, north, up = (float(v) for v in strength * mean / size)
    return east, north, up
