"""Models of increasing size, linear in the parameters, fitted by least squares.

m_i = Y(h_i) p + v_i,  with columns 1, h and extensions in Y

With attitude and field vector h_i is known, and the misfit is m - Y p. With the strength alone |h_i| = F: h_i is the
direction from the model, and the misfit is n . (m - Y p), n the normal of the surface S h + b: the distance to the
surface. A misfit in units of the corrected field would vanish with S^-1, with the best offset at infinity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calib.held_out.legs import LegPartition
from calib.models.ellipsoid import UPPER
from calib.numerics.points import lengths
from calib.numerics.rates import world_to_body
from calib.reference import Reference
from recordings import Recording
from scenarios.arrays import Array

OFFSET, ELLIPSOID, FULL, EDDY, TEMPERATURE = "offset", "ellipsoid", "full matrix", "eddy currents", "temperature"
"""Names of models."""
STEPS, SETTLED = 30, 1e-5
"""Gauss-Newton steps at most, and relative gain at which the fit has converged."""
HALVINGS = 8
"""Halvings at most of a step without gain."""
AS_PREDICTED = 0.1
"""Relative deviation of the gain from the predicted gain within which one step suffices."""
SINGULAR = 1e-12
"""Eigenvalue of the scaled normal matrix over the largest, below which a direction is rounding."""


@dataclass(frozen=True, eq=False)
class Model:
    """Model of measurements (n, 3), with parameters `found` of a fit to all samples.

    parameters p : offset (3,), entries of S for each of `slots` (k, 3, 3), coefficients of columns `more` (n, 3, l)
    known : (n, 3) the field in the body frame, over F; None where only the strength is known
    All in units of F.
    """

    name: str
    mag: Array
    known: Array | None
    slots: Array
    more: Array
    found: Array

    @property
    def count(self) -> int:
        """Return the number of parameters."""
        return len(self.found)

    def of(self, samples: NDArray[np.bool_]) -> Model:
        """Return the model restricted to a mask of samples (n,)."""
        known = None if self.known is None else self.known[samples]
        return replace(self, mag=self.mag[samples], known=known, more=self.more[samples])

    def misfit(self) -> Array:
        """Return the misfit over F: distances (n, 1), or vectors (n, 3)."""
        return self._seen()[0]

    def field(self) -> Array:
        """Return the corrected field (n, 3), over F."""
        return np.asarray(self._static() @ np.linalg.inv(self._matrix).T)

    def fitted(self) -> Model:
        """Return the model fitted by Gauss-Newton from the present parameters."""
        now, before = self, np.inf
        for _ in range(STEPS):
            misfit, J = now.linear()
            cost = float(np.sum(misfit**2))
            if not cost < before * (1.0 - SETTLED):
                break
            flat, before = J.reshape(-1, self.count), cost
            now = now._gained(_solved(flat.T @ flat, flat.T @ misfit.reshape(-1)), cost)
        return now

    def unseen(self, legs: LegPartition) -> Iterator[Array]:
        """Yield the misfit of each leg with parameters fitted to all other legs.

        Parameters follow by one step from the fit to all legs; by a new fit if the gain is not as predicted.
        """
        misfit, J = self.linear()
        squares = legs.squares(np.concatenate([J, misfit[:, :, None]], axis=2).__getitem__)
        for leg, square in enumerate(squares.sum(axis=0) - squares):
            found = self.of(legs.number != leg)._from_sums(square).found
            yield replace(self.of(legs.number == leg), found=found).misfit()

    def _from_sums(self, square: Array) -> Model:
        """Return the model fitted by normal equations: square (k + 1, k + 1) of columns and misfit."""
        step = _solved(square[:-1, :-1], square[:-1, -1])
        further, predicted = replace(self, found=self.found + step), float(step @ square[:-1, -1])
        if self.known is not None:
            return further
        gain = float(square[-1, -1] - np.sum(further.misfit() ** 2))
        return further if abs(gain - predicted) <= AS_PREDICTED * predicted else self.fitted()

    def richer(self, name: str, *, slots: Array | None = None, more: Array | None = None) -> Model:
        """Return the model with other entries of S, or additional columns (n, 3, l), fitted anew."""
        entries = self.slots if slots is None else slots
        columns = self.more if more is None else np.concatenate([self.more, more], axis=2)
        inner = self.found[3 : 3 + len(self.slots)]
        wanted = np.tensordot(inner, self.slots, 1).ravel()
        start = np.linalg.lstsq(entries.reshape(len(entries), 9).T, wanted, rcond=None)[0]
        rest = np.zeros(columns.shape[2])
        rest[: self.more.shape[2]] = self.found[3 + len(self.slots) :]
        found = np.concatenate([self.found[:3], start, rest])
        return replace(self, name=name, slots=entries, more=columns, found=found).fitted()

    @property
    def _matrix(self) -> Array:
        return np.asarray(np.tensordot(self.found[3 : 3 + len(self.slots)], self.slots, 1))

    @property
    def _is_one(self) -> bool:
        """Return whether S is positive definite, which a model without known field needs."""
        return self.known is not None or bool(np.linalg.eigvalsh(self._matrix)[0] > 0)

    def _static(self) -> Array:
        """Return S h (n, 3): the measurements without offset and extensions."""
        return np.asarray(self.mag - self.found[:3] - self.more @ self.found[3 + len(self.slots) :])

    def _seen(self) -> tuple[Array, Array, Array | None]:
        """Return misfit (n, r), field h (n, 3), and normal (n, 3), None for a known field."""
        static, S = self._static(), self._matrix
        if self.known is not None:
            return static - self.known @ S.T, self.known, None
        inverse = np.linalg.inv(S)
        h = static @ inverse.T
        h /= lengths(h)[:, None]
        normal = h @ inverse
        normal /= lengths(normal)[:, None]
        return np.sum(normal * (static - h @ S.T), axis=1)[:, None], h, normal

    def linear(self) -> tuple[Array, Array]:
        """Return misfit (n, r) and columns J (n, r, k) of the linearised model."""
        misfit, h, normal = self._seen()
        across = np.broadcast_to(np.eye(3), (len(h), 3, 3)) if normal is None else normal[:, None, :]
        entries = (across[:, :, :, None] * h[:, None, None, :]).reshape(len(h), -1, 9) @ self.slots.reshape(-1, 9).T
        return misfit, np.concatenate([across, entries, across @ self.more], axis=2)

    def _gained(self, step: Array, cost: float) -> Model:
        """Return the model after a step, halved until the cost falls; unchanged if the cost never falls."""
        for halving in range(HALVINGS):
            further = replace(self, found=self.found + step / 2**halving)
            if further._is_one and np.sum(further.misfit() ** 2) < cost:
                return further
        return self


def _solved(square: Array, slope: Array) -> Array:
    """Return the minimum-norm solution (k,) of normal equations."""
    size = np.sqrt(np.diag(square).clip(0.0))
    size = np.where(size > 0, size, 1.0)
    inverse = np.linalg.pinv(square / np.outer(size, size), rcond=SINGULAR, hermitian=True)
    return np.asarray(inverse @ (slope / size) / size)


def offset(recording: Recording, reference: Reference) -> Model:
    """Return the model of offset and scale, S = s I, from the sphere through the measurements."""
    mag = recording.mag_nT / reference.strength_nT
    middle = mag.mean(axis=0)
    centred = mag - middle
    design = np.column_stack([2.0 * centred, np.ones(len(mag))])
    centre = np.linalg.lstsq(design, np.einsum("ni,ni->n", centred, centred), rcond=None)[0][:3]
    radius = float(np.sqrt(np.mean(np.sum((centred - centre) ** 2, axis=1))))
    known = None
    if recording.att_q is not None and reference.field_enu_nT is not None:
        known = world_to_body(recording.att_q, np.array(reference.field_enu_nT)) / reference.strength_nT
    nothing = np.zeros((len(mag), 3, 0))
    return Model(OFFSET, mag, known, np.eye(3)[None], nothing, np.append(middle + centre, radius)).fitted()


def with_iron(model: Model) -> Model:
    """Return the model with soft iron: symmetric S from the strength, nine entries from the vector."""
    units = np.eye(9).reshape(9, 3, 3)
    if model.known is not None:
        return model.richer(FULL, slots=units)
    both = units + units.transpose(0, 2, 1)
    upper = [3 * i + j for i, j in zip(*UPPER, strict=True)]
    return model.richer(ELLIPSOID, slots=np.minimum(both[upper], 1.0))


def with_temperature(model: Model, temperature_degC: Array) -> Model:
    """Return the model with an offset proportional to a signal (n,)."""
    off = temperature_degC - temperature_degC.mean()
    more = (off / np.sqrt(np.mean(off**2)))[:, None, None] * np.eye(3)
    return model.richer(_with(model, TEMPERATURE), more=more)


def with_eddy(model: Model, rate_rad_s: Array) -> Model:
    """Return the model with eddy currents ``B dh/dt``, dh/dt = -omega x h, omega (n, 3)."""
    change = -np.cross(rate_rad_s, model.field() if model.known is None else model.known)
    rms = float(np.sqrt(np.mean(np.sum(change**2, axis=1)))) or 1.0
    more = np.einsum("ai,nj->naij", np.eye(3), change / rms).reshape(len(change), 3, 9)
    return model.richer(_with(model, EDDY), more=more)


def _with(model: Model, what: str) -> str:
    """Return the name of an extended model."""
    return f"{model.name} {'and' if model.more.shape[2] else 'with'} {what}"
