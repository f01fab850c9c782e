"""Figures of MotionCal, and the fit error of NXP's sensor fusion [MotionCal: quality.c, magcal.c]."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from validation.known_figures.figures import CalibratedLog, KnownFigure
from validation.known_figures.regions import REGIONS, middles, region_counts, region_of

BUFFER = 650
"""Samples that MotionCal holds; of a longer log evenly spaced ones are taken."""
GAPS, VARIANCE, WOBBLE, FIT = 15.0, 4.5, 4.0, 5.0
"""Limits of MotionCal below which it offers its calibration, per cent."""
NXP_FIT = 4.0
"""Fit error in per cent up to which NXP's fusion takes the calibration of a better solver in any case."""
AGEING_S = 7200.0
"""Time in which NXP's fit error grows by e, so that a good calibration does not keep later ones out."""
PENALTY = (1.0, 0.2, 0.01)
"""Gap of a region with no, one and two samples."""
PROGRAM = "MotionCal"


def gaps(log: CalibratedLog) -> KnownFigure:
    """Surface gap error: regions without samples count 1, with one 0.2, with two 0.01, of a hundred."""
    counts = region_counts(_held(log))
    value = sum(weight * np.count_nonzero(counts == k) for k, weight in enumerate(PENALTY))
    return KnownFigure(PROGRAM, "gaps", float(value), "%", GAPS)


def variance(log: CalibratedLog) -> KnownFigure:
    """Magnitude variance error: standard deviation of the strength over its mean, per cent."""
    size = np.linalg.norm(_held(log), axis=1)
    return KnownFigure(PROGRAM, "variance", 100.0 * float(size.std() / size.mean()), "%", VARIANCE)


def wobble(log: CalibratedLog) -> KnownFigure:
    """Wobble error: length of the mean difference of each visited region's mean from its middle, over the radius."""
    points = _held(log)
    radius, regions = float(np.linalg.norm(points, axis=1).mean()), region_of(points)
    counts = np.bincount(regions, minlength=REGIONS)
    sums = np.column_stack([np.bincount(regions, weights=axis, minlength=REGIONS) for axis in points.T])
    seen = counts > 0
    off = (sums[seen] / counts[seen, None] - radius * middles()[seen]).mean(axis=0)
    return KnownFigure(PROGRAM, "wobble", 100.0 * float(np.linalg.norm(off)) / radius, "%", WOBBLE)


def fit_error(log: CalibratedLog) -> KnownFigure:
    """Spherical fit error, NXP's E, of the calibration at hand."""
    return KnownFigure(PROGRAM, "fit error", _fit_error(log), "%", FIT)


def nxp_fit_error(log: CalibratedLog) -> KnownFigure:
    """E = 50 sqrt(mean (|h|^2 - B^2)^2) / B^2, per cent, of ten parameters; it ages by e in two hours."""
    return KnownFigure("NXP", f"fit error, ages by e in {AGEING_S / 3600:g} h", _fit_error(log), "%", NXP_FIT)


def _fit_error(log: CalibratedLog) -> float:
    square = log.strength_nT**2
    return 50.0 * float(np.sqrt(np.mean((log.lengths_nT**2 - square) ** 2))) / square


def _held(log: CalibratedLog) -> Array:
    """Return the calibrated field (m, 3) of at most BUFFER samples."""
    return log.field_nT[:: max(1, -(-len(log.field_nT) // BUFFER))]
