"""Change of an instrument since its calibration, estimated from a log that the calibration corrects.

u_i = (I + E) h_i + d + sum_j k_j I_ij + noise,  u the field as the old calibration corrects it, h the Earth's

Nothing has changed where d, E and k are zero. With the strength alone |h| = F: E is symmetric (a turn of the sensor is
not seen), and a residual is the distance from the surface. With attitude and field vector E is full.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from calib import Calibration, Reference, Status, get
from calib.acceptance import CorrectedField, widened
from calib.held_out.legs import legs_of
from calib.models.ellipsoid import SYMMETRIC_NAMES, SYMMETRIC_SLOTS
from calib.models.vector import SOFT_IRON_NAMES
from calib.numerics.points import lengths
from calib.numerics.rates import world_to_body
from calib.result import OFFSET_NAMES
from recordings import Recording
from scenarios.arrays import Array
from validation.cross_validation.claimed_std import claim_of
from validation.rechecking.noise import WanderingFit, larger

LARGEST = 0.5
"""Standard deviation of d, E and k before the log is looked at, in units of the field: what a motion does not determine
stays this uncertain, so that nothing is excluded there."""
STEPS, SETTLED = 30, 1e-6
"""Gauss-Newton steps at most, and step over the field at which the estimate has settled."""
LEAST_NOISE = 1e-9
"""Least noise over the field; smaller residuals are rounding."""
AXES = "xyz"


@dataclass(frozen=True, eq=False)
class ChangeEstimate:
    """Estimate of (d, F E, k_j times the largest current), nT, with covariance; the old calibration's is not in it.

    values (p,), covariance (p, p); slots (m, 3, 3) of E's entries; mean_currents (motors,): over the largest; motors :
    their numbers and largest currents, A; leftover_nT : rms of what the model leaves.
    """

    values: Array
    covariance: Array
    slots: Array
    strength_nT: float
    motors: tuple[tuple[int, float], ...] = ()
    mean_currents: Array | None = None
    leftover_nT: float = 0.0

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
    covariance = _honest(problem, values, covariance, replace(used, mag_nT=static), misfit, reference)
    covariance = _with_wandering(problem, values, covariance)
    rms = float(np.sqrt(np.mean(misfit**2)))
    return ChangeEstimate(values, covariance, problem.slots, reference.strength_nT, named, means, rms)


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
    F, p = problem.strength_nT, problem.size
    prior = np.full(p, (LARGEST * F) ** -2)
    for _ in range(STEPS):
        misfit, J, static = problem.linear(values)
        rows, flat = J.reshape(-1, p), misfit.ravel()
        noise_nT2 = float(flat @ flat) / max(len(flat) - p, 1) + (LEAST_NOISE * F) ** 2
        covariance = np.asarray(np.linalg.inv(rows.T @ rows / noise_nT2 + np.diag(prior)), dtype=np.float64)
        step = covariance @ (rows.T @ flat / noise_nT2 - prior * values)
        if not np.isfinite(step).all() or np.abs(step).max() < SETTLED * F:
            break
        values = values + step * min(1.0, LARGEST * F / np.abs(step).max())
    return values, covariance, misfit, static


def _honest(
    problem: _Problem,
    values: Array,
    covariance: Array,
    static: Recording,
    misfit: Array,
    reference: Reference,
) -> Array:
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
    return np.asarray(factor * claimed.covariance * np.outer(unit, unit))


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


def _with_wandering(problem: _Problem, values: Array, covariance: Array) -> Array:
    """Return the covariance, enlarged where noise wanders, on the sensor's axes or in the field's strength."""
    misfit, J, _ = problem.linear(values)
    prior = np.eye(problem.size) * float(np.mean(misfit**2)) / (LARGEST * problem.strength_nT) ** 2
    across = J[:, :, :3]
    ways = [across] if problem.known is not None else [across, np.ones((*misfit.shape, 1))]
    for a in ways:
        covariance = larger(covariance, WanderingFit(J, a, misfit).covariance(prior))
    return covariance


def of_old(old: Calibration, estimate: ChangeEstimate) -> Array:
    """Return the old calibration's claimed covariance as one of the change's values (p, p); zero without a claim.

    d = -A db,  E = -A dS, of which the strength sees the symmetric half
    """
    p = len(estimate.values)
    if old.covariance is None:
        return np.zeros((p, p))
    moved = np.array([_moved(name, old.matrix, estimate) for name in old.covariance_names])
    return np.asarray(moved.T @ old.covariance @ moved)


def _moved(name: str, A: Array, estimate: ChangeEstimate) -> Array:
    """Return d values / d a parameter of the old calibration (p,)."""
    found = np.zeros(len(estimate.values))
    if name in OFFSET_NAMES:
        found[:3] = -A[:, OFFSET_NAMES.index(name)]
        return found
    dS = np.zeros((3, 3))
    if name == "scale":
        dS = np.eye(3)
    elif name in SOFT_IRON_NAMES:
        i, j = AXES.index(name[2]), AXES.index(name[3])
        dS[i, j] = 1.0
    E = -A @ dS * estimate.strength_nT
    if estimate.entries == 9:
        found[3:12] = E.ravel()
    else:
        found[3:9] = ((E + E.T) / 2)[np.triu_indices(3)]
    return found
