"""Figures of [Ding2021]: convergence by population and method, and tensor before and after calibration."""

from __future__ import annotations

from typing import Any

import numpy as np

from calib.methods.de_gradiometer import DeGradiometer
from calib.methods.least_squares_gradiometer import LeastSquaresGradiometer
from calib.models.sensor_array import TENSOR_NAMES, tensor
from papers.ding2021.search_trials import EVOLUTION, GENETIC, SIZES, SearchTask, populations, search_trial
from papers.ding2021.trials import BASELINE_M, REFERENCE, simulate
from reports.palette import SOFT
from reports.plots.style import Figure, legend_at_right, panels


def convergence_figure(results: dict[Any, Any]) -> Figure:
    """Draw the rms of the objective over the iterations without noise: by population, and by method with NP = 50."""
    figure, (left, right) = panels(4.2, 1, 2, sharey=True, width_in=11.0)
    for size, method in zip(SIZES, populations(), strict=True):
        left.loglog(results[SearchTask(method, 0)]["history"], label=f"NP = {size}")
    left.set_title("Improved differential evolution, by population")
    methods = {"improved": EVOLUTION, "classic": DeGradiometer(polish=False), "genetic algorithm": GENETIC}
    for name, method in methods.items():
        task = SearchTask(method, 0)
        right.loglog((results.get(task) or search_trial(task))["history"], label=name)
    right.set_title("Methods, NP = 50")
    left.set_ylabel("rms of the objective (nT)")
    for axis in (left, right):
        axis.axhline(1e-4, color=SOFT, linewidth=0.7, linestyle=":")
        axis.set_xlabel("iteration")
        axis.legend()
    return figure


def tensor_figure() -> Figure:
    """Draw the tensor components of simulation 1 with 10 nT of noise, raw and corrected; the true tensor is zero."""
    array = simulate(1, 10.0, 0)
    raw_nT = array.recording.array_mag_nT
    assert raw_nT is not None
    fit = LeastSquaresGradiometer(start="two_step").fit(array.recording, REFERENCE)
    figure, axes = panels(5.0, 2, 1, sharex=True, width_in=11.0)
    fields_nT = (raw_nT, fit.apply_array(array.recording))
    for axis, field_nT, title in zip(axes, fields_nT, ("raw", "corrected"), strict=True):
        components = tensor(field_nT, BASELINE_M)
        for column, name in enumerate(TENSOR_NAMES):
            rms = np.sqrt(np.mean(components[:, column] ** 2))
            axis.plot(components[:, column], label=f"{name}, rms {rms:.3g}")
        axis.set_title(f"Simulation 1, noise 10 nT: {title}")
        axis.set_ylabel("nT/m")
        legend_at_right(axis)
    axes[1].set_xlabel("attitude")
    return figure
