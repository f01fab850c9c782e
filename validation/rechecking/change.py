"""Change of an instrument since its calibration, estimated from a log that the calibration corrects.

u_i = (I + E) h_i + d + sum_j k_j I_ij + noise,  u the field as the old calibration corrects it, h the Earth's

Nothing has changed where d, E and k are zero. With the strength alone |h| = F: E is symmetric (a turn of the sensor is
not seen), and a residual is the distance from the surface. With attitude and field vector E is full.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib import Calibration, Reference, Status, get
from calib.acceptance import CorrectedField, widened
from calib.held_out.legs import legs_of
from calib.models.ellipsoid import SYMMETRIC_NAMES, SYMMETRIC_SLOTS
from calib.models.vector import SOFT_IRON_NAMES
from calib.numerics.colour import few_factor, inflation
from calib.numerics.points import lengths
from calib.numerics.rates import world_to_body
from calib.observability import MAX_STD_FRACTION
from calib.result import OFFSET_NAMES
from recordings import Recording
from scenarios.arrays import Array
from validation.cross_validation.claimed_std import claim_of
from validation.rechecking.noise import WanderingFit, WeightedCovariances, larger

LARGEST = 0.5
"""Standard deviation of d, E and k before the log is looked at, in units of the field: what a motion does not determine
stays this uncertain, so that nothing is excluded there."""
STEPS, SETTLED = 30, 1e-6
"""Gauss-Newton steps at most, and step over the field at which the estimate has settled."""
LEAST_NOISE = 1e-9
"""Least noise over the field; smaller residuals are rounding."""


@dataclass(frozen=True, eq=False)
class ChangeEstimate:
    """Estimate of (d, F E, k_j times the largest current), nT, with covariance; the old calibration's is not in it.

    values (p,); spread : covariances (p, p) by models of the noise; mean_currents (motors,): over the largest; motors :
    their numbers and largest currents, A; leftover_nT : rms of what the model leaves; shortfall (models,) : by how much
    the claim of a calibrator, for the same noise, is too small.
    """

    problem: _Problem
    values: Array
    spread: WeightedCovariances
    shortfall: Array
    motors: tuple[tuple[int, float], ...] = ()
    mean_currents: Array | None = None
    leftover_nT: float = 0.0

    @property
    def covariance(self) -> Array:
        """Return the covariance (p, p) over all models of the noise."""
        return self.spread.mean

    @property
    def slots(self) -> Array:
        """Return the places (m, 3, 3) of E's entries."""
        return self.problem.slots

    @property
    def strength_nT(self) -> float:
        """Return the field's strength."""
        return self.problem.strength_nT

    @cached_property
    def from_none(self) -> ChangeEstimate | None:
        """Return the estimate linear about no change, to test for none; None where the motion separates the parts."""
        return None if self.separated else _about_none(self)

    @property
    def separated(self) -> bool:
        """Return whether the motion determines offset and soft iron each, as an accepted calibration does."""
        both = slice(0, 3 + self.entries)
        worst_nT2 = float(np.linalg.eigvalsh(self.covariance[both, both])[-1])
        return worst_nT2 < (MAX_STD_FRACTION * self.strength_nT) ** 2

    @property
    def entries(self) -> int:
        """Return the number of E's entries: 6 by the strength, 9 by vectors."""
        return len(self.slots)

    def error_columns(self, field_unit: Array) -> Array:
        """Return d e / d values (q, 3, p) of the error e = E h + d + sum k I at mean currents, for h / F (q, 3)."""
        q = len(field_unit)
        turned = np.einsum("mab,qb->qam", self.slots, field_unit)
        parts = [np.broadcast_to(np.eye(3), (q, 3, 3)), turned]
        if self.mean_currents is not None:
            parts += [np.broadcast_to(mean * np.eye(3), (q, 3, 3)) for mean in self.mean_currents]
        return np.concatenate(parts, axis=2)


@dataclass(frozen=True, eq=False)
class _Problem:
    """Corrected field u (n, 3) and known directions h / F (n, 3) or None, currents (n, motors) over the largest."""

    u: Array
    known: Array | None
    currents: Array
    slots: Array
    strength_nT: float

    @property
    def size(self) -> int:
        return 3 + len(self.slots) + 3 * int(self.currents.shape[1])

    def linear(self, values: Array) -> tuple[Array, Array, Array]:
        """Return residuals (n, r), columns (n, r, p), and the static field u - d - k I (n, 3)."""
        split = 3 + len(self.slots)
        motors = values[split:].reshape(-1, 3)
        static = self.u - values[:3] - self.currents @ motors
        S = np.eye(3) + np.tensordot(values[3:split], self.slots, 1) / self.strength_nT
        h, normal = (self.known, None) if self.known is not None else _projected(static, S)
        misfit = static - self.strength_nT * h @ S.T
        across = np.broadcast_to(np.eye(3), (len(h), 3, 3)) if normal is None else normal[:, None, :]
        turned = np.einsum("mab,nb->nam", self.slots, h)
        columns = [across, across @ turned, *(across * one[:, None, None] for one in self.currents.T)]
        return (across @ misfit[:, :, None])[:, :, 0], np.concatenate(columns, axis=2), static


def _projected(static: Array, S: Array) -> tuple[Array, Array]:
    """Return directions h / F (n, 3) and the surface's normals (n, 3)."""
    inverse = np.linalg.inv(S)
    h = static @ inverse.T
    h /= lengths(h)[:, None]
    normal = h @ inverse
    return h, normal / lengths(normal)[:, None]


def estimate_change(
    corrected: Recording, reference: Reference, *, vector: bool = False, motors: bool = True
) -> ChangeEstimate:
    """Estimate the change from a recording whose field the old calibration corrects.

    vector : by attitude and field vector, else by the strength alone. motors : with a term for each motor current.
    The covariance is widened for residuals that are not white as a calibrator's claim, and by the ratio of scatter to
    claim where the legs contradict it.
    """
    start = get("ellipsoid").fit(corrected, reference)
    used = start.used(corrected)
    problem, named, means = _posed(used, reference, vector, motors)
    values = np.zeros(problem.size)
    if start.status.kind == "ok" and not vector:
        S = np.linalg.inv(start.matrix)
        values[:3] = start.offset_nT
        values[3:9] = reference.strength_nT * (S - np.eye(3))[np.triu_indices(3)]
    values, covariance, misfit, static = _solved(problem, values)
    claimed, scattered = _honest(problem, values, covariance, replace(used, mag_nT=static), misfit, reference)
    misfit, J, _ = problem.linear(values)
    spread = _with_wandering(problem, J, misfit, scattered)
    rms = float(np.sqrt(np.mean(misfit**2)))
    shortfall = _shortfall(claimed, spread)
    return ChangeEstimate(problem, values, spread, shortfall, named, means, rms)


def _posed(
    used: Recording, reference: Reference, vector: bool, motors: bool
) -> tuple[_Problem, tuple[tuple[int, float], ...], Array | None]:
    known = None
    if vector:
        assert used.att_q is not None
        assert reference.field_enu_nT is not None
        known = world_to_body(used.att_q, np.array(reference.field_enu_nT)) / reference.strength_nT
    slots = np.eye(9).reshape(9, 3, 3) if vector else SYMMETRIC_SLOTS
    currents = np.zeros((len(used), 0))
    named: tuple[tuple[int, float], ...] = ()
    if motors and used.current_A is not None:
        largest = np.abs(used.current_A).max(axis=0)
        flows = (largest > 0) & np.isfinite(largest)
        currents = used.current_A[:, flows] / largest[flows]
        numbers = np.array(used.motors)[flows]
        named = tuple((int(n), float(a)) for n, a in zip(numbers, largest[flows], strict=True))
    means = currents.mean(axis=0) if named else None
    return _Problem(used.mag_nT, known, currents, slots, reference.strength_nT), named, means


def _solved(problem: _Problem, values: Array) -> tuple[Array, Array, Array, Array]:
    """Return values, covariance for white noise, residuals (n, r) and static field, by Gauss-Newton with the prior."""
    F = problem.strength_nT
    for _ in range(STEPS):
        misfit, J, static = problem.linear(values)
        step, covariance = _step(problem, J, misfit, misfit, values)
        if not np.isfinite(step).all() or np.abs(step).max() < SETTLED * F:
            break
        values = values + step * min(1.0, LARGEST * F / np.abs(step).max())
    return values, covariance, misfit, static


def _step(problem: _Problem, J: Array, misfit: Array, noise: Array, values: Array) -> tuple[Array, Array]:
    """Return the step of the values, and their covariance for white noise of the power of `noise` (n, r)."""
    F, p = problem.strength_nT, problem.size
    prior = np.full(p, (LARGEST * F) ** -2)
    rows = J.reshape(-1, p)
    noise_nT2 = float(np.sum(noise**2)) / max(noise.size - p, 1) + (LEAST_NOISE * F) ** 2
    covariance = np.asarray(np.linalg.inv(rows.T @ rows / noise_nT2 + np.diag(prior)), dtype=np.float64)
    return covariance @ (rows.T @ misfit.ravel() / noise_nT2 - prior * values), covariance


def _about_none(found: ChangeEstimate) -> ChangeEstimate:
    """Return the estimate by one step from no change, where the columns are taken.

    A test of no change holds with these however far the estimate itself may lie off, since the columns are those of the
    unchanged instrument.
    """
    problem = found.problem
    misfit, J, _ = problem.linear(np.zeros(problem.size))
    values, _ = _step(problem, J, misfit, misfit - J @ found.values, np.zeros(problem.size))
    left = misfit - J @ values
    _, covariance = _step(problem, J, misfit, left, values)
    covariance = covariance * inflation(left) * few_factor(left.size - problem.size)
    spread = _with_wandering(problem, J, left, covariance)
    return replace(found, values=values, spread=spread, shortfall=_shortfall(covariance, spread))


def _honest(
    problem: _Problem,
    values: Array,
    covariance: Array,
    static: Recording,
    misfit: Array,
    reference: Reference,
) -> tuple[Array, Array]:
    """Return the covariance as a calibrator claims it, and as far as the legs bear that out."""
    F, m = problem.strength_nT, len(problem.slots)
    vector = problem.known is not None
    entries = SOFT_IRON_NAMES if vector else SYMMETRIC_NAMES
    extra = tuple(f"motor_{k}" for k in range(problem.size - 3 - m))
    unit = np.ones(problem.size)
    unit[3 : 3 + m] = F
    fit = _as_fit(problem, values, covariance / np.outer(unit, unit), (*OFFSET_NAMES, *entries, *extra))
    static = replace(static, mag_nT=static.mag_nT + values[:3])
    field = CorrectedField(fit, static, F)
    claimed = widened(fit, misfit if vector else misfit[:, 0], field, reference, vector=vector)
    assert claimed.covariance is not None
    claim = claim_of(claimed, static, reference, legs_of(static))
    factor = claim.ratio**2 if claim is not None and claim.ratio > claim.limit else 1.0
    whole = np.asarray(claimed.covariance * np.outer(unit, unit))
    return whole, factor * whole


def _as_fit(problem: _Problem, values: Array, covariance: Array, names: tuple[str, ...]) -> Calibration:
    """Return the change as a calibration of the corrected field."""
    E = np.tensordot(values[3 : 3 + len(problem.slots)], problem.slots, 1) / problem.strength_nT
    return Calibration(
        name="recheck",
        status=Status("ok"),
        offset_nT=values[:3],
        matrix=np.asarray(np.linalg.inv(np.eye(3) + E)),
        covariance=covariance,
        covariance_names=names,
    )


def _with_wandering(problem: _Problem, J: Array, misfit: Array, covariance: Array) -> WeightedCovariances:
    """Return the covariance, enlarged where noise wanders, on the sensor's axes or in the field's strength."""
    prior = np.eye(problem.size) * float(np.mean(misfit**2)) / (LARGEST * problem.strength_nT) ** 2
    across = J[:, :, :3]
    ways = [across] if problem.known is not None else [across, np.ones((*misfit.shape, 1))]
    found = WanderingFit(J, misfit, ways).covariances(prior)
    return WeightedCovariances(found.weights, np.array([larger(covariance, one) for one in found.covariances]))


def _shortfall(claimed: Array, spread: WeightedCovariances) -> Array:
    """Return the mean ratio of each covariance to a claim, at least 1."""
    inverse = np.linalg.pinv(claimed, hermitian=True)
    return np.asarray((np.einsum("pq,kqp->k", inverse, spread.covariances) / len(claimed)).clip(1.0))
