"""Maximum likelihood of the radial residual by Newton's method."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from calib.base import Calibrator
from calib.methods.twostep import TwoStep
from calib.models.ellipsoid import Ellipsoid, Standardised, norm_coordinates, symmetric, symmetric_root
from calib.models.norm import norm_cost, norm_derivatives, norm_fit
from calib.models.quadric import fit_ellipsoid_specific, refit
from calib.numerics.rates import world_to_body
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.settings import Count, Positive
from recordings import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.text import figure

Vec3 = tuple[float, float, float]
MAX_GAIN = 20.0
"""Largest gain of S, in units of the measurements' rms extent over F: beyond it T has shrunk towards nothing."""
RESIDUAL_RATIO = 3.0
"""A minimum whose residual exceeds that of the best-fitting quadric by this factor is a local one."""
ROUNDING = 1e-9
SCATTER_ROUNDING = 1e-7
"""Noise below which a scatter matrix tells none: the root of what a float keeps, over the points' extent."""


@dataclass(frozen=True)
class MaximumLikelihoodNewton(Calibrator):
    """Offset and S by Newton's method on the radial residual, turned to the known field where the attitude is recorded.

    min over T, b of f = sum ( |T (m - b)| - F )^2,    T = U_1 S_1 V_1^T,  R_L = V_1,  S_L = S_1^-1,
    h = V_L S_L^-1 R_L^T (m - b),    S = R_L S_L V_L^T

    [Long2013] eq. 10 to 12. Eq. 10 constrains only the radial residual in the corrected field: it approximates the
    likelihood of eq. 7, whose residual is the distance to the ellipsoid weighted by the noise. Its infimum, 0, is no
    calibration: T -> 0, b -> infinity with |T b| = F. A result there, or in a local minimum, is "not_converged".
    T is kept symmetric (six parameters; the Hessian of a full T is singular along rotations) and written y = T m - c,
    linear in (T, c). The Newton step has the exact gradient and Hessian; where the Hessian is indefinite or the cost
    would rise, it is damped (H + lambda I). Start: `start_offset_nT`, or the two-step solution (eq. 10's references).
    V_L is the least-squares rotation (Kabsch) to the field in the body frame when attitude and field vector are known
    and `align` is set, else R_L (symmetric S). Claimed covariance: of offset and the symmetric factor R_L S_L R_L^T
    (S_xx ... S_zz), with the bias of second order.

    `gradient_tolerance` xi: stop when the gradient, in standard deviations of the parameters, is below it.
    """

    name: ClassVar[str] = "ml_newton"
    summary: ClassVar[str] = "9 parameters by Newton on the norm residual; aligned to the field where attitude is known"
    min_samples: ClassVar[int] = 10
    iterations: Count = 50
    gradient_tolerance: Positive = 1e-4
    align: bool = True
    start_offset_nT: Vec3 | None = None
    start_matrix: tuple[Vec3, Vec3, Vec3] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.start_offset_nT is None) != (self.start_matrix is None):
            raise InputError(
                "a start needs both start_offset_nT and start_matrix", where=self.name, do="give both or none"
            )

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        scaled = Standardised.of(recording.mag_nT)
        start, noise_std = two_step_start(scaled.x)
        if self.start_offset_nT is not None:
            start = self._given_start(scaled, reference)
        p, history, settled = self._newton(scaled.x, start)
        wrong = _wrong_minimum(p, scaled, noise_std)
        if wrong is not None:
            noise = {"noise_std_nT": noise_std * scaled.scale_nT}
            return Calibration(name=self.name, status=wrong, parameters=noise, history=history)
        status = Status.settled(
            settled,
            f"after {len(history)} Newton steps the gradient is still {figure(history[-1], 2)} standard "
            f"deviations, the limit is {self.gradient_tolerance:g}",
        )
        found = scaled.calibration(self.name, status, norm_fit(p, scaled.x, history), reference)
        return self._aligned(found, recording, reference) if self.align else found

    def _given_start(self, scaled: Standardised, reference: Reference) -> Array:
        given, offset_nT = np.array(self.start_matrix), np.array(self.start_offset_nT)
        T = symmetric_root(given.T @ given) * scaled.scale_nT / reference.strength_nT
        return norm_coordinates(T, T @ (offset_nT - scaled.middle_nT) / scaled.scale_nT)

    def _newton(self, x: Array, p: Array) -> tuple[Array, tuple[float, ...], bool]:
        """Damped Newton steps from p (9,); the gradient's size a step, and whether it fell below the tolerance."""
        history: list[float] = []
        damping = 0.0
        for _ in range(self.iterations):
            f, gradient, hessian = norm_derivatives(p, x)
            values, axes = np.linalg.eigh(hessian)
            slope = axes.T @ gradient
            noise = 2 * f / len(x) + ROUNDING**2
            history.append(float(np.sqrt(np.sum(slope**2 / np.maximum(np.abs(values), 1e-12 * values[-1])) / noise)))
            if history[-1] < self.gradient_tolerance and values[0] > 0:
                return p, tuple(history), True
            moved = _damped_step(x, p, f, values, axes, slope, damping)
            if moved is None:
                return p, tuple(history), False
            p, damping = moved
        return p, tuple(history), False

    def _aligned(self, found: Calibration, recording: Recording, reference: Reference) -> Calibration:
        """V_L by Kabsch: the rotation of the corrected field (n, 3) to the known field in the body frame."""
        if recording.att_q is None or reference.field_enu_nT is None:
            return found
        h_nT = world_to_body(recording.att_q, np.array(reference.field_enu_nT))
        if not np.isfinite(h_nT).all():
            return found
        u, _, vt = np.linalg.svd(h_nT.T @ found.apply(recording))
        turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
        return replace(found, matrix=turn @ found.matrix)


def _damped_step(
    x: Array, p: Array, f: float, values: Array, axes: Array, slope: Array, damping: float
) -> tuple[Array, float] | None:
    """The first p - (H + lambda I)^-1 g, lambda growing, with lower cost and T definite; and the next lambda."""
    least = max(0.0, 1e-3 * values[-1] - 2 * values[0]) if values[0] <= 0 else 0.0
    damping = max(damping, least)
    for _ in range(60):
        new = p - axes @ (slope / (values + damping))
        if _definite(new) and norm_cost(new, x) <= f:
            return new, (damping / 10 if damping > 1e-9 * values[-1] else 0.0)
        damping = max(10 * damping, 1e-6 * values[-1])
    return None


def _definite(p: Array) -> bool:
    return bool(np.linalg.eigvalsh(symmetric(p[:6]))[0] > 0)


def two_step_start(x: Array) -> tuple[Array, float]:
    """Norm coordinates (9,) and noise of a component; from the ellipsoid-specific fit where step one fails."""
    found = TwoStep().estimate(x)
    if found is not None:
        return found.start(), found.noise_std
    theta = fit_ellipsoid_specific(x)
    ellipsoid = Ellipsoid.of_quadric(theta)
    if ellipsoid is None:
        raise np.linalg.LinAlgError("the measurements do not start an ellipsoid")
    return ellipsoid.norm, refit(x, theta).noise_std


def _wrong_minimum(p: Array, scaled: Standardised, noise_std: float) -> Status | None:
    """Why p (9,) is no calibration: T has shrunk towards nothing, or the residual is far above the noise."""
    values = np.linalg.eigvalsh(symmetric(p[:6]))
    if values[0] < 1.0 / MAX_GAIN:
        return Status(
            "not_converged",
            "the search ran towards T = 0, b = infinity, where the cost vanishes: "
            "start nearer, or cover more attitudes",
        )
    residual = float(np.sqrt(norm_cost(p, scaled.x) / len(scaled.x))) / float(values[-1])
    if residual > RESIDUAL_RATIO * noise_std + SCATTER_ROUNDING:
        return Status(
            "not_converged",
            f"a local minimum: its residual is {figure(residual * scaled.scale_nT)} nT where "
            f"the two-step estimate leaves {figure(noise_std * scaled.scale_nT)} nT; start nearer",
        )
    return None
