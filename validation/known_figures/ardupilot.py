"""Figures of ArduPilot's compass calibrator [ArduPilot: AP_Compass/CompassCalibrator.cpp, fit_acceptable]."""

from __future__ import annotations

import numpy as np

from validation.known_figures.figures import CalibratedLog, KnownFigure

NT_PER_MG = 100.0
FITNESS_MG, OFFSET_MG = 16.0, 1800.0
"""COMPASS_CAL_FIT and COMPASS_OFFS_MAX by default."""


def fitness(log: CalibratedLog) -> KnownFigure:
    """Fitness, sqrt(mean (R - |M (s + o)|)^2), mG: the rms residual of the radius, of all samples.

    ArduPilot takes 300 samples, evenly spread over the sphere; the radius here is the field's strength.
    """
    value = float(np.sqrt(np.mean((log.lengths_nT - log.strength_nT) ** 2))) / NT_PER_MG
    return KnownFigure("ArduPilot", "fitness", value, "mG", FITNESS_MG)


def largest_offset(log: CalibratedLog) -> KnownFigure:
    """Largest component of the offset, mG."""
    value = float(np.abs(log.calibration.offset_nT).max()) / NT_PER_MG
    return KnownFigure("ArduPilot", "largest offset", value, "mG", OFFSET_MG)
