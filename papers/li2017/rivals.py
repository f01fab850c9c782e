"""Rivals that [Li2017] cites without a figure: truncated total least squares, dot product, functional-link network.

The paper names the methods alone (its references 3, 6 and 8); what a method leaves open is said in its function.
Without eddy currents: h = M (m - b), measured m (3,), compensated h (3,), nT.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from calib.models.quadric import design, shape_matrix
from calib.models.vector import VectorData
from scenarios.arrays import Array
from scenarios.seeds import stream

SEED = 2017
KEPT = 1e-3
"""Smallest singular value kept, of the largest: below lie directions that the motion does not show."""
EPOCHS, BATCH, RATE = 60, 50, 0.02
"""Training of the network: passes over the samples, samples a step, and length of a step."""
SPHERE = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
"""The quadric of a sensor without error, from which a truncated solution departs least."""


@dataclass(frozen=True, eq=False)
class TurnedField:
    """What a rival sees: measured_nT m (n, 3), up (n, 3) the vertical in body axes, known field_enu_nT (3,).

    seed: of the order in which a network meets the samples.
    """

    measured_nT: Array
    up: Array
    field_enu_nT: Array
    seed: int = 0

    @property
    def strength_nT(self) -> float:
        """Return the known field strength F."""
        return float(np.linalg.norm(self.field_enu_nT))


@dataclass(frozen=True, eq=False)
class AffineCorrection:
    """h = M (m - b): matrix M (3, 3), offset_nT b (3,)."""

    matrix: Array
    offset_nT: Array

    def apply(self, measured_nT: Array) -> Array:
        """Return compensated fields (n, 3), nT."""
        return np.asarray((measured_nT - self.offset_nT) @ self.matrix.T)


def truncated_total(rows: Array, right: Array) -> Array:
    """Return x of rows x = right by truncated total least squares, both sides noisy ([FierroEtAl1997]).

    (rows, right) = U S V^T,  x = -V12 V22^T / |V22|^2,  V12, V22 the last singular vectors' parts of rows and right:
    as many as `rows` has singular values below KEPT of the largest, and one.
    """
    size = np.linalg.svd(rows, compute_uv=False)
    kept = int(np.count_nonzero(size > KEPT * size[0]))
    last = np.linalg.svd(np.column_stack((rows, right)), full_matrices=False)[2][kept:]
    return np.asarray(-last[:, :-1].T @ last[:, -1] / (last[:, -1] @ last[:, -1]))


def truncated_quadric(seen: TurnedField) -> AffineCorrection:
    """Return the correction by m^T A m + 2 p^T m = 1 in truncated total least squares, about the unit sphere."""
    rows = design(seen.measured_nT / seen.strength_nT)
    return _centred(SPHERE + truncated_total(rows, 1.0 - rows @ SPHERE), seen.strength_nT)


def functional_link(seen: TurnedField) -> AffineCorrection:
    """Return the correction by a functional-link network: one linear neuron on nine products of the components.

    y = w . xi(m), to be 1; w <- w + RATE mean((1 - y) xi) over BATCH samples, inputs of equal spread, from the unit
    sphere; samples in an order shuffled anew in each of EPOCHS passes. Layout and training are our choice.
    """
    rows = design(seen.measured_nT / seen.strength_nT)
    spread = np.sqrt(np.mean(rows**2, axis=0))
    inputs, weights = rows / spread, SPHERE * spread
    order = stream(SEED, seen.seed, "network")
    for _ in range(EPOCHS):
        for batch in np.array_split(order.permutation(len(rows)), max(len(rows) // BATCH, 1)):
            xi = inputs[batch]
            weights = weights + RATE * (1.0 - xi @ weights) @ xi / len(batch)
    return _centred(weights / spread, seen.strength_nT)


def _centred(theta: Array, strength_nT: float) -> AffineCorrection:
    """Return the symmetric correction of a quadric theta (9,) in units of F; the quadric says nothing of a rotation."""
    A = shape_matrix(theta)
    centre = -np.linalg.solve(A, theta[6:])
    size, axes = np.linalg.eigh(A / (1.0 + centre @ A @ centre))
    return AffineCorrection(
        np.asarray((axes * np.sqrt(np.maximum(size, 0.0))) @ axes.T), np.asarray(strength_nT * centre)
    )


def dot_product(seen: TurnedField) -> AffineCorrection:
    """Return the correction by the constant product of field and vertical, u . (M m - d) = h_up, linear in 12 unknowns.

    M and d depart least from I and 0 where the motion leaves them open. The vertical comes from the attitude, as from
    an accelerometer at rest.
    """
    m, u = seen.measured_nT / seen.strength_nT, seen.up
    rows = np.column_stack(((u[:, :, None] * m[:, None, :]).reshape(len(m), 9), -u))
    right = seen.field_enu_nT[2] / seen.strength_nT - np.sum(u * m, axis=1)
    found = np.linalg.lstsq(rows, right, rcond=KEPT)[0]
    M = np.eye(3) + found[:9].reshape(3, 3)
    return AffineCorrection(M, np.asarray(seen.strength_nT * np.linalg.solve(M, found[9:])))


RIVALS: dict[str, Callable[[TurnedField], AffineCorrection]] = {
    "truncated total least squares": truncated_quadric,
    "functional-link network": functional_link,
    "dot product": dot_product,
}


def truncated_state(data: VectorData) -> Array:
    """Return x (21,) of eq. 1 by truncated total least squares, axis by axis: (1, T, dT/dt) x_i = T_m,i - T_i."""
    rows = np.column_stack((np.ones(len(data.field_nT)), data.field_nT, data.rate_nT_s))
    size = np.linalg.norm(rows, axis=0)
    x = np.array([truncated_total(rows / size, d / np.linalg.norm(d)) for d in data.difference_nT.T])
    x = x * np.linalg.norm(data.difference_nT, axis=0)[:, None] / size
    return np.concatenate((x[:, 0], x[:, 1:4].ravel(), x[:, 4:].ravel()))
