"""Non-orthogonality and non-levelness together, from a turn about the vertical, by differential evolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from calib.base import Calibrator
from calib.families.population import SETTLED
from calib.numerics.kernels import kernel
from calib.observability import axis_text, thinnest_direction, unobservable
from calib.reference import Reference
from calib.result import Calibration, Status
from sim.dataset import Recording

Array = NDArray[np.float64]
NAMES = ("a1", "b1", "b2", "c1", "c2")
PLACES = ((0, 2), (1, 0), (1, 2), (2, 0), (2, 1))
"""Where in A each of the five stands."""
MAX_STD = 0.01
"""Unobservable: a direction cosine less certain than this."""
MISFIT = 5.0
"""The total's residual may be this many times the vertical's: both hold the same noise when the model is right."""
ROUNDING = 1e-7
"""Residual that rounding alone gives, as a fraction of the field."""
UPRIGHT = 0.95
"""Least cosine between the axis of the turn and the sensor's z: the five are small."""


def axes_matrix(theta: Array) -> Array:
    """A (3, 3) with rows (., 0, a1), (b1, ., b2), (c1, c2, .) of length one."""
    a1, b1, b2, c1, c2 = theta
    return np.array(
        [[np.sqrt(1 - a1**2), 0.0, a1], [b1, np.sqrt(1 - b1**2 - b2**2), b2], [c1, c2, np.sqrt(1 - c1**2 - c2**2)]]
    )


@kernel
def costs(particles: Array, points: Array, total: float) -> Array:
    """Sum of squared deviations of z and of the length of A^-1 m: particles (k, 5), points (3, n), gives (k,).

    z from its mean; the length from `total`, or from its mean where total <= 0.
    """
    n = points.shape[1]
    out, vertical, length = np.empty(len(particles)), np.empty(n), np.empty(n)
    for k in range(len(particles)):
        a1, b1, b2, c1, c2 = particles[k]
        a0, b0, c0 = np.sqrt(1 - a1 * a1), np.sqrt(1 - b1 * b1 - b2 * b2), np.sqrt(1 - c1 * c1 - c2 * c2)
        determinant = a0 * (b0 * c0 - b2 * c2) + a1 * (b1 * c2 - b0 * c1)
        for i in range(n):
            x, y, z = points[0, i], points[1, i], points[2, i]
            hx = ((b0 * c0 - b2 * c2) * x + a1 * c2 * y - a1 * b0 * z) / determinant
            hy = ((b2 * c1 - b1 * c0) * x + (a0 * c0 - a1 * c1) * y + (a1 * b1 - a0 * b2) * z) / determinant
            hz = ((b1 * c2 - b0 * c1) * x - a0 * c2 * y + a0 * b0 * z) / determinant
            vertical[i] = hz
            length[i] = np.sqrt(hx * hx + hy * hy + hz * hz)
        middle = vertical.mean()
        aim = total if total > 0.0 else length.mean()
        out[k] = ((vertical - middle) ** 2).sum() + ((length - aim) ** 2).sum()
    return out


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
    with the correlation V / F between the noise of z and of the total; `weakest_...`: the worst unit combination of the
    five and its standard deviation, from the singular values of the Jacobian.
    """

    name: ClassVar[str] = "de_turntable"
    summary: ClassVar[str] = "five direction cosines from a turn about the vertical, differential evolution (Zhou2012)"
    min_samples: ClassVar[int] = 8
    recovers: ClassVar[tuple[str, ...]] = ()
    population: int = 25
    iterations: int = 500
    crossing: float = 1.0
    weight: float = 0.85
    bound: float = 0.2
    known_total: bool = False
    most_wobble: float = 2e-3

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        points = np.ascontiguousarray(recording.mag_nT.T / reference.strength_nT)
        odd = self._turn_status(recording.mag_nT, reference.strength_nT)
        if odd is not None:
            return odd
        best, found = self.search(points, rng)
        history = tuple((reference.strength_nT * np.sqrt(found / (2 * points.shape[1]))).tolist())
        fit = _Linear(points, best, self.known_total)
        status = fit.misfit(reference.strength_nT) or fit.loose() or fit.settled()
        parameters = (
            dict(zip(NAMES, best.tolist(), strict=True))
            | fit.observability()
            | {"noise_std_nT": fit.noise * reference.strength_nT}
        )
        return Calibration(
            name=self.name,
            status=status,
            matrix=np.asarray(np.linalg.inv(axes_matrix(best))),
            parameters=parameters,
            covariance=fit.covariance,
            covariance_names=NAMES,
            history=history,
        )

    def search(self, points: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """Best (5,) and the best cost after each iteration, on points m / F (3, n)."""
        total = 1.0 if self.known_total else 0.0
        x = rng.uniform(-self.bound, self.bound, (self.population, 5))
        cost = costs(x, points, total)
        history = np.empty(self.iterations)
        for t in range(self.iterations):
            trial = self.trial(x, rng)
            new = costs(trial, points, total)
            better = new <= cost
            x[better], cost[better] = trial[better], new[better]
            history[t] = cost.min()
        return x[int(cost.argmin())].copy(), history

    def trial(self, x: Array, rng: np.random.Generator) -> Array:
        """Mutants of x (k, 5) crossed with their parents; r1, r2, r3 differ from each other and from the parent."""
        k, m = x.shape
        order = rng.random((k, k))
        np.fill_diagonal(order, 2.0)
        one, two, three = np.argpartition(order, (0, 1, 2), axis=1)[:, :3].T
        mutant = x[one] + self.weight * (x[two] - x[three])
        mutant = np.where(np.abs(mutant) > self.bound, rng.uniform(-self.bound, self.bound, (k, m)), mutant)
        crossed = rng.random((k, m)) < self.crossing
        crossed[np.arange(k), rng.integers(0, m, k)] = True
        return np.asarray(np.where(crossed, mutant, x))

    def _turn_status(self, mag_nT: Array, strength_nT: float) -> Status | None:
        """Not applicable unless the measurements are those of a turn about one axis, near the sensor's z."""
        axis = thinnest_direction(mag_nT)
        wobble_nT = float(np.std((mag_nT - mag_nT.mean(axis=0)) @ axis))
        if wobble_nT > self.most_wobble * strength_nT:
            return Status(
                "not_applicable",
                (
                    f"{self.name} needs a turn about the vertical alone, and the measurements leave a plane by "
                    f"{wobble_nT:.3g} nT rms (limit {self.most_wobble * strength_nT:.3g} nT): use another method"
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


class _Linear:
    """The model linearised at a solution: Jacobian J (2n, 5) of (z, |h|), noise and covariance.

    dh = -A^-1 dA h;  residuals C-correlated with C = [[1, r], [r, 1]] in each sample, r = h_z / |h|:
    cov = (J^T J)^-1 J^T C J (J^T J)^-1 noise^2,  E |residual|^2 = noise^2 (tr C - tr (J^T J)^-1 J^T C J)
    """

    def __init__(self, points: Array, theta: Array, known_total: bool) -> None:
        inverse = np.linalg.inv(axes_matrix(theta))
        h = inverse @ points
        length = np.linalg.norm(h, axis=0)
        aim = 1.0 if known_total else float(length.mean())
        self.vertical, self.total = h[2] - h[2].mean(), length - aim
        self.jz, self.jt = np.empty((2, points.shape[1], 5))
        for k, step in enumerate(derivatives(theta)):
            dh = -inverse @ step @ h
            dt = (dh * h).sum(axis=0) / length
            self.jz[:, k], self.jt[:, k] = dh[2] - dh[2].mean(), dt if known_total else dt - dt.mean()
        self.normal = self.jz.T @ self.jz + self.jt.T @ self.jt
        cross = float(h[2].mean() / length.mean()) * self.jz.T @ self.jt
        spread = np.linalg.solve(self.normal, self.normal + cross + cross.T)
        free = 2 * points.shape[1] - (1 if known_total else 2) - float(np.trace(spread))
        self.noise = float(np.sqrt(max((self.vertical @ self.vertical + self.total @ self.total) / free, ROUNDING**2)))
        covariance = np.linalg.solve(self.normal, spread.T) * self.noise**2
        self.covariance: Array = (covariance + covariance.T) / 2

    def observability(self) -> dict[str, float]:
        """The weakest unit combination of the five, its standard deviation, and the Jacobian's condition number."""
        singular, axes = np.linalg.eigh(self.normal)
        weakest = axes[:, 0] * np.sign(axes[np.argmax(np.abs(axes[:, 0])), 0])
        std = float(np.sqrt(max(weakest @ self.covariance @ weakest, 0.0)))
        return {"condition_number": float(np.sqrt(singular[-1] / singular[0])), "weakest_std": std} | {
            f"weakest_{name}": float(w) for name, w in zip(NAMES, weakest, strict=True)
        }

    def misfit(self, strength_nT: float) -> Status | None:
        """Unobservable when the total varies by much more than z: something that is not in the model."""
        total, vertical = float(np.sqrt(np.mean(self.total**2))), float(np.sqrt(np.mean(self.vertical**2)))
        if total <= MISFIT * max(vertical, ROUNDING):
            return None
        return unobservable(
            np.array([0.0, 0.0, 1.0]),
            (
                f"the corrected total still varies by {total * strength_nT:.3g} nT rms where z varies by "
                f"{vertical * strength_nT:.3g} nT, so there are offsets or unequal scales, which a turn about the "
                "vertical alone cannot sort out"
            ),
        )

    def loose(self) -> Status | None:
        """Unobservable when a direction cosine is less certain than MAX_STD."""
        std = np.sqrt(np.diag(self.covariance))
        bad = [f"{name} ({s:.2g})" for name, s in zip(NAMES, std, strict=True) if s > MAX_STD]
        return (
            None
            if not bad
            else Status(
                "unobservable",
                (
                    f"standard deviation above {MAX_STD:g} of {', '.join(bad)}: make a whole turn, where the field has "
                    "a horizontal and a vertical part"
                ),
            )
        )

    def settled(self) -> Status:
        """Not converged when a Gauss-Newton step from the solution is longer than SETTLED standard deviations."""
        slope = self.jz.T @ self.vertical + self.jt.T @ self.total
        decrement = float(np.sqrt(slope @ np.linalg.solve(self.normal, slope))) / self.noise
        return (
            Status("ok")
            if decrement <= SETTLED
            else Status(
                "not_converged",
                f"the search ended {decrement:.2g} standard deviations from the minimum: more iterations",
            )
        )


def derivatives(theta: Array) -> list[Array]:
    """dA / d theta_k, five of (3, 3): the entry itself, and the diagonal that keeps its row at length one."""
    A, out = axes_matrix(theta), []
    for (i, j), value in zip(PLACES, theta, strict=True):
        step = np.zeros((3, 3))
        step[i, j], step[i, i] = 1.0, -value / A[i, i]
        out.append(step)
    return out
