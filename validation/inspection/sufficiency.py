"""Which calibrations a recording is enough for: the least of each kind, tried, and its own verdict."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib import Reference, Status, get
from calib.methods.vector_least_squares import VectorLeastSquares
from calib.observability import Extent, planar_status
from recordings import Recording
from scenarios.arrays import Array
from validation.inspection.finding import Finding
from validation.inspection.sensor_data import Look, attitude_of
from validation.signals.quaternion_conventions import mean_direction
from validation.text import figure

SECTION = "calibration"
FIELD_CHANGE_RATIO = 20.0
"""Noise levels that the rest of an attitude fit may have before the field itself is said to change."""


@dataclass(frozen=True)
class CalibrationKind:
    """A kind of calibration: the calibrator that stands for it, and what it gives."""

    key: str
    what: str


SPHERE = CalibrationKind("sphere", "An offset alone, from the strength (sphere)")
ELLIPSOID = CalibrationKind("ellipsoid", "Offset and symmetric matrix, from the strength (ellipsoid)")
VECTOR = CalibrationKind(
    "vector_least_squares", "Offset and full matrix, from attitude and field vector (vector_least_squares)"
)
EDDY = CalibrationKind("eddy", "Eddy currents as well, from attitude and field vector")


def calibration_findings(look: Look) -> list[Finding]:
    """How far the strength spreads, which kinds of calibration the recording is enough for, and a finding for each."""
    if len(look.series) < 3:
        return []
    statuses = _tried(look)
    found, said = [_spread(look), _enough(look, statuses)], ""
    for kind, status in statuses.items():
        value, name = {"status": status.kind, "reason": status.reason}, f"enough_for_{kind.key}"
        if status.kind == "ok":
            found.append(Finding(SECTION, name, value, "", f"{kind.what}: enough.", "ok", look.sensor))
        else:
            reason = _reason(look, status)
            text = f"{kind.what}: not enough, {'for the same reason' if reason == said else reason}."
            found.append(Finding(SECTION, name, value, "", text, "note", look.sensor))
            said = reason
    return found


def _enough(look: Look, statuses: dict[CalibrationKind, Status]) -> Finding:
    """The kinds that suffice; a warning where none does."""
    kinds = [kind.key for kind, status in statuses.items() if status.kind == "ok"]
    if kinds:
        text = f"The recording is enough for {', '.join(kinds)}."
        return Finding(SECTION, "enough_for", kinds, "", text, "ok", look.sensor)
    reason = _reason(look, next(iter(statuses.values())))
    text = f"The recording is not enough for any calibration: {reason}."
    return Finding(SECTION, "enough_for", kinds, "", text, "warning", look.sensor)


def _spread(look: Look) -> Finding:
    """Relative standard deviation of the strength, as measured and after the ellipsoid fit, in percent."""
    raw = _percent(look.series.mag_nT)
    corrected = look.corrected_nT
    value = {"raw_percent": raw, "ellipsoid_percent": None if corrected is None else _percent(corrected)}
    text = f"The strength as measured varies by {figure(raw)} % rms"
    if corrected is not None:
        text += f", after an ellipsoid fit to these data by {figure(_percent(corrected))} %"
    return Finding(SECTION, "strength_spread", value, "%", text + ".", "ok", look.sensor)


def _percent(field_nT: Array) -> float:
    strength = np.linalg.norm(field_nT, axis=1)
    return float(100 * strength.std() / strength.mean()) if strength.mean() > 0 else float("nan")


def _reason(look: Look, status: Status) -> str:
    """The calibrator's reason; where it blames a motion that is wide enough, the field's own change is the cause."""
    noise = float(np.nanmax(look.white_nT, initial=0.0))
    residual = look.residual
    wide = status.kind == "unobservable" and planar_status(Extent.of(look.series.mag_nT), noise) is None and noise > 0
    if wide and residual is not None and residual.base == "attitude":
        rms = float(np.sqrt(np.mean(residual.values**2)))
        if rms > FIELD_CHANGE_RATIO * noise:
            times = figure(rms / noise, 2)
            return f"no attitude explains {figure(rms)} nT rms, {times} times the noise: the field itself changes"
    return status.reason


def _tried(look: Look) -> dict[CalibrationKind, Status]:
    series = look.series
    strength = look.strength_nT if look.strength_nT > 0 else 1.0
    plain = Recording(series.time_s, series.mag_nT)
    statuses = {SPHERE: get("sphere").fit(plain, Reference(strength)).status, ELLIPSOID: look.ellipsoid.status}
    q = attitude_of(series)
    vector = None if q is None else _field_vector(look, q, strength)
    if q is not None and vector is not None:
        known = np.isfinite(q).all(axis=1)
        recording = Recording(series.time_s[known], series.mag_nT[known], att_q=q[known])
        statuses[VECTOR] = VectorLeastSquares().fit(recording, Reference.of_vector(vector)).status
        statuses[EDDY] = VectorLeastSquares(eddy=True).fit(recording, Reference.of_vector(vector)).status
    return statuses


def _field_vector(look: Look, q: Array, strength: float) -> tuple[float, float, float] | None:
    """About the field vector in the attitude's world, from the data; None where it does not keep a direction."""
    corrected = look.corrected_nT
    mean = mean_direction(q, look.series.mag_nT if corrected is None else corrected)
    size = float(np.linalg.norm(mean))
    if size < 0.5:
        return None
    east, north, up = (float(v) for v in strength * mean / size)
    return east, north, up
