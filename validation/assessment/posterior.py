"""Posterior of offset, matrix and disturbances of a sensor, from a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from calib import Calibration, Reference, Status, get
from calib.held_out.legs import LegPartition, legs_of
from calib.held_out.models import offset
from calib.input_terms import InputTerm
from calib.models.ellipsoid import UPPER
from recordings import Recording
from scenarios.arrays import Array
from validation.assessment.level_flight import LevelFlight
from validation.assessment.mixture import Component, LegSquares, mixture
from validation.assessment.policy import ASSESSMENT
from validation.assessment.sensor_model import CURVE_TERMS, TURNING, SensorModel, group_of
from validation.signals.thinning import every_nth

BASE, VECTOR_BASE = ("ellipsoid", "motor_ellipsoid"), ("vector_least_squares", "motor_vector")
"""Calibrators that the model is linear about: without and with terms of inputs and turning."""
STEPS = 3
"""Gauss-Newton steps from a sphere where the motion does not determine the ellipsoid."""
MOST_SAMPLES = 10_000
"""Samples that such a start is found from."""
LEAST_ROWS = 12
"""Rows below which offset and matrix have no posterior."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Mixture of distributions of the parameters of a sensor model, and the squares that it comes from.

    recording : whose rows are in the squares. determined : whether the motion determines S; else a prior of
    ASSESSMENT.soft_iron does.
    """

    model: SensorModel
    recording: Recording
    squares: LegSquares
    components: tuple[Component, ...]
    legs: LegPartition
    determined: bool

    @property
    def likeliest(self) -> Component:
        """Return the component of the largest weight."""
        return max(self.components, key=lambda one: one.weight)

    @cached_property
    def drawn(self) -> SensorDraws:
        """Return draws of the sensor."""
        rng = np.random.default_rng(0)
        counts = [max(1, round(ASSESSMENT.draws * one.weight)) for one in self.components]
        parameters = [one.drawn(count, rng) for one, count in zip(self.components, counts, strict=True)]
        return SensorDraws.of(self.model, np.concatenate(parameters))


@dataclass(frozen=True, eq=False)
class SensorDraws:
    """Draws of a sensor: offset_nT (m, 3), S (m, 3, 3), and curves (m, 2, 3) of c^2 and c^3, c = S h / scale, nT.

    moved_nT (m, q, 3) : fields of the model's signals, for a unit rms change.
    """

    offset_nT: Array
    S: Array
    curves_nT: Array
    curve_scale: float
    moved_nT: Array = field(default_factory=lambda: np.zeros((1, 0, 3)))

    @classmethod
    def of(cls, model: SensorModel, parameters: Array) -> SensorDraws:
        """Return the sensor of parameters (m, k) about a model."""
        iron = 3 + len(model.slots)
        entries = parameters[:, 3:iron] / model.reference.strength_nT
        S = model.S + np.tensordot(entries, model.slots, 1)
        curves = parameters[:, iron : iron + CURVE_TERMS].reshape(-1, 2, 3)
        driven = iron + CURVE_TERMS + 3 * len(model.signals)
        moved = (parameters + model.taken)[:, iron + CURVE_TERMS : driven].reshape(len(parameters), -1, 3)
        return cls(model.offset_nT + parameters[:, :3], S, curves, model.curve_scale, moved)

    def heading_rms_deg(self, fit: Calibration, flight: LevelFlight, *, turned: bool) -> Array:
        """Return the rms (m,) of a calibration's heading error in level flight, for each draw.

        turned : the calibration determines the sensor's turn in the body; else Q with Q matrix S closest to 1 is taken
        off, as an alignment of compass and vehicle does.
        """
        s = flight.field_nT @ self.S.transpose(0, 2, 1)
        c = s / self.curve_scale
        bent = self.curves_nT[:, :1] * c**2 + self.curves_nT[:, 1:] * c**3
        field_nT = (s + bent + self.offset_nT[:, None] - fit.offset_nT) @ fit.matrix.T
        if not turned:
            u, _, vt = np.linalg.svd(fit.matrix @ self.S)
            field_nT = field_nT @ (u @ vt)
        return flight.rms_deg(field_nT)


def posterior_of(
    fits: Mapping[str, Calibration], recording: Recording, reference: Reference, flight: LevelFlight, *, vector: bool
) -> Posterior | None:
    """Return the posterior of the sensor of a recording; fits : calibrations of the recording, by name.

    vector : by attitude and field vector; else by the strength. None where too few rows are there, and where the
    measurements determine nothing.
    """
    try:
        with np.errstate(divide="raise", invalid="raise", over="raise"):
            return _posterior(fits, recording, reference, flight, vector=vector)
    except (ArithmeticError, np.linalg.LinAlgError):
        return None


def _posterior(
    fits: Mapping[str, Calibration], recording: Recording, reference: Reference, flight: LevelFlight, *, vector: bool
) -> Posterior | None:
    fit = _base_of(fits, recording, reference, *(VECTOR_BASE if vector else BASE))
    terms = next((one.inputs for one in fits.values() if one.inputs and one.status.kind == "ok"), ())
    recording = fit.used(recording)
    if len(recording) < LEAST_ROWS:
        return None
    if fit.status.kind == "ok":
        return _about(fit, recording, reference, flight, terms, vector=vector, determined=True)
    return None if vector else _from_sphere(recording, reference, flight, terms)


def _base_of(
    fits: Mapping[str, Calibration], recording: Recording, reference: Reference, plain: str, driven: str
) -> Calibration:
    """Return the calibration that the model is linear about: with terms of inputs or turning where one is ok."""
    first = fits.get(plain) or get(plain).fit(recording, reference)
    richer = next((one for one in fits.values() if one.name == driven and one.status.kind == "ok"), None)
    if richer is None or (first.status.kind == "ok" and not richer.inputs and richer.eddy_s is None):
        return first
    return richer


def _from_sphere(
    recording: Recording, reference: Reference, flight: LevelFlight, terms: Sequence[InputTerm]
) -> Posterior | None:
    """Return the posterior about a sphere moved on by Gauss-Newton steps, with a prior of S."""
    thin = replace(recording.taken(every_nth(len(recording), MOST_SAMPLES)), att_q=None)
    found = offset(thin, reference).found
    base = _base(reference.strength_nT * found[:3], float(found[3]) * np.eye(3))
    posterior = None
    for _ in range(STEPS):
        posterior = _about(base, recording, reference, flight, terms, vector=False, determined=False)
        step = posterior.squares.solved({}).mean
        drawn = SensorDraws.of(posterior.model, step[None])
        if not np.linalg.eigvalsh(drawn.S[0])[0] > 0:
            break
        base = _base(drawn.offset_nT[0], drawn.S[0])
    return posterior


def _base(offset_nT: Array, S: Array) -> Calibration:
    return Calibration(name="base", status=Status("ok"), offset_nT=offset_nT, matrix=np.asarray(np.linalg.inv(S)))


def _about(
    base: Calibration,
    recording: Recording,
    reference: Reference,
    flight: LevelFlight,
    terms: Sequence[InputTerm],
    *,
    vector: bool,
    determined: bool,
) -> Posterior:
    model = SensorModel.about(base, recording, reference, terms, vector=vector)
    legs = legs_of(recording)
    firm, centre = (np.zeros(len(model.groups)),) * 2 if determined else _prior(model)
    centre = centre - model.taken
    rows = len(recording) * model.rows_per_sample
    wanted = heading_rows(model, flight)
    present = {*(group_of(term.channel) for term in terms), *(() if base.eddy_s is None else (TURNING,))}
    squares = LegSquares(
        model.squares(recording, legs), model.groups, rows, wanted, firm, centre, reference.strength_nT, tuple(present)
    )
    return Posterior(model, recording, squares, mixture(squares), legs, determined)


def _prior(model: SensorModel) -> tuple[Array, Array]:
    """Return prior precision (k,) and mean (k,) of a symmetric S: a multiple of the identity."""
    F, scale = model.reference.strength_nT, float(np.trace(model.S)) / 3.0
    wide_nT, rest = ASSESSMENT.soft_iron * F * scale, np.zeros(len(model.groups) - 9)
    off_nT = F * (scale * np.eye(3) - model.S)[UPPER]
    return np.concatenate((np.zeros(3), np.full(6, 1.0 / wide_nT**2), rest)), np.concatenate(
        (np.zeros(3), off_nT, rest)
    )


def heading_rows(model: SensorModel, flight: LevelFlight) -> Array:
    """Return rows (HEADINGS, k) of the heading error, deg, that iron and curves leave in the base's corrected field.

    A (db + dS h + curves), of A dS the symmetric part where the turn of the sensor is not determined.
    """
    A, F, h = np.linalg.inv(model.S), model.reference.strength_nT, flight.field_nT
    moved = A @ model.slots / F
    moved = moved if model.vector else (moved + moved.transpose(0, 2, 1)) / 2.0
    c = h @ model.S.T / model.curve_scale
    parts = [
        flight.across @ A,
        np.einsum("ni,kij,nj->nk", flight.across, moved, h),
        flight.across @ A * c**2,
        flight.across @ A * c**3,
    ]
    rows = np.concatenate(parts, axis=1)
    return np.concatenate((rows, np.zeros((len(h), len(model.groups) - rows.shape[1]))), axis=1)
