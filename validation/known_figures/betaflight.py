"""Figures of Betaflight Configurator's calibration [Betaflight: src/js/utils/sphereFit.js]."""

from __future__ import annotations

import numpy as np

from validation.known_figures.figures import CalibratedLog, KnownFigure
from validation.known_figures.regions import REGIONS, region_counts

RESIDUAL, COVERAGE, CENTRE = 2.0, 80.0, 0.15
"""Limits of a good calibration: residual and coverage in per cent, and centre over radius."""
PROGRAM = "Betaflight"


def sphere_residual(log: CalibratedLog) -> KnownFigure:
    """Rms distance of the measurements from the sphere through them, in per cent of its radius."""
    centre, radius = log.sphere
    distance = np.linalg.norm(log.measured_nT - centre, axis=1) - radius
    return KnownFigure(
        PROGRAM, "residual of a sphere", 100.0 * float(np.sqrt(np.mean(distance**2))) / radius, "%", RESIDUAL
    )


def covered(log: CalibratedLog) -> KnownFigure:
    """Share of the sphere's equal regions about the centre that hold a measurement, per cent."""
    counts = region_counts(log.measured_nT - log.sphere[0])
    return KnownFigure(PROGRAM, "coverage", 100.0 * np.count_nonzero(counts) / REGIONS, "%", COVERAGE, at_most=False)


def centre_ratio(log: CalibratedLog) -> KnownFigure:
    """Distance of the sphere's centre from zero over its radius: large hard iron is better moved than corrected."""
    centre, radius = log.sphere
    return KnownFigure(PROGRAM, "centre over radius", float(np.linalg.norm(centre)) / radius, "", CENTRE)
