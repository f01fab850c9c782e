"""Least squares of states linked by a gyro from sample to sample, together with common parameters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from calib.numerics.chain import eliminated, states
from calib.numerics.damped import NormalEquations
from scenarios.arrays import Array

BIAS = 3
"""Components of the gyro's bias, the last of the parameters."""
LOOSE = 1e6
"""Standard deviation, rad, of a step that the gyro says nothing of: across a gap."""
STATE_ROUNDS, STATE_SETTLED = 5, 1e-6
"""Most rounds of the states at fixed parameters, and the share of the cost by which the last may still gain."""


class ChainedParameters(Protocol):
    """What an estimate of any kind of state holds: offset c (3,), root G (3, 3), gyro's bias (3,), rad/s."""

    @property
    def centre(self) -> Array: ...
    @property
    def root(self) -> Array: ...
    @property
    def bias_rad_s(self) -> Array: ...


E = TypeVar("E", bound=ChainedParameters)


@dataclass(frozen=True, eq=False)
class Linear(Generic[E]):
    """The least squares about an estimate, linear in the local coordinates of the states and in the parameters.

    cost at the estimate; square (k + 1, k + 1) of the parameters with the residual last, the states optimal; log det of
    the states' information. The remaining fields map parameters back to states.
    """

    estimate: E
    turn: Array
    B: Array
    std: Array
    cost: float
    square: Array
    logarithm: float
    A: Array
    C: Array

    def states(self, step: Array) -> Array:
        """The best states (n, m) a step (k,) of the parameters further."""
        return np.asarray(states(self.A, self.C, self.turn, self.B, self.std, np.append(step, 1.0)))

    @property
    def least(self) -> float:
        """The cost at the estimate's parameters with the states at their best."""
        return max(float(self.square[-1, -1]), 0.0)


class Chained(ABC, Generic[E]):
    """A recording with linked states; a subclass defines the states and the measurements.

    Parameters p (k,): offset, entries of G, further parameters, the gyro's bias.
    """

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of parameters."""

    @property
    @abstractmethod
    def std(self) -> Array:
        """Standard deviation (n - 1,) of each step's turn, rad, over the noise of a measurement."""

    @abstractmethod
    def measured(self, e: E) -> tuple[Array, Array]:
        """M (n, r, m), derivative of the measurements by the states (magnetometer first), and J (n, r, k + 1).

        The last column of J is the residual. All in units of the magnetometer's noise.
        """

    @abstractmethod
    def linked(self, e: E) -> tuple[Array, Array]:
        """turn (n - 1, m, m) and B (n - 1, m, k + 1): propagation of a state by the gyro; last column: the residual."""

    @abstractmethod
    def beforehand(self, e: E) -> Array:
        """Prior knowledge of the parameters as rows (q, k + 1), in the form of J."""

    @abstractmethod
    def followed(self, e: E, x: Array) -> E:
        """The estimate with its states moved by x (n, m)."""

    @abstractmethod
    def changed(self, e: E, step: Array) -> E | None:
        """The estimate with its parameters a step further; None where G turns inside out."""

    @abstractmethod
    def variance(self, found: Linear[E]) -> float:
        """Of the magnetometer's noise."""

    def linear(self, e: E) -> Linear[E]:
        """The least squares about an estimate."""
        M, J = self.measured(e)
        turn, B = self.linked(e)
        std, known = self.std, self.beforehand(e)
        cost = np.sum(J[:, :, -1] ** 2) + np.sum((B[:, :, -1] / std[:, None]) ** 2) + np.sum(known[:, -1] ** 2)
        square, logarithm, A, C = eliminated(M, J, turn, B, std)
        return Linear(e, turn, B, std, float(cost), square + known.T @ known, logarithm, A, C)

    def settled(self, e: E) -> Linear[E]:
        """The estimate with optimal states, and the least squares about the estimate."""
        found = self.linear(e)
        for _ in range(STATE_ROUNDS):
            if found.least >= (1.0 - STATE_SETTLED) * found.cost:
                break
            found = self.linear(self.followed(found.estimate, found.states(np.zeros(self.count))))
        return found

    def normal(self, found: Linear[E]) -> NormalEquations:
        """Cost and normal equations of p, each state at its best."""
        return NormalEquations(found.least, found.square[:-1, -1], found.square[:-1, :-1], self.variance(found))

    def moved(self, found: Linear[E], step: Array) -> Linear[E] | None:
        """The parameters a step further and the states that follow; None where G turns inside out."""
        changed = self.changed(self.followed(found.estimate, found.states(step)), step)
        return None if changed is None else self.settled(changed)

    def response(self, found: Linear[E]) -> Array:
        """How each measurement of the field moves the parameters, to first order, states following: (n, k, 3).

        square^-1 (J_i + M_i xi_i)^T,  xi_i (m, k) the states that follow the parameters
        """
        M, J = self.measured(found.estimate)
        units = np.eye(self.count, self.count + 1)
        following = [states(found.A, found.C, found.turn, found.B, found.std, unit) for unit in units]
        scale = self.normal(found).scale
        rows = (J[:, :3, :-1] + M[:, :3] @ np.stack(following, axis=2)) / scale
        inverse = np.linalg.pinv(found.square[:-1, :-1] / np.outer(scale, scale), hermitian=True)
        return np.asarray(np.einsum("jk,nik->nji", inverse / scale[:, None], rows))


def stepped(e: ChainedParameters, step: Array, slots: Array) -> tuple[Array, Array, Array] | None:
    """Centre, root and bias a step further, slots (entries, 3, 3) dG / d each entry; None where G turns inside out."""
    root = e.root + np.tensordot(step[3 : 3 + len(slots)], slots, 1)
    if np.linalg.det(root) <= 0:
        return None
    return e.centre + step[:3], root, e.bias_rad_s + step[-BIAS:]
