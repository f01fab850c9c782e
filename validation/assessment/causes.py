"""Heading error of a calibration split by cause."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from calib import Calibration
from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from validation.assessment.policy import ASSESSMENT
from validation.assessment.posterior import Posterior
from validation.assessment.sensor_model import CURVES, IRON, MOTORS, TURNING, WARMTH


@dataclass(frozen=True)
class Causes:
    """Rms heading error by cause, deg; their squares add up to about the square of the whole.

    iron : offset and matrix, by the noise and the motion. motors, temperature, characteristic : what follows currents
    or throttle, the temperature, the curves of the axes, and turning. attitude : what else scatters between legs of a
    fit that uses the attitude. unexplained : the same without attitude. field_model : the direction of a given field
    vector, by which a calibration with attitude is turned; beside the interval of the heading error.
    """

    iron: float
    motors: float
    temperature: float
    characteristic: float
    eddy_currents: float
    attitude: float
    unexplained: float
    field_model: float

    def left_by(self, fit: Calibration) -> Causes:
        """Return the causes without those whose field the calibration itself takes off."""
        channels = {term.channel for term in fit.inputs}
        warmth = 0.0 if TEMPERATURE in channels else self.temperature
        return replace(self, motors=0.0 if channels - {TEMPERATURE} else self.motors, temperature=warmth)

    @property
    def largest(self) -> str:
        """Return the name of the largest cause."""
        named = vars(self)
        return max(named, key=lambda name: named[name]).replace("_", " ")


def causes_of(posterior: Posterior, level_nT: float) -> Causes:
    """Return the causes by a posterior; level_nT : the horizontal part of the field.

    A disturbance X t moves the iron by -N^-1 J^T X t: rms over the headings, and over the posterior of t.
    """
    found, vector = posterior.likeliest, posterior.model.vector
    root = _iron_root(posterior)
    white = float(np.sqrt(found.noise_nT2 * np.sum((_iron_rows(posterior) @ root) ** 2) / _headings(posterior)))
    slow = white * float(np.sqrt(max(0.0, found.scatter - 1.0)))
    return Causes(
        iron=white,
        motors=_moved(posterior, root, MOTORS),
        temperature=_moved(posterior, root, WARMTH),
        characteristic=_moved(posterior, root, CURVES),
        eddy_currents=_moved(posterior, root, TURNING),
        attitude=slow if vector else 0.0,
        unexplained=0.0 if vector else slow,
        field_model=float(np.degrees(ASSESSMENT.model_std_nT / level_nT)) if vector else 0.0,
    )


def _headings(posterior: Posterior) -> int:
    return len(posterior.squares.wanted)


def _iron_rows(posterior: Posterior) -> Array:
    return posterior.squares.wanted[:, posterior.squares.where(IRON)]


def _iron_root(posterior: Posterior) -> Array:
    """Return R (k, k), R R^T the inverse information of the iron, with its prior."""
    squares = posterior.squares
    iron = squares.where(IRON)
    N = squares.total[:-1, :-1][np.ix_(iron, iron)] + np.diag(posterior.likeliest.noise_nT2 * squares.firm[iron])
    size = np.sqrt(np.diag(N))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(N / np.outer(size, size))).T / size[:, None])


def _moved(posterior: Posterior, root: Array, group: str) -> float:
    """Return the rms heading error that a group of disturbances has moved the iron by, and leaves itself."""
    squares, found = posterior.squares, posterior.likeliest
    own, iron = squares.where(group), squares.where(IRON)
    if not found.spreads.get(group, 0.0) > 0:
        return 0.0
    cross = squares.total[:-1, :-1][np.ix_(iron, own)]
    rows = squares.wanted[:, own] - squares.wanted[:, iron] @ root @ (root.T @ cross)
    mean = (found.mean + posterior.model.taken)[own]
    second = found.covariance[np.ix_(own, own)] + np.outer(mean, mean)
    return float(np.sqrt(np.einsum("ki,ij,kj->", rows, second, rows) / _headings(posterior)))
