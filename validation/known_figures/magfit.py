"""Figures of MAGFit, ArduPilot's tool for logs [MAGFit: magfit.js, get_weights and fit]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from validation.known_figures.ardupilot import NT_PER_MG
from validation.known_figures.figures import CalibratedLog, KnownFigure

BINS = 80
COVERAGE = 30.0
"""Coverage in per cent that a fit needs."""
UNKNOWN = "needs attitude and field vector"


def field_error(log: CalibratedLog) -> KnownFigure:
    """Rms distance of the calibrated field from the world model's in the body frame, each bin of directions alike, mG.

    sqrt(sum w_i |h_i - R^T F|^2 / n),  w_i = n / (bins in use * samples in the bin)
    """
    name, program = "error against the world model", "MAGFit"
    if log.known_nT is None:
        return KnownFigure(program, name, None, "mG", None, note=UNKNOWN)
    counts = _counts(log.known_nT)
    bins = _bins(log.known_nT)
    weight = len(bins) / np.count_nonzero(counts) / counts[bins]
    square = np.sum((log.field_nT - log.known_nT) ** 2, axis=1)
    return KnownFigure(program, name, float(np.sqrt(np.mean(weight * square))) / NT_PER_MG, "mG", None)


def magfit_coverage(log: CalibratedLog) -> KnownFigure:
    """Share of 80 bins of directions, a Fibonacci lattice, that the known field in the body frame visits."""
    if log.known_nT is None:
        return KnownFigure("MAGFit", "coverage", None, "%", COVERAGE, at_most=False, note=UNKNOWN)
    value = 100.0 * np.count_nonzero(_counts(log.known_nT)) / BINS
    return KnownFigure("MAGFit", "coverage", float(value), "%", COVERAGE, at_most=False)


def lattice() -> Array:
    """Return the centres of the bins (BINS, 3): cos phi = 1 - 2 k / BINS, theta = pi (1 + sqrt 5) k, k = i + 1/2."""
    k = np.arange(BINS) + 0.5
    phi, theta = np.arccos(1.0 - 2.0 * k / BINS), np.pi * (1.0 + np.sqrt(5.0)) * k
    return np.column_stack([np.cos(theta) * np.sin(phi), np.sin(theta) * np.sin(phi), np.cos(phi)])


def _bins(field: Array) -> NDArray[np.intp]:
    """Return the nearest bin of each direction (n,)."""
    return np.asarray(np.argmax(field @ lattice().T, axis=1), dtype=np.intp)


def _counts(field: Array) -> NDArray[np.intp]:
    return np.bincount(_bins(field), minlength=BINS)
