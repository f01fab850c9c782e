"""Position search for a dipole near the path: coarse grid on thinned samples, then refinement of the best starts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.kernels import kernel

MEAN_S, MOST_MEANS = 0.5, 3000
"""Averaging time, and number of means in the search at most: cost, not a decision."""
SAME_M = 0.1
"""Distance below which two refined positions are equal."""
LEAST_M = 0.02
"""Distance below which the dipole field is held constant, so that no start is infinite."""
STEP_M = 5.0
"""First step of the refinement, at most a fifth of the path's extent."""


def find_places(problem: LinearProblem, residual: Array, candidate: Candidate, name: str) -> list[Candidate]:
    """The candidate at positions of a dipole that fit a residual (n, q) best."""
    thin = ThinnedPath.of(problem, residual)
    grid = thin.grid()
    left = [float((thin.residual(place) ** 2).sum()) for place in grid]
    found: list[Array] = []
    for start in grid[np.argsort(left)[: problem.policy.place_starts]]:
        place = thin.best_near(start)
        if thin.is_beside(place) and all(float(((place - other) ** 2).sum()) > SAME_M**2 for other in found):
            found.append(place)
    return [candidate.at({name: tuple(map(float, place))}, len(grid)) for place in found]


@dataclass(frozen=True)
class ThinnedPath:
    """A problem on thinned samples for the position search.

    path (n, 3); to_sensor (n, 3, 3): from the Earth's frame to the sensor, over the noise; y (3 n,): residual
    orthogonal to the base; Q (n, p): orthonormal columns of the base.
    """

    path: Array
    to_sensor: Array
    y: Array
    Q: Array
    policy: Policy

    @classmethod
    def of(cls, problem: LinearProblem, residual: Array) -> ThinnedPath:
        """Means of a residual (n, 3), at most MOST_MEANS, as samples of a smaller problem."""
        n = len(residual)
        length = max(1, round(MEAN_S / problem.state.interval_s), -(-n // MOST_MEANS))
        cut = Cut(length, n // length)
        middle = np.arange(cut.m) * length + length // 2
        R_bw = problem.state.R_wb[middle].transpose(0, 2, 1)
        to_sensor = np.ascontiguousarray((problem.turn / problem.sigma_nT[:, None]) @ R_bw)
        Q, y = np.linalg.qr(cut.means(problem.base))[0], cut.means(residual)
        return cls(problem.state.pos_enu_m[middle], to_sensor, (y - Q @ (Q.T @ y)).ravel(), Q, problem.policy)

    @cached_property
    def extent_m(self) -> float:
        """Longest side of the path's bounding box."""
        return float(np.ptp(self.path, axis=0).max())

    def grid(self) -> Array:
        """Grid positions (m, 3) around the path, neither on the path nor so far that the field is a uniform gradient.

        A second grid scaled to the path is added where the path's extent differs much from the first grid's: aerial
        surveys, hand-held sensors. A third grid covers the section with the middle half of the residual's fourth power,
        in which noise counts little: a near body there could lie between the other cells. The section, extended by a
        sample on each side, is about a third as long as the distance of a dipole.
        """
        policy = self.policy
        boxes = [(self.path, policy.place_margin_m)]
        own, ratio = policy.other_place * self.extent_m, policy.other_scale
        if not 1 / ratio < own / policy.place_margin_m < ratio:
            boxes.append((self.path, own))
        power = np.cumsum((self.y.reshape(-1, 3) ** 2).sum(axis=1) ** 2)
        first, last = np.searchsorted(power, power[-1] * np.array([0.25, 0.75]))
        loudest = self.path[max(first - 1, 0) : last + 2]
        about = policy.about_stretch * float(np.ptp(loudest, axis=0).max())
        if ratio * about < self.extent_m:
            boxes.append((loudest, about))
        grid = np.concatenate([_box(path, margin_m, policy) for path, margin_m in boxes])
        return grid[[self.is_beside(place) for place in grid]]

    def is_beside(self, place: Array) -> bool:
        """Whether a position is neither on the path nor too far, relative to the path's extent where extreme."""
        policy, apart_m = self.policy, self.path - place
        distance_m = np.sqrt(np.einsum("ni,ni->n", apart_m, apart_m).min())
        nearest_m = min(policy.nearest_place_m, policy.nearest_share * self.extent_m)
        return bool(nearest_m < distance_m < max(policy.farthest_place_m, policy.farthest_share * self.extent_m))

    def residual(self, place: Array) -> Array:
        """Residual (3 n,) after the best dipole moment at a position."""
        E = _unit_dipoles(self.path, place, self.to_sensor).reshape(len(self.path), 9)
        flat = (E - self.Q @ (self.Q.T @ E)).reshape(-1, 3)
        c = np.linalg.lstsq(flat.T @ flat, flat.T @ self.y, rcond=1e-12)[0]
        return np.asarray(self.y - flat @ c)

    def best_near(self, start: Array) -> Array:
        """Least-squares position near a start (variable projection)."""
        step_m = min(STEP_M, self.extent_m / 5)
        return np.asarray(least_squares(self.residual, start, x_scale=step_m, max_nfev=25, diff_step=1e-4).x)


def _box(path: Array, margin_m: float, policy: Policy) -> Array:
    """Even grid (m, 3) on the bounding box of a path (n, 3) with a margin."""
    low, high, least = path.min(axis=0) - margin_m, path.max(axis=0) + margin_m, policy.place_cells
    cells = [max(least, min(2 * least, round((b - a) / policy.place_cell_m))) for a, b in zip(low, high, strict=True)]
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, cells, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


@kernel
def _unit_dipoles(path: Array, place: Array, to_sensor: Array) -> Array:
    """Field (n, 3, 3) of unit moments: ``100 (3 r r^T / r^5 - I / r^3)`` nT, in sensor axes over the noise."""
    out = np.empty((len(path), 3, 3))
    for i in range(len(path)):
        x, y, z = path[i, 0] - place[0], path[i, 1] - place[1], path[i, 2] - place[2]
        r = max(np.sqrt(x * x + y * y + z * z), LEAST_M)
        far, near = 300.0 / r**5, 100.0 / r**3
        for a in range(3):
            T = to_sensor[i, a]
            along = far * (T[0] * x + T[1] * y + T[2] * z)
            out[i, a, 0] = along * x - near * T[0]
            out[i, a, 1] = along * y - near * T[1]
            out[i, a, 2] = along * z - near * T[2]
    return out
