"""What an "ok" must be borne out by: what the fit leaves, its own covariance, and the condition of its matrix."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from calib.models.response import Response, of_strength, of_vector, strength_rows
from calib.numerics.colour import inflation
from calib.numerics.flicker import flicker_covariance, flicker_power
from calib.numerics.points import lengths
from calib.numerics.rates import world_to_body
from calib.observability import Extent, covariance_status, planar_status, unobservable
from calib.reference import Reference
from calib.result import STRENGTH_NAME, Calibration, Status
from recordings import Recording
from scenarios.arrays import Array

MAX_MISFIT_FRACTION = 0.1
"""A fit that leaves half of the samples further off than this fraction of the field does not follow the field: a
constant field with noise, a wrong attitude or unit. Soft iron of 10 % left out altogether stays below it."""
MAX_CONDITION = 50.0
"""A matrix worse conditioned than this has an axis that measures nothing, or two that measure the same; the strongest
soft iron known from vehicles stretches by 2."""
Extents = tuple[Extent, ...]
"""How far the measurements extend, of each sensor; none where a method knows or asks no more than a plane."""
NEGATIVE = -1e-3
"""A covariance whose correlations have an eigenvalue below this is none; rounding stays above."""


def own_reference(fit: Calibration, reference: Reference) -> Reference:
    """What the fit is judged by: the strength that it found itself, where it did not take the reference's."""
    found_nT = fit.parameters.get(STRENGTH_NAME)
    return reference if found_nT is None else Reference(found_nT)


def residual_of(fit: Calibration, recording: Recording, reference: Reference, *, vector: bool) -> Array:
    """What the fit leaves, in order of time: |h| - F (n,), or with known attitude h - R_wb^T F (n, 3), nT."""
    field_nT = fit.apply(recording)
    if vector:
        assert recording.att_q is not None
        assert reference.field_enu_nT is not None
        residual = field_nT - world_to_body(recording.att_q, np.array(reference.field_enu_nT))
    else:
        residual = lengths(field_nT) - reference.strength_nT
    return in_time(recording, np.asarray(residual))


def in_time(recording: Recording, values: Array) -> Array:
    """Values (n, ...) of the recording's samples in order of time."""
    late = recording.time_s[1:] < recording.time_s[:-1]
    return values[np.argsort(recording.time_s, kind="stable")] if late.any() else values


def extents(recording: Recording) -> Extents:
    """How far the magnetometer's measurements extend, or those of each sensor of an array."""
    sensors = [recording.mag_nT] if recording.array_mag_nT is None else recording.array_mag_nT
    return tuple(Extent.of(sensor) for sensor in sensors)


def planar(sensors: Extents, noise_std_nT: float = 0.0) -> Status | None:
    """`planar_status` of the first sensor that it holds for."""
    return next((flat for sensor in sensors if (flat := planar_status(sensor, noise_std_nT)) is not None), None)


def flat_status(fit: Calibration, sensors: Extents, residual_nT: Array) -> Status | None:
    """Unobservable when a sensor's measurements leave a plane by no more than the noise that the fit tells, or leaves.

    A fit that failed and tells no noise is not asked.
    """
    noise_nT = fit.parameters.get("noise_std_nT")
    if noise_nT is None and fit.status.kind != "ok":
        return None
    if noise_nT is None:
        gain = float(np.linalg.norm(fit.matrix)) / np.sqrt(3.0)
        noise_nT = float(np.sqrt(np.mean(residual_nT**2))) / gain
    return planar(sensors, noise_nT)


def widened(
    fit: Calibration,
    residual_nT: Array,
    recording: Recording,
    reference: Reference,
    *,
    vector: bool,
    response: Response | None = None,
) -> Calibration:
    """The fit with its claimed covariance made true to residuals that are not white, see `calib.numerics.colour`.

    What flicker noise does to it is added, by how each sample moves the fit, see `calib.numerics.flicker`; not where
    the fit has not converged, whose own error is taken for noise.
    """
    if fit.covariance is None or fit.offset_covariance_nT2 is None:
        return fit
    field_nT = in_time(recording, fit.apply(recording))
    factor = inflation(residual_nT)
    flicker_nT2 = flicker_power(*strength_rows(fit, field_nT, reference.strength_nT))
    covariance = factor * fit.covariance
    if flicker_nT2 > 0 and fit.status.kind != "not_converged":
        moved = response or _response(fit, field_nT, recording, reference, vector=vector)
        _add(covariance, fit.covariance_names, moved, flicker_nT2 * flicker_covariance(moved.K, _rate_hz(recording)))
    told = {"covariance_inflation": factor, "flicker_nT_sqrt_hz": float(np.sqrt(flicker_nT2))}
    return replace(fit, covariance=covariance, parameters=fit.parameters | told)


def _response(
    fit: Calibration, field_nT: Array, recording: Recording, reference: Reference, *, vector: bool
) -> Response:
    """How the samples, in order of time, move the fit."""
    if not vector:
        return of_strength(fit, field_nT, reference.strength_nT)
    assert recording.att_q is not None
    assert reference.field_enu_nT is not None
    return of_vector(in_time(recording, world_to_body(recording.att_q, np.array(reference.field_enu_nT))))


def _rate_hz(recording: Recording) -> float:
    return (len(recording) - 1) / float(np.ptp(recording.time_s))


def _add(covariance: Array, names: tuple[str, ...], response: Response, more: Array) -> None:
    """Add to the rows and columns of the parameters that both name."""
    both = [name for name in response.names if name in names]
    rows, those = [names.index(name) for name in both], [response.names.index(name) for name in both]
    covariance[np.ix_(rows, rows)] += more[np.ix_(those, those)]


def unsupported(fit: Calibration, residual_nT: Array, reference: Reference) -> Status | None:
    """Why the fit cannot be believed; None where covariance, matrix and residual bear it out."""
    return (
        _indefinite(fit)
        or _singular(fit)
        or covariance_status(fit, reference.strength_nT)
        or _misfit(residual_nT, reference.strength_nT)
    )


def _indefinite(fit: Calibration) -> Status | None:
    """Not converged when the covariance is none."""
    if fit.covariance is None:
        return None
    variance = np.diag(fit.covariance)
    std = np.sqrt(np.where(variance > 0, variance, 1.0))
    if variance.min() >= 0 and np.linalg.eigvalsh(fit.covariance / np.outer(std, std))[0] >= NEGATIVE:
        return None
    return Status("not_converged", "the claimed covariance is not positive definite: record longer, about more axes")


def _singular(fit: Calibration) -> Status | None:
    """Unobservable when a matrix stretches or squeezes one body direction alone: noise is field, or field noise."""
    matrices = [
        fit.matrix,
        *(part.matrix for part in fit.segments),
        *([] if fit.array_matrix is None else fit.array_matrix),
    ]
    worst = max(matrices, key=np.linalg.cond)
    condition = float(np.linalg.cond(worst))
    if condition <= MAX_CONDITION:
        return None
    _, stretch, axes = np.linalg.svd(worst)
    alone = 0 if stretch[0] * stretch[2] > stretch[1] ** 2 else 2
    return unobservable(
        axes[alone],
        f"the matrix is nearly singular (condition number {condition:.2g}, limit {MAX_CONDITION:g}), by what it does "
        "along it: the motion hardly turns it, or an axis is not wired, or two measure the same",
    )


def _misfit(residual_nT: Array, strength_nT: float) -> Status | None:
    """Not converged when what is left is no small part of the field."""
    limit_nT = MAX_MISFIT_FRACTION * strength_nT
    flat = residual_nT.ravel()
    if flat @ flat <= len(residual_nT) * limit_nT**2 / 2:  # half of the samples can then be no further off
        return None
    length = np.abs(residual_nT) if residual_nT.ndim == 1 else np.linalg.norm(residual_nT, axis=1)
    typical = float(np.median(length))
    if typical <= limit_nT:
        return None
    return Status(
        "not_converged",
        f"the corrected field is still off by {typical:.3g} nT, {100 * typical / strength_nT:.2g} % of the field "
        f"(limit {100 * MAX_MISFIT_FRACTION:g} %): the measurements do not follow it; "
        "check field, unit, axes and attitude",
    )
