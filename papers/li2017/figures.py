"""Figures of [Li2017]: parameters over samples, errors before and after, adapted noise."""

from __future__ import annotations

from typing import Any

import numpy as np

from calib.families.vector_filter import KalmanSettings, track
from calib.methods.kalman_rescaled import MICROTESLA
from calib.models.vector import VectorData
from papers.li2017.trials import CALM, LOUD, TRUE_STATE, compensated, fuzzy_track, simulated
from reports.palette import INK, SOFT
from reports.plots.style import Figure, panels
from scenarios.arrays import Array

COLOURS = ("#1f77b4", "#d95f02", "#1b9e77")
THIN = 10


def parameter_figure(data: VectorData) -> Figure:
    """Draw T_p, three of A and three of B over the samples, original and proposed filter (figures 3 to 5 and 7)."""
    figure, axes = panels(6.5, 2, 3, sharex=True)
    tracks = (track(data, KalmanSettings()), fuzzy_track(data, MICROTESLA))
    groups = ((0, "T_p (nT)"), (3, "first row of A"), (12, "first row of B (s)"))
    for row, (steps, name) in enumerate(zip(tracks, ("original", "rescaled + fuzzy"), strict=True)):
        for axis, (first, label) in zip(axes[row], groups, strict=True):
            _columns(axis, steps.state[:, first : first + 3], TRUE_STATE[first : first + 3])
            axis.set_title(f"{name}: {label}")
    for axis in axes[1]:
        axis.set_xlabel("sample (dashed: truth)")
    return figure


def _columns(axis: Any, values: Array, truth: Array) -> None:
    span = max(float(np.ptp(truth)), float(np.abs(truth).max()) * 0.5)
    for k, colour in enumerate(COLOURS):
        axis.plot(np.arange(0, len(values), THIN), values[::THIN, k], color=colour)
        axis.axhline(truth[k], color=colour, linestyle="--", linewidth=0.8)
    axis.set_ylim(float(truth.min()) - span, float(truth.max()) + span)


def compensation_figure(data: VectorData) -> Figure:
    """Draw component errors before and after, noise included (figures 9 and 10)."""
    figure, axes = panels(6.5, 3, 3, sharex=True)
    states = (None, track(data, KalmanSettings()).state[-1], fuzzy_track(data, MICROTESLA).state[-1])
    names = ("raw", "original filter", "rescaled + fuzzy")
    for column, (state, name) in enumerate(zip(states, names, strict=True)):
        error = data.difference_nT if state is None else compensated(state, data) - data.field_nT
        for k, axis in enumerate(axes[:, column]):
            axis.plot(np.arange(0, len(error), THIN), error[::THIN, k], color=COLOURS[k], linewidth=0.5)
            axis.set_ylabel(f"{'xyz'[k]} error (nT)" if column == 0 else "")
        axes[0, column].set_title(name)
        axes[2, column].set_xlabel("sample")
    return figure


def adaptation_figure() -> Figure:
    """Draw R and ROR while the noise changes, with the paper's Q and with a small Q (section 2.3)."""
    data = simulated(0, loud=LOUD)
    figure, axes = panels(4.5, 2, 2, sharex=True)
    cases = ((MICROTESLA, "paper's Q = 1e-5"), (CALM, f"Q = {CALM.state_variance:g}"))
    samples = np.arange(0, len(data.field_nT), THIN)
    for column, (settings, name) in enumerate(cases):
        steps = fuzzy_track(data, settings)
        top, bottom = axes[:, column]
        top.semilogy(samples, steps.noise_variance_nT2[::THIN], color=COLOURS[0], label="R")
        truth = np.where(np.arange(len(data.field_nT)) < 2 * len(data.field_nT) // 3, 25.0, 25.0 * LOUD**2)
        top.semilogy(samples, truth[::THIN], color=INK, linestyle="--", linewidth=0.8, label="truth")
        top.set_title(f"{name}: R (nT^2)")
        top.legend()
        bottom.semilogy(samples, steps.ratio[::THIN], color=COLOURS[1])
        bottom.axhline(1.0, color=SOFT, linestyle="--", linewidth=0.8)
        bottom.set_title("ROR")
        bottom.set_xlabel("sample")
    return figure
