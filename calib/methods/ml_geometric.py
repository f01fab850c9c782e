"""Exact maximum likelihood of the nine parameters: the least squared distances to an ellipsoid."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from calib.base import Calibrator
from calib.models.distance import distances, slopes
from calib.models.ellipsoid import (
    UPPER,
    Ellipsoid,
    EllipsoidFit,
    Standardised,
    is_definite,
    mean_square_error,
    symmetric,
)
from calib.models.starts import starts
from calib.numerics.damped import Minimum, NormalEquations, minimised
from calib.numerics.noise import NORMAL_MEDIAN
from calib.reference import Reference
from calib.result import STRENGTH_NAME, Calibration, Status
from calib.settings import Count, Positive
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

PARAMETERS = 9
ROUNDING_VARIANCE = 1e-18
"""Smallest variance of points of unit size: rounding, 1e-9 of their size."""
USUAL_HUBER = 1.345
"""Limit of the distances' weight that keeps 95 % of the efficiency for Gaussian noise [Huber1964]."""
SCALE_ROUNDS, SCALE_SETTLED = 20, 1e-3
"""Rounds of the robust noise, and its relative change at which they end."""


@dataclass(frozen=True)
class MaximumLikelihoodGeometric(Calibrator):
    """Offset and symmetric S of greatest likelihood, every sample's direction unknown.

    m_i = S F u_i + b + n_i,  |u_i| = 1,  n_i white, equal on the axes:  min over b, S, u of sum |m_i - S F u_i - b|^2

    The best u_i is the direction of the nearest point of the ellipsoid, so sum d_i^2 of the distances is minimised over
    the nine parameters, by damped Gauss-Newton with the exact d d_i / d (b, S) (eliminating each u_i). Started from the
    nearer of the noise-adjusted algebraic ellipsoid and the sphere; the other is tried where the first does not settle.
    Noise along the surface leaves a distance of mean sigma^2 K, K the mean curvature: what this moves is taken off in
    one step, sigma^2 H^-1 J^T K. It is small beside the noise unless sigma sqrt(n) is no small part of F.
    Claimed covariance: sigma^2 H^-1, the inverse information. S is symmetric: the strength tells no rotation. [Ahn2002]

    `huber`: distances beyond this many standard deviations count linearly, not by their square, the standard deviation
    by the median; for spikes and disturbed places (1.345 keeps 95 % of the efficiency [Huber1964]). None: likelihood.
    `strength_known` False: the strength is fitted too, and the scale is then not observable. S is scaled to det S = 1,
    `strength_nT` in the parameters is the field in that scale, and the offset does not depend on it.
    """

    name: ClassVar[str] = "ml_geometric"
    summary: ClassVar[str] = "9 parameters by exact maximum likelihood: least distances to an ellipsoid; no attitude"
    min_samples: ClassVar[int] = 10
    iterations: Count = 100
    tolerance: Positive = 1e-4
    huber: Annotated[float, Field(gt=0, examples=[USUAL_HUBER])] | None = None
    strength_known: bool = True

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        scaled = Standardised.of(recording.mag_nT)
        found, problem = self._minimum(scaled.x)
        status = Status.settled(
            found.settled,
            f"after {len(found.history)} steps the estimate still moves by {figure(found.history[-1], 2)} "
            "standard deviations",
        )
        fit = problem.fit(found)
        if self.strength_known:
            return scaled.calibration(self.name, status, fit, reference)
        return _of_unit_scale(self.name, status, scaled, fit)

    def _minimum(self, x: Array) -> tuple[Minimum[Array], Distances]:
        """The best minimum from the starts, in order of their cost until one settles."""
        plain = Distances(x)
        tried: list[tuple[Minimum[Array], Distances]] = []
        for start in sorted(starts(x), key=lambda q: plain.normal(q).cost):
            tried.append(self._from(plain, start))
            if tried[-1][0].settled:
                break
        return min(tried, key=lambda one: one[0].normal.cost)

    def _from(self, problem: Distances, start: Array) -> tuple[Minimum[Array], Distances]:
        """The minimum from a start; with `huber` again until the noise that weighs the distances settles."""
        found = minimised(problem, start, self.iterations, self.tolerance)
        for _ in range(SCALE_ROUNDS if self.huber is not None else 0):
            assert self.huber is not None
            limit = max(self.huber * problem.robust_std(found.point), np.sqrt(ROUNDING_VARIANCE))
            settled = abs(limit - problem.limit) < SCALE_SETTLED * limit
            problem = replace(problem, limit=limit)
            found = minimised(problem, found.point, self.iterations, self.tolerance)
            if settled:
                break
        return found, problem


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of points x (n, 3) as a problem in q (9,); those beyond `limit` count linearly."""

    x: Array
    limit: float = np.inf

    def normal(self, q: Array) -> NormalEquations:
        """Cost and normal equations."""
        d, J, _ = self.rows(q)
        weight = np.minimum(1.0, self.limit / np.maximum(np.abs(d), 1e-300))
        cost = float(np.sum(weight * (2.0 - weight) * d * d))
        weighted = weight[:, None] * J
        return NormalEquations(cost, weighted.T @ d, weighted.T @ J, self._variance(d, weight))

    def moved(self, q: Array, step: Array) -> Array | None:
        """The ellipsoid a step further; None where it is none."""
        further = q + step
        return further if is_definite(symmetric(further[3:])) else None

    def rows(self, q: Array) -> tuple[Array, Array, Array]:
        """Distances (n,), their slopes (n, 9), and the mean curvature (n,) of the ellipsoid."""
        semi, axes = np.linalg.eigh(symmetric(q[3:]))
        d, direction, normal, curvature = distances(self.x, q[:3], semi, np.ascontiguousarray(axes))
        return d, slopes(direction, normal), curvature

    def robust_std(self, q: Array) -> float:
        """Noise of a component by the median of the distances."""
        return float(np.median(np.abs(self.rows(q)[0]))) / NORMAL_MEDIAN

    def fit(self, found: Minimum[Array]) -> EllipsoidFit:
        """The ellipsoid of a minimum, freed of the curvature's bias, and its covariance.

        H^-1 M H^-1,  H = sum psi' J J^T,  M = sum psi^2 J J^T,  psi the distance, cut at `limit`
        """
        d, J, curvature = self.rows(found.point)
        inside = (np.abs(d) <= self.limit)[:, None] * J
        information = inside.T @ J
        psi = np.clip(d, -self.limit, self.limit)
        variance = max(float(psi @ psi) / (len(d) - PARAMETERS), ROUNDING_VARIANCE)
        meat = None if np.isinf(self.limit) else J.T @ J
        error = mean_square_error(information, variance, meat)
        q = found.point + np.linalg.solve(information, inside.T @ (variance * curvature))
        q = q if is_definite(symmetric(q[3:])) else found.point
        noise = float(np.sqrt(variance)) if np.isinf(self.limit) else self.robust_std(q)
        return EllipsoidFit(Ellipsoid(q[:3], symmetric(q[3:])), error, noise, found.history)

    def _variance(self, d: Array, weight: Array) -> float:
        return max(float(np.sum((weight * d) ** 2)) / (len(d) - PARAMETERS), ROUNDING_VARIANCE)


def _of_unit_scale(name: str, status: Status, scaled: Standardised, fit: EllipsoidFit) -> Calibration:
    """The fit with det S = 1: dS = (dG - G tr(G^-1 dG) / 3) / F, F = scale det(G)^(1/3)."""
    root = fit.ellipsoid.root
    strength_nT = scaled.scale_nT * float(np.linalg.det(root)) ** (1.0 / 3.0)
    trace = np.linalg.inv(root)[UPPER] * np.where(UPPER[0] == UPPER[1], 1.0, 2.0)
    free = np.eye(PARAMETERS)
    free[3:, 3:] -= np.outer(root[UPPER], trace) / 3.0
    projected = replace(fit, covariance=free @ fit.covariance @ free.T)
    found = scaled.calibration(name, status, projected, Reference(strength_nT))
    return replace(found, parameters=found.parameters | {STRENGTH_NAME: strength_nT})
