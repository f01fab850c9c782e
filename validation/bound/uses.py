"""What the bound means for what a calibration is used for: the scores of a run, by the delta method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.information import jacobian
from validation.scoring.holdout import (
    LEVEL_ATTITUDES,
    MANOEUVRE_SAMPLES,
    SPHERE_ATTITUDES,
    dipole_enu_nT,
    level_attitudes,
    manoeuvres,
    survey_line,
    uniform_attitudes,
)
from validation.scoring.meaning import MEANINGS, Meaning

Array = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
DRAWS = 400
"""Errors drawn for a figure that is not linear in them: its mean is known to 1 / sqrt(400) of its spread."""


@dataclass(frozen=True)
class Use:
    """A score, and the least of it that any method can reach on the average over recordings; infinite: no limit."""

    meaning: Meaning
    value: float


def uses(known: Experiment, bound: Bound) -> tuple[Use, ...]:
    """The strength over all attitudes, and where the field's vector is known heading, anomaly and figure of merit.

    dh = -S^-1 (db + dS h), the error of the corrected field on the hold-out of `validation.scoring`; where the rotation
    of the sensor is not told, the symmetric part of S^-1 dS stands for it, as in the scores.
    """
    if known.field_enu_nT is None:
        vertical_nT = known.strength_nT * UP
        return (_use("holdout_sphere_norm_rms", _strength(known, bound, vertical_nT)),)
    enu_nT = known.field_enu_nT
    return (
        _use("heading_rms", _heading_deg(known, bound, enu_nT)),
        _use("holdout_sphere_norm_rms", _strength(known, bound, enu_nT)),
        _use("anomaly_rms", _anomaly(known, bound, enu_nT)),
        _use("figure_of_merit", _figure_of_merit(known, bound, enu_nT)),
    )


def _use(score: str, value: float) -> Use:
    return Use(MEANINGS[score], value)


def _heading_deg(known: Experiment, bound: Bound, enu_nT: Array) -> float:
    """(e_e n - e_n e) / (e^2 + n^2), e_e and e_n the east and north of the corrected field's error."""
    attitudes = level_attitudes(LEVEL_ATTITUDES)
    east, north, _ = enu_nT
    across = np.array([north, -east, 0.0])
    horizontal = float(across @ across)
    if not horizontal > 0:
        return np.inf
    rows = np.einsum("ni,nij->nj", attitudes.inv().apply(across / horizontal), _errors(known, bound, attitudes, enu_nT))
    return float(np.degrees(_rms(bound.variance(rows))))


def _strength(known: Experiment, bound: Bound, enu_nT: Array) -> float:
    return _rms(bound.variance(_along(known, bound, uniform_attitudes(SPHERE_ATTITUDES), enu_nT)))


def _anomaly(known: Experiment, bound: Bound, enu_nT: Array) -> float:
    """Of the total field along the survey line over a dipole, less its mean."""
    pos_m, attitudes = survey_line()
    rows = _along(known, bound, attitudes, enu_nT + dipole_enu_nT(pos_m, enu_nT))
    return _rms(bound.variance(rows - rows.mean(axis=0)))


def _figure_of_merit(known: Experiment, bound: Bound, enu_nT: Array) -> float:
    """Mean over drawn errors: peak to peak is not linear in them."""
    rows = _along(known, bound, manoeuvres(), enu_nT)
    if not np.isfinite(bound.variance(rows)).all():
        return np.inf
    values, vectors = np.linalg.eigh(np.where(np.isfinite(bound.covariance), bound.covariance, 0.0))
    root = vectors * np.sqrt(np.clip(values, 0.0, None))
    errors = np.random.default_rng(0).standard_normal((DRAWS, len(root))) @ root.T
    total_nT = (errors @ rows.T).reshape(DRAWS, -1, MANOEUVRE_SAMPLES)
    return float(np.ptp(total_nT, axis=2).sum(axis=1).mean())


def _along(known: Experiment, bound: Bound, attitudes: Rotation, enu_nT: Array) -> Array:
    """d |h| / d p (n, k) of the corrected field, for a field of the world (3,) or (n, 3)."""
    field_nT = attitudes.inv().apply(enu_nT)
    unit = field_nT / np.linalg.norm(field_nT, axis=1)[:, None]
    return np.asarray(np.einsum("ni,nij->nj", unit, _errors(known, bound, attitudes, enu_nT)))


def _errors(known: Experiment, bound: Bound, attitudes: Rotation, enu_nT: Array) -> Array:
    """d h / d p (n, 3, k) of the corrected field."""
    h = attitudes.inv().apply(enu_nT) / bound.strength_nT
    places = bound.information.places
    inverse = np.linalg.inv(known.matrix)
    if bound.information.tells_rotation:
        return np.asarray(-np.einsum("ij,njk->nik", inverse, jacobian(h, places)))
    entries = jacobian(np.eye(3), places)[:, :, 3:].transpose(2, 1, 0)
    turned = inverse @ entries
    symmetric = (turned + turned.transpose(0, 2, 1)) / 2.0
    offset = np.broadcast_to(inverse, (len(h), 3, 3))
    return -np.concatenate([offset, np.einsum("kij,nj->nik", symmetric, h)], axis=2)


def _rms(variance: Array) -> float:
    return float(np.sqrt(np.mean(variance)))
