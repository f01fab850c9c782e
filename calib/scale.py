"""Scale of the measurements: counts and other units brought to the size of the field, and the result brought back.

m = S h + b + B dh/dt  in units of u:  k m = (k S) h + k b + k B dh/dt,  k m and h of equal size
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from calib.input_terms import GAIN
from calib.numerics.points import mean_and_spread
from calib.numerics.rates import world_to_body
from calib.reference import Reference
from calib.result import STRENGTH_NAME, Calibration
from recordings import Recording
from scenarios.arrays import Array

NANOTESLA = (0.5, 2.0)
"""Sizes of the measurements, in parts of the field's, at which they are in the field's unit: soft iron and gains in nT
stay inside, and the measurements are used unchanged."""
MOST_POINTS = 5_000
"""Samples, evenly spaced, that the radius is taken from."""
THINNEST = 1e-6
"""Thickness of the measurements, in parts of their extent, below which the radius is that of their circle."""
ROUNDING = 1e-9
"""Deviation of a field that does not change, in parts of its strength."""
POWERS = {
    "offset": 1,
    "S_": 1,
    "B_": 1,
    "scale": 1,
    "R_": -1,
    STRENGTH_NAME: 1,
    "noise_std_nT": 1,
    "noise_variance_nT2": 2,
    "flicker_nT": 1,
    "held_out": 1,
}
"""Power of the measurements' unit in a parameter, by the beginning of its name; parameters not listed have none."""


def field_factor(recording: Recording, reference: Reference, *, vector: bool, one_axis: bool) -> float:
    """Factor k that brings the measurements to the size of the field; 1 for measurements of that size (NANOTESLA).

    Size: the rms deviation of the field where its vector is known, the rms length of a turn about one axis, which has
    no offset, and else the radius of the sphere through the measurements, or their rms length where that is the
    field's: of a motion that is hardly a turn the radius is arbitrary.
    """
    if vector:
        assert recording.att_q is not None
        field_nT = world_to_body(recording.att_q, np.array(reference.field_enu_nT))
        size = _deviation(recording.mag_nT) / max(_deviation(field_nT), ROUNDING * reference.strength_nT)
    else:
        points = recording.mag_nT[:: max(1, len(recording) // MOST_POINTS)]
        if _of_field(float(np.sqrt(np.vdot(points, points) / len(points))) / reference.strength_nT):
            return 1.0
        size = float(np.sqrt(np.mean(np.sum(points**2, axis=1)))) / reference.strength_nT
        if not one_axis and not _of_field(size):
            size = sphere_radius(points) / reference.strength_nT
    return 1.0 if _of_field(size) else 1.0 / size


def _of_field(size: float) -> bool:
    return NANOTESLA[0] <= size <= NANOTESLA[1]


def _deviation(points: Array) -> float:
    """Rms distance of points (n, 3) from their mean."""
    return float(np.sqrt(mean_and_spread(np.ascontiguousarray(points))[1].trace()))


def sphere_radius(points: Array) -> float:
    """Radius of the sphere through points (n, 3), by linear least squares; of a circle where they lie in a plane."""
    x = points - points.mean(axis=0)
    scale = float(np.sqrt(np.mean(np.sum(x * x, axis=1))))
    x = x / scale
    square = np.sum(x * x, axis=1)
    centre = np.linalg.lstsq(2.0 * x, square - 1.0, rcond=THINNEST)[0]
    return scale * float(np.sqrt(1.0 + centre @ centre))


def magnified(recording: Recording, factor: float) -> Recording:
    """The recording with the measurements of all magnetometers times a factor; the same object for a factor of 1."""
    if factor == 1.0:
        return recording
    array_nT = None if recording.array_mag_nT is None else recording.array_mag_nT * factor
    return replace(recording, mag_nT=recording.mag_nT * factor, array_mag_nT=array_nT)


def in_unit_of(fit: Calibration, factor: float) -> Calibration:
    """The calibration of the measurements themselves, from the fit to the measurements times a factor.

    A fit that finds the field's strength keeps its matrix, of determinant 1, and has the strength in their unit.
    """
    if factor == 1.0 or not fit.has_estimate:
        return fit
    own = STRENGTH_NAME in fit.parameters
    gain = 1.0 if own else factor
    names = fit.covariance_names
    unit = np.array([_unit(name, factor, own=own) for name in names])
    return replace(
        fit,
        offset_nT=fit.offset_nT / factor,
        matrix=fit.matrix * gain,
        eddy_s=_times(fit.eddy_s, 1.0 / gain),
        parameters={name: value * _unit(name, factor, own=own) for name, value in fit.parameters.items()},
        covariance=_times(fit.covariance, np.outer(unit, unit)),
        array_offset_nT=_times(fit.array_offset_nT, 1.0 / factor),
        array_matrix=_times(fit.array_matrix, gain),
        segments=tuple(
            replace(part, offset_nT=part.offset_nT / factor, matrix=part.matrix * gain) for part in fit.segments
        ),
        inputs=tuple(replace(term, gain_nT=term.gain_nT / factor) for term in fit.inputs),
    )


def _times(values: Array | None, factor: float | Array) -> Array | None:
    return None if values is None else np.asarray(values * factor)


def _unit(name: str, factor: float, *, own: bool) -> float:
    """What a parameter is multiplied by where the measurements are divided by a factor."""
    if own and name.startswith(("S_", "R_")):
        return 1.0
    power = next((power for start, power in POWERS.items() if name.startswith(start)), int(bool(GAIN.search(name))))
    return float(factor**-power)
