"""Strength and dip: the field's length and its component along gravity's direction.

u = T (x - c),  T = S^-1:  |u| = 1,  a . u = sin I

x (n, 3) measurements in units of F; a (n, 3) unit vectors up, from the specific force; I the field's angle above the
horizon. Coordinates of the fit: theta = (c, entries of T, I), (3 + k + 1,).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from calib.numerics.colour import inflation
from scenarios.arrays import Array

MOST_STEPS = 30
"""Steps of a round at most: a fit that moves on is not determined."""
LEAST_NOISE = 1e-9
"""Noise of recordings that show less, in units of F."""


@dataclass(frozen=True, eq=False)
class DipSamples:
    """Samples x, a (n, 3) in order of time, and the standard deviations of the residuals of strength and dip.

    slots (k, 3, 3) : dT / d each entry. inclination_rad : I where known, else None.
    """

    x: Array
    up: Array
    slots: Array
    inclination_rad: float | None
    noise: float
    dip_noise: float

    def start(self) -> Array:
        """Theta for S = 1 from equations linear in c: |x|^2 = 2 x . c + 1 - |c|^2 and a . x = a . c + sin I."""
        n = len(self.x)
        strength = np.column_stack((2 * self.x, np.ones(n), np.zeros(n)))
        dip = np.column_stack((self.up, np.zeros(n), np.ones(n)))
        sums = np.concatenate((np.sum(self.x**2, axis=1), np.einsum("ni,ni->n", self.up, self.x)))
        found = np.linalg.lstsq(np.concatenate((strength, dip)), sums, rcond=None)[0]
        entries = np.einsum("pij,ij->p", self.slots, np.eye(3)) / np.einsum("pij,pij->p", self.slots, self.slots)
        inclination = [] if self.inclination_rad is not None else [np.arcsin(np.clip(found[4], -0.99, 0.99))]
        return np.array([*found[:3], *entries, *inclination])

    def parts(self, theta: Array) -> tuple[Array, Array, float]:
        """Centre c (3,), T (3, 3) and I of theta."""
        last = theta[-1] if self.inclination_rad is None else self.inclination_rad
        return theta[:3], np.tensordot(theta[3 : 3 + len(self.slots)], self.slots, 1), float(last)

    def residuals(self, theta: Array) -> Array:
        """Residuals (2 n,) of strength and dip, independent and of unit variance for the right noises.

        r_1 = |u| - 1 and r_2 = a . u - sin I vary by the noise n of x and the noise d of a, across a:

        r_1 = v . n,  v = T' u / |u|;  r_2 = w . n + u . d,  w = T' a

        so that r_2 is taken less its regression on r_1. Variances depend on theta: this is the likelihood of all
        directions to first order, without the bias of a regression on noisy values. [Kanatani1994]
        """
        centre, T, inclination = self.parts(theta)
        u = (self.x - centre) @ T.T
        size = np.linalg.norm(u, axis=1)
        towards = np.einsum("ni,ni->n", self.up, u)
        v, w = u / size[:, None] @ T, self.up @ T
        vv, vw, ww = (np.einsum("ni,ni->n", one, other) for one, other in ((v, v), (v, w), (w, w)))
        strength, dip = size - 1.0, towards - np.sin(inclination)
        own = self.noise**2 * (ww - vw**2 / vv) + self.dip_noise**2 * (size**2 - towards**2)
        return np.concatenate((strength / (self.noise * np.sqrt(vv)), (dip - vw / vv * strength) / np.sqrt(own)))

    def with_noises(self, residuals: Array) -> DipSamples:
        """The samples with the standard deviations that the residuals (2 n,) show; that of the dip as of white noise.

        Accelerations of the vehicle are not white: the standard deviation of the dip is that of white noise whose means
        over blocks scatter as much, see `calib.numerics.colour`.
        """
        strength, dip = np.split(residuals, 2)
        freedom = len(strength) / (len(strength) - len(self.slots) - 3)
        noise = self.noise * float(np.sqrt(freedom * np.mean(strength**2)))
        dip_noise = self.dip_noise * float(np.sqrt(np.mean(dip**2) * inflation(dip)))
        return replace(self, noise=max(noise, LEAST_NOISE), dip_noise=max(dip_noise, LEAST_NOISE))


@dataclass(frozen=True, eq=False)
class DipFit:
    """Minimum theta (p,) and covariance (p, p) with the samples and noises at the minimum; cost of each round."""

    samples: DipSamples
    theta: Array
    covariance: Array
    settled: bool
    history: tuple[float, ...]

    @classmethod
    def of(cls, samples: DipSamples, rounds: int, tolerance: float) -> DipFit:
        """Weighted least squares and noises in turn, until the logarithms of the noises change by less than tolerance.

        Raises LinAlgError where the motion leaves parameters undetermined.
        """
        theta, change, history = samples.start(), np.inf, []
        for _ in range(rounds):
            found = least_squares(
                samples.residuals, theta, method="lm", x_scale="jac", max_nfev=MOST_STEPS * len(theta)
            )
            theta = found.x
            history.append(float(found.cost))
            again = samples.with_noises(found.fun)
            ratios = again.noise / samples.noise, again.dip_noise / samples.dip_noise
            change = float(np.abs(np.log(ratios)).max())
            samples = again
            if change < tolerance:
                break
        slopes = found.jac
        scale = np.linalg.norm(slopes, axis=0)
        inverse = np.linalg.inv((slopes / scale).T @ (slopes / scale))
        covariance = inverse / np.outer(scale, scale)
        return cls(samples, theta, covariance, change < tolerance and bool(found.success), tuple(history))
