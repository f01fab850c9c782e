"""Non-orthogonality and non-levelness together, from a turn about the vertical, by differential evolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from calib.base import Calibrator
from calib.families.norm_search import SETTLED
from calib.models.turntable import NAMES, ROUNDING, Residuals, TurnSpace, axes_matrix
from calib.observability import Extent, axis_text, unobservable
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.search.differential import RandOne
from calib.search.population import SearchResult, search
from calib.settings import Count, Positive, Probability
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

MAX_STD = 0.01
"""Unobservable: a direction cosine less certain than this."""
MISFIT = 5.0
"""The total's residual may be this many times the vertical's: both hold the same noise when the model is right."""
UPRIGHT = 0.95
"""Least cosine between the axis of the turn and the sensor's z: the five are small."""


@dataclass(frozen=True)
class DeTurntable(Calibrator):
    """Five direction cosines from a turn about the vertical, by differential evolution DE/rand/1.

    m = A h;  f(A) = sum_i (h_z,i - mean h_z)^2 + (|h_i| - mean |h|)^2,  h = A^-1 m        [Zhou2012]
    v_i = x_r1 + F_w (x_r2 - x_r3);  u_ij = v_ij if rand < P_c or j = j_r, else x_ij;  the better of u_i, x_i stays

    A's rows are the sensor's axes in the level frame of `axes_matrix`. No offset, no scale: an offset would pass for a1
    and b2, and what the five cannot explain is told by the status. `known_total` puts the reference strength in the
    place of mean |h|. Settings are the paper's; where a mutant leaves +-`bound`, which the paper leaves open, the entry
    is drawn anew. `most_wobble`: rms thickness, in parts of F, up to which the data count as a turn about one axis.

    Observability: to first order, with horizontal field H, vertical field V and azimuth p of the turn,
    dz = H (dc1 cos p + dc2 sin p),  d|h| = V H / F ((da1 + dc1) cos p + (db2 + dc2) sin p) + H^2 / F db1 cos p sin p:
    c1 and c2 come from z, the sums a1 + c1 and b2 + c2 and the entry b1 from the total alone. Covariance: linearised,
    with the correlation V / F between the noise of z and of the total. A lean of the stops scatters z and not the
    total: the covariance takes the excess for noise of z alone, and stops that are clearly not level are refused.
    `weakest_...`: the worst unit combination of the five and its standard deviation, from the singular values of the
    Jacobian.
    """

    name: ClassVar[str] = "de_turntable"
    summary: ClassVar[str] = "five direction cosines from a turn about the vertical, differential evolution (Zhou2012)"
    min_samples: ClassVar[int] = 8
    one_axis: ClassVar[bool] = True
    population: Annotated[int, Field(ge=4)] = 25
    iterations: Count = 500
    crossing: Probability = 1.0
    weight: Positive = 0.85
    bound: Annotated[float, Field(gt=0, lt=0.7)] = 0.2
    known_total: bool = False
    most_wobble: Positive = 2e-3

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        unfit = self._turn_status(recording.mag_nT, reference.strength_nT)
        if unfit is not None:
            return unfit
        points = np.ascontiguousarray(recording.mag_nT.T / reference.strength_nT)
        found = self.search(points, rng)
        rms = np.sqrt(found.costs / (2 * points.shape[1]))
        left = Residuals.of(points, found.best, self.known_total)
        covariance, noise = left.covariance()
        told = observability(left.normal, covariance) | {"noise_std_nT": noise * reference.strength_nT}
        return Calibration(
            name=self.name,
            status=_status(left, covariance, noise, reference.strength_nT),
            matrix=np.asarray(np.linalg.inv(axes_matrix(found.best))),
            parameters=dict(zip(NAMES, found.best.tolist(), strict=True)) | told,
            covariance=covariance,
            covariance_names=NAMES,
            history=tuple((reference.strength_nT * rms).tolist()),
        )

    def search(self, points: Array, rng: np.random.Generator) -> SearchResult:
        """Best (5,) and the best cost after each iteration, on points m / F (3, n)."""
        space = TurnSpace(points, self.bound, 1.0 if self.known_total else 0.0)
        return search(space, RandOne(self.weight, self.crossing), self.population, self.iterations, rng)

    def _turn_status(self, mag_nT: Array, strength_nT: float) -> Status | None:
        """Not applicable unless the measurements are those of a turn about one axis, near the sensor's z."""
        axis = Extent.of(mag_nT).thinnest
        wobble_nT = float(np.std((mag_nT - mag_nT.mean(axis=0)) @ axis))
        if wobble_nT > self.most_wobble * strength_nT:
            return Status(
                "not_applicable",
                (
                    f"{self.name} needs a turn about the vertical alone, and the measurements leave a plane by "
                    f"{figure(wobble_nT)} nT rms (limit {figure(self.most_wobble * strength_nT)} nT): use another "
                    "method"
                ),
            )
        if abs(axis[2]) < UPRIGHT:
            return Status(
                "not_applicable",
                (
                    f"{self.name} needs a turn about the sensor's z axis, and this one is about {axis_text(axis)}: "
                    "turn about the vertical with z near it"
                ),
            )
        return None


def observability(normal: Array, covariance: Array) -> dict[str, float]:
    """The weakest unit combination of the five, its standard deviation, and the Jacobian's condition number."""
    singular, axes = np.linalg.eigh(normal)
    weakest = axes[:, 0] * np.sign(axes[np.argmax(np.abs(axes[:, 0])), 0])
    std = float(np.sqrt(max(weakest @ covariance @ weakest, 0.0)))
    condition = float(np.sqrt(singular[-1] / singular[0]))
    parts = {f"weakest_{name}": float(w) for name, w in zip(NAMES, weakest, strict=True)}
    return {"condition_number": condition, "weakest_std": std} | parts


def _status(left: Residuals, covariance: Array, noise: float, strength_nT: float) -> Status:
    return _misfit(left, strength_nT) or _leaning(left, strength_nT) or _loose(covariance) or _settled(left, noise)


def _misfit(left: Residuals, strength_nT: float) -> Status | None:
    """Unobservable when the total varies by much more than z: something that is not in the model."""
    total, vertical = (float(np.sqrt(np.mean(part**2))) for part in (left.length, left.vertical))
    if total <= MISFIT * max(vertical, ROUNDING):
        return None
    return unobservable(
        np.array([0.0, 0.0, 1.0]),
        f"the corrected total still varies by {figure(total * strength_nT)} nT rms where z varies by "
        f"{figure(vertical * strength_nT)} nT, so there are offsets or unequal scales, which a turn about the "
        "vertical alone cannot sort out",
    )


def _leaning(left: Residuals, strength_nT: float) -> Status | None:
    """Unobservable when z scatters by much more than the total: the stops lean, each by another angle."""
    if left.lean == 0.0:
        return None
    of_z_nT, of_length_nT = (strength_nT * scatter for scatter in left.scatter)
    return Status(
        "unobservable",
        f"the stops are not level: z scatters by {figure(of_z_nT)} nT where the total scatters by "
        f"{figure(of_length_nT)} nT, a lean of {figure(np.degrees(left.lean), 2)} degrees rms, which this method takes "
        "for the sensor's own axes: level each stop, or use a method that takes the attitude (vector_least_squares)",
    )


def _loose(covariance: Array) -> Status | None:
    """Unobservable when a direction cosine is less certain than MAX_STD."""
    std = np.sqrt(np.diag(covariance))
    loose = [f"{name} ({figure(s, 2)})" for name, s in zip(NAMES, std, strict=True) if s > MAX_STD]
    if not loose:
        return None
    return Status(
        "unobservable",
        f"standard deviation above {MAX_STD:g} of {', '.join(loose)}: make a whole turn, where the field has "
        "a horizontal and a vertical part",
    )


def _settled(left: Residuals, noise: float) -> Status:
    """Not converged when a Gauss-Newton step from the solution is longer than SETTLED standard deviations."""
    decrement = float(np.sqrt(left.slope @ np.linalg.solve(left.normal, left.slope))) / noise
    return Status.settled(
        decrement <= SETTLED,
        f"the search ended {figure(decrement, 2)} standard deviations from the minimum: more iterations",
    )
