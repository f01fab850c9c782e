"""Acceptance of a fit: status "ok" needs a consistent residual, covariance and condition of the matrix."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib.models.response import Response, of_strength, of_vector, strength_rows
from calib.numerics.colour import few_factor, inflation
from calib.numerics.flicker import flicker_covariance, flicker_power
from calib.numerics.points import lengths, strengths
from calib.numerics.rates import world_to_body
from calib.observability import Extent, covariance_status, planar_status, unobservable
from calib.reference import Reference
from calib.result import OFFSET_NAMES, STRENGTH_NAME, Calibration, Status
from calib.structure import EVEN_DILUTION, TOLD_FRACTION, Structure, dilution, structure_of
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

MAX_MISFIT_FRACTION = 0.1
"""Median residual of an accepted fit at most, as a fraction of the field: beyond are a constant field with noise, a
wrong attitude or a wrong unit. Soft iron of 10 % left out of a model stays below."""
MAX_CONDITION = 50.0
"""Condition number of an accepted matrix at most: beyond, an axis measures nothing, or two axes measure the same
component; the strongest soft iron known from vehicles stretches by 2."""
Extents = tuple[Extent, ...]
"""Extent of the measurements of each sensor; empty for methods that need no more than a plane."""
NEGATIVE = -1e-3
"""Smallest eigenvalue of the correlations of a valid covariance; rounding stays above."""


@dataclass(frozen=True, eq=False)
class CorrectedField:
    """The field of a recording as a fit corrects it, in order of time, and the structure that its strength keeps.

    What is derived is computed once, when asked for: widening and judgement look at the same field.
    """

    fit: Calibration
    recording: Recording
    strength_nT: float

    @cached_property
    def field_nT(self) -> Array:
        """The corrected field (n, 3), body frame."""
        return in_time(self.recording, self.fit.apply(self.recording))

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """|h| - F (n,), and how the noise of the measurements enters (n, 3), see `strength_rows`."""
        return strength_rows(self.fit, self.field_nT, self.strength_nT)

    @cached_property
    def structure(self) -> Structure:
        """What |h| - F holds beside white noise."""
        return structure_of(self.fit, self.field_nT, self.rows, self.strength_nT)


def own_reference(fit: Calibration, reference: Reference) -> Reference:
    """Reference for the residual: the fitted strength, if the method fits a strength instead of the given one."""
    found_nT = fit.parameters.get(STRENGTH_NAME)
    return reference if found_nT is None else Reference(found_nT)


def residual_of(fit: Calibration, recording: Recording, reference: Reference, *, vector: bool) -> Array:
    """Residual of a fit in order of time: |h| - F (n,), or with known attitude h - R_wb^T F (n, 3), nT."""
    if not vector and not fit.segments and fit.eddy_s is None:
        size_nT = strengths(np.ascontiguousarray(recording.mag_nT), fit.offset_nT, np.ascontiguousarray(fit.matrix))
        return in_time(recording, size_nT - reference.strength_nT)
    field_nT = fit.apply(recording)
    if vector:
        assert recording.att_q is not None
        assert reference.field_enu_nT is not None
        residual = field_nT - world_to_body(recording.att_q, np.array(reference.field_enu_nT))
    else:
        residual = lengths(field_nT) - reference.strength_nT
    return in_time(recording, np.asarray(residual))


def measured(recording: Recording) -> Recording:
    """The recording without rows whose measurement is missing."""
    missing = np.isnan(recording.mag_nT[:, 0])
    return recording.taken(~missing) if missing.any() else recording


def in_time(recording: Recording, values: Array) -> Array:
    """Values (n, ...) of the recording's samples in order of time."""
    late = recording.time_s[1:] < recording.time_s[:-1]
    return values[np.argsort(recording.time_s, kind="stable")] if late.any() else values


def extents(recording: Recording) -> Extents:
    """Extent of the measurements of the magnetometer, or of each sensor of an array."""
    sensors = [recording.mag_nT] if recording.array_mag_nT is None else recording.array_mag_nT
    return tuple(Extent.of(sensor) for sensor in sensors)


def planar(sensors: Extents, noise_std_nT: float = 0.0) -> Status | None:
    """`planar_status` of the first sensor with planar measurements."""
    return next((flat for sensor in sensors if (flat := planar_status(sensor, noise_std_nT)) is not None), None)


def flat_status(fit: Calibration, sensors: Extents, residual_nT: Array) -> Status | None:
    """Unobservable when a sensor's measurements leave a plane by no more than the noise, as fitted or as the residual.

    A failed fit without a fitted noise is not tested.
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
    field: CorrectedField,
    reference: Reference,
    *,
    vector: bool,
    response: Response | None = None,
) -> Calibration:
    """The fit with the covariance scaled for a coloured residual, see `calib.numerics.colour`.

    Flicker noise adds a covariance by the response of the fit to each sample, see `calib.numerics.flicker`; not for a
    fit that has not converged, whose error would count as noise. A nonlinear characteristic adds the square of the
    offset that it moves, and is taken off the residual before colour and flicker noise are looked for, see
    `calib.structure`.
    """
    if fit.covariance is None or fit.offset_covariance_nT2 is None:
        return fit
    distortion_nT = None if vector else field.structure.distortion_nT
    factor = _colour(residual_nT, field, vector=vector) * few_factor(residual_nT.size - len(fit.covariance_names))
    flicker_nT2, claimed_nT2 = flicker_power(*_rows_left(field, vector=vector))
    covariance = factor * fit.covariance
    if (flicker_nT2 > 0 or distortion_nT is not None) and fit.status.kind != "not_converged":
        moved = response or _response(fit, field, reference, vector=vector)
        if flicker_nT2 > 0:
            lasting = flicker_covariance(moved.K, _rate_hz(field.recording))
            _add(covariance, fit.covariance_names, moved, claimed_nT2 * lasting)
        if distortion_nT is not None:
            error_nT2 = _distortion_error(moved, distortion_nT, reference.strength_nT)
            _add(covariance, fit.covariance_names, moved, error_nT2)
    told = {"covariance_inflation": factor, "flicker_nT_sqrt_hz": float(np.sqrt(flicker_nT2))}
    return replace(fit, covariance=covariance, parameters=fit.parameters | told)


def _colour(residual_nT: Array, field: CorrectedField, *, vector: bool) -> float:
    """The inflation of the residual, of a fit without the vector less a characteristic."""
    return inflation(residual_nT) if vector else field.structure.inflation


def _rows_left(field: CorrectedField, *, vector: bool) -> tuple[Array, Array]:
    """The rows of the field's strength, of a fit without the vector less a characteristic."""
    return field.rows if vector else (field.structure.left_nT, field.rows[1])


def _distortion_error(moved: Response, distortion_nT: Array, strength_nT: float) -> Array:
    """Square of what a distortion (n, 3) of the measurements moves: b b^T + (max |d|^2 / F)^2 I of the offset.

    b = sum K_i d_i to first order; the second order is no more than the square of the distortion. S keeps its claim,
    since a gain that varies along the range has no error.
    """
    offset = np.array([name in OFFSET_NAMES for name in moved.names])
    bias_nT = offset * np.einsum("npi,ni->p", moved.K, distortion_nT)
    second_nT = float(np.max(np.sum(distortion_nT**2, axis=1))) / strength_nT
    return np.asarray(np.outer(bias_nT, bias_nT) + np.diag(offset * second_nT**2))


def _response(fit: Calibration, field: CorrectedField, reference: Reference, *, vector: bool) -> Response:
    """Response of the fit to the samples, in order of time."""
    recording = field.recording
    if not vector:
        return of_strength(fit, field.field_nT, reference.strength_nT)
    assert recording.att_q is not None
    assert reference.field_enu_nT is not None
    return of_vector(in_time(recording, world_to_body(recording.att_q, np.array(reference.field_enu_nT))))


def _rate_hz(recording: Recording) -> float:
    return (len(recording) - 1) / float(np.ptp(recording.time_s))


def _add(covariance: Array, names: tuple[str, ...], response: Response, more: Array) -> None:
    """Add a covariance in the rows and columns of the common parameters."""
    both = [name for name in response.names if name in names]
    rows, those = [names.index(name) for name in both], [response.names.index(name) for name in both]
    covariance[np.ix_(rows, rows)] += more[np.ix_(those, those)]


def judgement(
    fit: Calibration, residual_nT: Array, field: CorrectedField, reference: Reference, *, vector: bool
) -> Status | None:
    """Status of a fit by `unsupported`, with the residual's structure as the cause; None where the fit's own stands.

    A covariance too large is caused by structure where directions spread evenly would leave it too large, and by the
    motion elsewhere. An "ok" whose residual has structure of TOLD_FRACTION of the field says so.
    """
    worse = unsupported(fit, residual_nT, reference)
    if vector or fit.covariance is None or "S_xx" not in fit.covariance_names:
        return worse
    if fit.status.kind != "ok" or (worse is not None and worse != covariance_status(fit, reference.strength_nT)):
        return worse
    structure = field.structure
    if structure.kind == "white":
        return worse
    return _caveat(fit, structure, reference) if worse is None else _caused(fit, field, reference, worse)


def _caveat(fit: Calibration, structure: Structure, reference: Reference) -> Status | None:
    """Ok with the structure as a caveat, where large and without another caveat."""
    if fit.status.reason or structure.rms_nT <= TOLD_FRACTION * reference.strength_nT:
        return None
    return Status("ok", f"{structure.text}; {structure.remedy}")


def _caused(fit: Calibration, field: CorrectedField, reference: Reference, motion: Status) -> Status:
    """The structure as the cause of a covariance too large; the motion, structure beside, if even directions help."""
    assert fit.covariance is not None
    structure, spread = field.structure, dilution(field.fit, field.field_nT, field.strength_nT)
    even = replace(fit, covariance=fit.covariance * min(1.0, (EVEN_DILUTION / spread) ** 2))
    if structure.kind != "characteristic" and covariance_status(even, reference.strength_nT) is None:
        told = structure.rms_nT > TOLD_FRACTION * reference.strength_nT
        return Status("unobservable", f"{motion.reason}; beside, {structure.text}") if told else motion
    return Status("unobservable", f"{_worst_text(fit, reference)}: {structure.text}; {structure.remedy}")


def _worst_text(fit: Calibration, reference: Reference) -> str:
    """The largest standard deviation of the offset in the calibrated field."""
    assert fit.offset_covariance_nT2 is not None
    worst = float(np.sqrt(np.linalg.eigvalsh(fit.matrix @ fit.offset_covariance_nT2 @ fit.matrix.T)[-1]))
    share = 100 * worst / reference.strength_nT
    return f"the offset has a standard deviation of {figure(worst)} nT ({figure(share, 2)} % of the field)"


def unsupported(fit: Calibration, residual_nT: Array, reference: Reference) -> Status | None:
    """Status of a fit contradicted by covariance, matrix or residual; None for a consistent fit."""
    return (
        _indefinite(fit)
        or _mirrored(fit)
        or _singular(fit)
        or covariance_status(fit, reference.strength_nT)
        or _misfit(residual_nT, reference.strength_nT)
    )


def _indefinite(fit: Calibration) -> Status | None:
    """Not converged when the covariance is not positive semidefinite."""
    if fit.covariance is None:
        return None
    variance = np.diag(fit.covariance)
    std = np.sqrt(np.where(variance > 0, variance, 1.0))
    if variance.min() >= 0 and np.linalg.eigvalsh(fit.covariance / np.outer(std, std))[0] >= NEGATIVE:
        return None
    return Status("not_converged", "the claimed covariance is not positive definite: record longer, about more axes")


def _mirrored(fit: Calibration) -> Status | None:
    """Not converged when the matrix is a reflection, which no sensor's scale, soft iron and mounting make."""
    if np.linalg.det(fit.matrix) >= 0:
        return None
    what = "the magnetometer's axes are left-handed: the matrix mirrors the field, no turn makes it right"
    return Status(
        "not_converged", f"{what}; check order and signs of the axes: --axes or --map, see `magbench inspect`"
    )


def _singular(fit: Calibration) -> Status | None:
    """Unobservable when a matrix stretches or squeezes a body direction alone: noise taken for field, or vice versa."""
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
        f"the matrix is nearly singular (condition number {figure(condition, 2)}, limit {MAX_CONDITION:g}), "
        "by what it does "
        "along it: the motion hardly turns it, or an axis is not wired, or two measure the same",
    )


def _misfit(residual_nT: Array, strength_nT: float) -> Status | None:
    """Not converged when the residual is a large part of the field."""
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
        f"the corrected field is still off by {figure(typical)} nT, {figure(100 * typical / strength_nT, 2)} "
        "% of the field "
        f"(limit {100 * MAX_MISFIT_FRACTION:g} %): the measurements do not follow it; "
        "check field, unit, axes and attitude",
    )
