"""Cramer-Rao bounds of scores, by the delta method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.information import FULL, Places, jacobian
from validation.bound.knowledge import PLACES
from validation.scoring.definitions import SCORE_DEFINITIONS, ScoreDefinition
from validation.scoring.hold_out import (
    LEVEL_ATTITUDES,
    MANOEUVRE_SAMPLES,
    SPHERE_ATTITUDES,
    dipole_enu_nT,
    level_attitudes,
    manoeuvres,
    survey_line,
    uniform_attitudes,
)

UP = np.array([0.0, 0.0, 1.0])
DRAWS = 400
"""Errors drawn for a nonlinear score, whose mean then has an error of 1 / sqrt(400) of the spread."""


@dataclass(frozen=True)
class ScoreBound:
    """Score, and the least value of any method on average over recordings; infinite if unobservable."""

    meaning: ScoreDefinition
    value: float


def score_bounds(known: Experiment, bound: Bound) -> tuple[ScoreBound, ...]:
    """Return bounds of the strength over all attitudes, and for a known field vector of heading, anomaly, merit.

    dh = -S^-1 (db + dS h), the error of the corrected field on the hold-out of `validation.scoring`. Without the
    rotation of the sensor the symmetric part of S^-1 dS is taken, as in the scores.
    """
    names = [STRENGTH] if known.field_enu_nT is None else list(ROWS)
    found = [
        ScoreBound(SCORE_DEFINITIONS[name], _rms(bound.variance(rows_of(name, known, bound.knowledge))))
        for name in names
    ]
    if known.field_enu_nT is not None:
        found.append(ScoreBound(SCORE_DEFINITIONS["figure_of_merit"], _figure_of_merit(known, bound)))
    return tuple(found)


def rows_of(name: str, known: Experiment, knowledge: str) -> Array:
    """Return rows G (n, k) of a score that is the rms of figures G p, in units of the score per nT."""
    return ROWS[name](known, PLACES[knowledge])


def _heading_deg(known: Experiment, places: Places) -> Array:
    """Return rows of (e_e n - e_n e) / (e^2 + n^2) in degrees: e_e, e_n the field's errors, e, n the field."""
    attitudes, enu_nT = level_attitudes(LEVEL_ATTITUDES), _field(known)
    across = np.array([enu_nT[1], -enu_nT[0], 0.0])
    horizontal = float(across @ across)
    if not horizontal > 0:
        return np.full((1, 3 + len(places)), np.inf)
    east = attitudes.inv().apply(np.degrees(across / horizontal))
    return np.asarray(np.einsum("ni,nij->nj", east, _errors(known, places, attitudes, enu_nT)))


def _strength(known: Experiment, places: Places) -> Array:
    return _along(known, places, uniform_attitudes(SPHERE_ATTITUDES), _field(known))


def _anomaly(known: Experiment, places: Places) -> Array:
    """Return rows of the total field along the survey line over a dipole, less the mean."""
    (pos_m, attitudes), enu_nT = survey_line(), _field(known)
    rows = _along(known, places, attitudes, enu_nT + dipole_enu_nT(pos_m, enu_nT))
    return np.asarray(rows - rows.mean(axis=0))


STRENGTH = "holdout_sphere_norm_rms"
ROWS: dict[str, Callable[[Experiment, Places], Array]] = {
    "heading_rms": _heading_deg,
    STRENGTH: _strength,
    "anomaly_rms": _anomaly,
}
"""Rows of the scores that are linear in the errors."""


def _figure_of_merit(known: Experiment, bound: Bound) -> float:
    """Return the mean over drawn errors, since peak-to-peak values are not linear in the errors."""
    rows = _along(known, bound.information.places, manoeuvres(), _field(known))
    if not np.isfinite(bound.variance(rows)).all():
        return np.inf
    values, vectors = np.linalg.eigh(np.where(np.isfinite(bound.covariance), bound.covariance, 0.0))
    root = vectors * np.sqrt(np.clip(values, 0.0, None)) @ vectors.T  # symmetric: no processor's choice of axes
    errors = np.random.default_rng(0).standard_normal((DRAWS, len(root))) @ root
    total_nT = (errors @ rows.T).reshape(DRAWS, -1, MANOEUVRE_SAMPLES)
    return float(np.ptp(total_nT, axis=2).sum(axis=1).mean())


def _field(known: Experiment) -> Array:
    """Return the field in the world; for a known strength a vertical field, since attitudes cover all directions."""
    return known.strength_nT * UP if known.field_enu_nT is None else known.field_enu_nT


def _along(known: Experiment, places: Places, attitudes: Rotation, enu_nT: Array) -> Array:
    """Return d |h| / d p (n, k) of the corrected field, for a world field (3,) or (n, 3)."""
    field_nT = attitudes.inv().apply(enu_nT)
    unit = field_nT / np.linalg.norm(field_nT, axis=1)[:, None]
    return np.asarray(np.einsum("ni,nij->nj", unit, _errors(known, places, attitudes, enu_nT)))


def _errors(known: Experiment, places: Places, attitudes: Rotation, enu_nT: Array) -> Array:
    """Return d h / d p (n, 3, k) of the corrected field."""
    h = attitudes.inv().apply(enu_nT) / known.strength_nT
    inverse = np.linalg.inv(known.matrix)
    if places == FULL:
        return np.asarray(-np.einsum("ij,njk->nik", inverse, jacobian(h, places)))
    entries = jacobian(np.eye(3), places)[:, :, 3:].transpose(2, 1, 0)
    turned = inverse @ entries
    symmetric = (turned + turned.transpose(0, 2, 1)) / 2.0
    offset = np.broadcast_to(inverse, (len(h), 3, 3))
    return -np.concatenate([offset, np.einsum("kij,nj->nik", symmetric, h)], axis=2)


def _rms(variance: Array) -> float:
    return float(np.sqrt(np.mean(variance)))
