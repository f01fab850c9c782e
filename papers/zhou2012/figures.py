"""Figures of [Zhou2012]: objective, five parameters, and z over the turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from calib.methods.de_turntable import DeTurntable
from calib.models.turntable import NAMES
from papers.zhou2012.trials import PRINTED, SEED, STABLE_AT, STOPS, ZhouTrial, recording, reference
from reports.plots.style import Figure, panels
from scenarios.arrays import Array
from scenarios.seeds import stream
from sim.state import State


def objective_figure(trials: list[ZhouTrial]) -> Figure:
    """Draw the objective against the iterations, over the seeds."""
    figure, axis = panels(3.6, width_in=7.0)
    rms = np.array([t.history for t in trials])
    steps = np.arange(1, rms.shape[1] + 1)
    axis.fill_between(
        steps, *np.quantile(rms, (0.05, 0.95), axis=0), alpha=0.25, linewidth=0, label="5 to 95 % of seeds"
    )
    axis.plot(steps, np.median(rms, axis=0), label="median")
    axis.axvline(STABLE_AT, color="0.5", linestyle=":", label="paper: stable")
    axis.set(
        xlabel="iteration",
        ylabel="rms of the objective's terms (nT)",
        yscale="log",
        title="Objective against iterations",
    )
    axis.legend()
    return figure


def course_figure(state: State) -> Figure:
    """Draw the five parameters against the iterations for a seed; runs of all lengths draw equal random numbers."""
    figure, axis = panels(3.6, width_in=7.0)
    measured, known = recording(state, 0), reference(state)
    lengths = np.unique(np.geomspace(1, 500, 40).round().astype(int))
    fits = [replace(DeTurntable(), iterations=int(n)).fit(measured, known, stream(SEED, 0, "search")) for n in lengths]
    for k, name in enumerate(NAMES):
        line = axis.plot(lengths, [fit.parameters[name] for fit in fits], label=name)[0]
        axis.axhline(PRINTED[k], color=line.get_color(), linestyle=":", linewidth=0.8)
    axis.set(xlabel="iteration", ylabel="direction cosine", xscale="log", title="The five (dotted: the paper's values)")
    axis.legend(ncols=5)
    return figure


def z_figure(trial: ZhouTrial) -> Figure:
    """Draw z at the stops before and after correction."""
    figure, axis = panels(3.2, width_in=7.0)
    angle = 30.0 * np.arange(STOPS)
    curves: tuple[tuple[Array, str], ...] = ((trial.z_nT, "before"), (trial.flat_nT, "after"))
    for z, label in curves:
        axis.plot(angle, z - trial.flat_nT.mean(), marker="o", label=label)
    axis.set(xlabel="turn, clockwise (degrees)", ylabel="z less its mean after (nT)", title="z output over the turn")
    axis.legend()
    return figure
