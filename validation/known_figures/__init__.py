"""The figures by which other programs judge a calibration, on one log, each with its own limit."""

from __future__ import annotations

from collections.abc import Callable

from calib import Calibration, Reference
from recordings import Recording
from validation.known_figures.ardupilot import fitness, largest_offset
from validation.known_figures.betaflight import centre_ratio, covered, sphere_residual
from validation.known_figures.figures import CalibratedLog, KnownFigure
from validation.known_figures.magfit import field_error, magfit_coverage
from validation.known_figures.motioncal import fit_error, gaps, nxp_fit_error, variance, wobble

FIGURES: tuple[Callable[[CalibratedLog], KnownFigure], ...] = (
    *(fitness, largest_offset, field_error, magfit_coverage),
    *(sphere_residual, covered, centre_ratio),
    *(gaps, variance, wobble, fit_error, nxp_fit_error),
)
"""Figures in the order of the table."""


def known_figures(calibration: Calibration, recording: Recording, reference: Reference) -> tuple[KnownFigure, ...]:
    """Return every figure of a calibration on the recording that it was fitted to; none without an estimate."""
    if not calibration.has_estimate or not calibration.determines_z:
        return ()
    log = CalibratedLog.of(calibration, recording, reference)
    return tuple(figure(log) for figure in FIGURES)
