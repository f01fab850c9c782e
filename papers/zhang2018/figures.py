"""Figures of [Zhang2018], with the printed table 1."""

from __future__ import annotations

import numpy as np

from papers.zhang2018.printed_table import AFTER_NT, PRINTED_F_NT, TOTAL_NT
from papers.zhang2018.trials import (
    DRIFT_NT_H,
    DRIFTS,
    FITS,
    MAIN,
    METHODS,
    POSITIONS,
    SHORT,
    DriftTrial,
    ZhangTrial,
    rms_nT,
)
from reports.plots.style import Figure, panels


def convergence_figure(trials: list[ZhangTrial]) -> Figure:
    """Draw median rms and spread over the seeds against the iterations, as in the paper's figure 10."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    for axis, setting in zip(figure.subplots(1, 2, sharey=True), (MAIN, SHORT), strict=True):
        for name in METHODS:
            rms = rms_nT(trials, setting, name)
            steps = np.arange(1, rms.shape[1] + 1)
            line = axis.plot(steps, np.median(rms, axis=0), label=name)[0]
            axis.fill_between(
                steps, *np.quantile(rms, (0.05, 0.95), axis=0), color=line.get_color(), alpha=0.2, linewidth=0
            )
            axis.axhline(np.sqrt(np.mean(AFTER_NT[name] ** 2)), color=line.get_color(), linestyle=":", linewidth=0.8)
        axis.set(xlabel="iteration", yscale="log", title=f"{rms.shape[1]} iterations (dotted: the paper's table, rms)")
    figure.axes[0].set_ylabel("rms of |h| - F (nT)")
    figure.axes[0].legend()
    return figure


def turn_figure(trials: list[ZhangTrial]) -> Figure:
    """Draw the error at the printed positions before and after, ours and table 1, as in the paper's figures 7 to 9."""
    figure, (ours, paper) = panels(3.8, 1, 2, sharey=True, width_in=10.0)
    place = np.arange(1, POSITIONS + 1)
    ours.plot(place, np.median(np.abs([t.raw_nT for t in trials]), axis=0), color="0.4", label="raw")
    paper.plot(place, np.abs(TOTAL_NT - PRINTED_F_NT), color="0.4", label="raw")
    for name in METHODS:
        ours.plot(place, np.median(np.abs([t.errors_nT[MAIN, name] for t in trials]), axis=0), label=name)
        paper.plot(place, AFTER_NT[name], label=name)
    ours.set(xlabel="position (10 s apart)", ylabel="|error| of the total field (nT)", title="Ours, median over seeds")
    paper.set(xlabel="position (10 s apart)", title="Paper, table 1")
    paper.legend()
    return figure


def drift_figure(drifts: list[DriftTrial]) -> Figure:
    """Draw the rms after each ellipsoid fit and the error of the offset against the drift."""
    figure = Figure(figsize=(10.0, 3.6), layout="constrained")
    rate = DRIFT_NT_H * np.array(DRIFTS)
    residual, offset = figure.subplots(1, 2, sharex=True)
    for name in FITS:
        residual.plot(rate, np.median([d.rms_nT[name] for d in drifts], axis=0), marker="o", label=name)
        offset.plot(rate, np.median([d.offset_nT[name] for d in drifts], axis=0), marker="o", label=name)
    for axis in (residual, offset):
        axis.set(xlabel="drift of the hard iron (nT/h)", yscale="log")
    residual.set(ylabel="rms of |h| - F (nT)", title="Ellipsoid under drift: residual")
    offset.set(ylabel="error of the offset, rms (nT)", title="Distance from the moving truth")
    residual.legend()
    return figure
