"""Strength and dip: the field's length and its component along gravity's direction.

u = T (x - c),  T = S^-1:  |u| = 1,  a . u = sin I

x (n, 3) measurements in units of F; a (n, 3) unit vectors up, from the specific force; I the field's angle above the
horizon. Coordinates of the fit: theta = (c, entries of T, I), (3 + k + 1,).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from calib.numerics.colour import inflation
from scenarios.arrays import Array

MOST_STEPS = 30
"""Evaluations of a round at most: a fit that moves on is not determined."""
LEAST_NOISE = 1e-9
"""Noise of recordings that show less, in units of F."""


class _Deviations(NamedTuple):
    """Of samples (n,): u, |u|, a . u, v, w, v . v, v . w, r_1 and r_2 before their division by a standard deviation,
    and the variance of r_2; T (3, 3)."""

    T: Array
    u: Array
    size: Array
    towards: Array
    v: Array
    w: Array
    vv: Array
    vw: Array
    strength: Array
    rest: Array
    own: Array


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
        at = self._at(theta)
        return np.concatenate((at.strength / (self.noise * np.sqrt(at.vv)), at.rest / np.sqrt(at.own)))

    def _at(self, theta: Array) -> _Deviations:
        """Deviations at theta with the parts of their variances."""
        centre, T, inclination = self.parts(theta)
        u = (self.x - centre) @ T.T
        size = np.linalg.norm(u, axis=1)
        towards = np.einsum("ni,ni->n", self.up, u)
        v, w = u / size[:, None] @ T, self.up @ T
        vv, vw, ww = (np.einsum("ni,ni->n", one, other) for one, other in ((v, v), (v, w), (w, w)))
        strength, dip = size - 1.0, towards - np.sin(inclination)
        own = self.noise**2 * (ww - vw**2 / vv) + self.dip_noise**2 * (size**2 - towards**2)
        return _Deviations(T, u, size, towards, v, w, vv, vw, strength, dip - vw / vv * strength, own)

    def slopes(self, theta: Array) -> Array:
        """Derivatives (2 n, p) of the residuals, of a r_1 = |u| - 1 and b r_2 with their standard deviations a and b.

        dr_1 = (d|u| - (|u| - 1) v . dv / |v|^2) / a,  dr_2 = (d(b r_2) - b r_2 d(b^2) / (2 b^2)) / b
        """
        at = self._at(theta)
        du, dv, dw = self._vector_slopes(theta, at)
        d_size = np.einsum("ni,pni->pn", at.u / at.size[:, None], du)
        d_towards = np.einsum("ni,pni->pn", self.up, du)
        half_vv, half_ww = np.einsum("ni,pni->pn", at.v, dv), np.einsum("ni,pni->pn", at.w, dw)
        share = at.vw / at.vv
        d_vw = np.einsum("ni,pni->pn", at.w, dv) + np.einsum("ni,pni->pn", at.v, dw)
        half_own = self.noise**2 * (half_ww - share * d_vw + share**2 * half_vv)
        half_own += self.dip_noise**2 * (at.size * d_size - at.towards * d_towards)
        d_rest = d_towards - share * d_size - (d_vw - 2.0 * share * half_vv) / at.vv * at.strength
        if self.inclination_rad is None:
            d_rest[-1] = -np.cos(theta[-1])
        first = (d_size - at.strength * half_vv / at.vv) / (self.noise * np.sqrt(at.vv))
        second = (d_rest - at.rest * half_own / at.own) / np.sqrt(at.own)
        return np.concatenate((first, second), axis=1).T

    def _vector_slopes(self, theta: Array, at: _Deviations) -> tuple[Array, Array, Array]:
        """Derivatives (p, n, 3) of u, v and w."""
        centre, k = theta[:3], len(self.slots)
        du, dv, dw = np.zeros((3, len(theta), len(self.x), 3))
        du[:3] = -at.T.T[:, None]
        du[3 : 3 + k] = (self.x - centre) @ self.slots.transpose(0, 2, 1)
        unit = at.u / at.size[:, None]
        across = du - np.einsum("ni,pni->pn", unit, du)[..., None] * unit
        dv[:] = across / at.size[:, None] @ at.T
        dv[3 : 3 + k] += unit @ self.slots
        dw[3 : 3 + k] = self.up @ self.slots
        return du, dv, dw

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
                samples.residuals, theta, samples.slopes, method="lm", x_scale="jac", max_nfev=MOST_STEPS
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
