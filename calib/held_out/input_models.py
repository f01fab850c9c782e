"""Models of iron, inputs and eddy currents, fitted to a recording's samples."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from calib.held_out.legs import LegPartition, legs_of
from calib.held_out.models import Model, offset, with_iron
from calib.held_out.paired_legs import HeldOutErrors
from calib.models.inputs import InputGroup, axis_columns
from calib.numerics.rates import body_rate
from calib.reference import Reference
from recordings import Recording
from scenarios.arrays import Array

EDDY_ROUNDS = 3
"""Rounds in which the field that eddy currents follow is taken from the model that holds them."""


@dataclass(frozen=True, eq=False)
class InputModels:
    """Makes models of the samples `rows`; lags follow the inputs at all times.

    iron : offset and matrix alone. rate_rad_s (n, 3) : None where the eddy currents cannot be modelled.
    """

    iron: Model
    rows: slice
    time_s: Array
    rate_rad_s: Array | None
    legs: LegPartition
    strength_nT: float

    @classmethod
    def of(cls, recording: Recording, reference: Reference, rows: slice, *, eddy: bool = True) -> InputModels:
        """Models of a recording's samples `rows`."""
        part = recording.taken(rows)
        rate_rad_s = body_rate(part) if eddy and recording.origin.timed else None
        iron = with_iron(offset(part, reference))
        return cls(iron, rows, recording.time_s, rate_rad_s, legs_of(part), reference.strength_nT)

    def columns(self, group: InputGroup) -> Array:
        """Columns (n, 3, 3 m) of a group."""
        return axis_columns(group.moved(self.time_s)[self.rows])

    def model(self, groups: tuple[InputGroup, ...], *, eddy: bool) -> Model:
        """The model of iron, groups, and where asked eddy currents, fitted."""
        name = " and ".join(("iron", *(one.called for one in groups), *(("eddy currents",) if eddy else ())))
        more = np.concatenate([np.zeros((len(self.iron.mag), 3, 0)), *map(self.columns, groups)], axis=2)
        plain = found = self.iron.richer(name, more=more) if groups else self.iron
        if eddy:
            for _ in range(EDDY_ROUNDS if plain.known is None else 1):
                found = plain.richer(name, more=self.eddy_columns(found))
        return found

    def eddy_columns(self, model: Model) -> Array:
        """Columns (n, 3, k) of the entries of B, row by row: dh/dt = -omega x h; by `eddy_entries`."""
        assert self.rate_rad_s is not None
        field = model.field() if model.known is None else model.known
        change = -np.cross(self.rate_rad_s, field)
        nine = np.einsum("ai,nj->naij", np.eye(3), change).reshape(len(change), 3, 9)
        return np.asarray(nine @ eddy_entries(model).T)

    def errors(self, model: Model) -> HeldOutErrors:
        """Errors of a model on legs that are held out."""
        return HeldOutErrors.of(model, self.legs, self.strength_nT)


def eddy_entries(model: Model) -> Array:
    """Orthonormal parameters of B (k, 9): all nine, or without the trace, of which the strength says nothing.

    h . dh/dt = 0:  B = beta I turns the field by a delay of beta and leaves the strength.
    """
    if model.known is not None:
        return np.eye(9)
    identity = np.eye(3).reshape(1, 9)
    return np.asarray(np.linalg.svd(identity)[2][1:])


def least_squares_covariance(model: Model) -> tuple[float, Array]:
    """Variance v of a misfit, and covariance v (J^T J)^+ (k, k) of the parameters found; in units of F.

    v = sum misfit^2 / (rows - k)
    """
    misfit, J = model.linear()
    flat = J.reshape(-1, model.count)
    variance = float(np.sum(misfit**2)) / max(flat.shape[0] - model.count, 1)
    size = np.linalg.norm(flat, axis=0)
    size = np.where(size > 0, size, 1.0)
    square = np.linalg.pinv((flat / size).T @ (flat / size), hermitian=True)
    return variance, np.asarray(variance * square / np.outer(size, size))


def linearly_held_out(model: Model, more: Array, legs: LegPartition) -> tuple[float, float]:
    """Cost of a model with columns `more` (n, 3, l), and the mean of the legs' rms over F when held out in turn.

    Linearised about the model: quick, to compare columns with each other.
    """
    squares = legs.squares(_rows(model, more).__getitem__)
    total = squares.sum(axis=0)
    step = _step(total)
    rms = [np.sqrt(max(_cost(own, _step(total - own)), 0.0) / n) for own, n in zip(squares, legs.sizes, strict=True)]
    return _cost(total, step), float(np.mean(rms))


def _rows(model: Model, more: Array) -> Array:
    """Columns and misfit (n, r, k + 1) of the model with columns `more`."""
    richer = replace(
        model, more=np.concatenate([model.more, more], axis=2), found=np.append(model.found, np.zeros(more.shape[2]))
    )
    misfit, J = richer.linear()
    return np.concatenate([J, misfit[:, :, None]], axis=2)


def _step(square: Array) -> Array:
    size = np.sqrt(np.diag(square)[:-1].clip(1e-300))
    inverse = np.linalg.pinv(square[:-1, :-1] / np.outer(size, size), rcond=1e-12, hermitian=True)
    return np.asarray(inverse @ (square[:-1, -1] / size) / size)


def _cost(square: Array, step: Array) -> float:
    return float(square[-1, -1] - 2.0 * step @ square[:-1, -1] + step @ square[:-1, :-1] @ step)
