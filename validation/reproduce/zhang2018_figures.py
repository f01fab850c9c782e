"""[Zhang2018]'s printed table, and pictures like the paper's with ours beside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from validation.plots.style import Figure
from validation.reproduce.zhang2018_trials import DRIFTS, FITS, METHODS, POSITIONS, SETTINGS, DriftTrial, Trial

Array = NDArray[np.float64]
PRINTED_F_NT = 36141.0
TOTAL_NT = np.array(
    [
        36044.9,
        36034.7,
        36284.0,
        36330.9,
        36398.0,
        36433.4,
        36403.5,
        36347.1,
        35980.8,
        35994.1,
        36261.1,
        36042.8,
        36241.5,
        36242.3,
        36258.6,
        36303.1,
        36341.6,
        36387.7,
        36409.0,
        36398.9,
        36376.3,
        35936.7,
        35951.7,
        35970.4,
        36292.1,
        36007.5,
        36259.2,
        36240.0,
        36251.4,
        36274.5,
    ]
)
"""Table 1: total field before calibration at the 30 positions."""
AFTER_NT = {
    "pso": np.array(
        [
            60.5,
            66.1,
            74.2,
            80.3,
            86.2,
            92.4,
            89.6,
            81.0,
            72.7,
            67.8,
            60.3,
            53.0,
            59.1,
            62.8,
            68.4,
            75.9,
            80.2,
            86.2,
            89.8,
            87.6,
            84.6,
            79.6,
            73.4,
            70.5,
            66.5,
            62.9,
            54.3,
            52.1,
            57.1,
            60.2,
        ]
    ),
    "ga": np.array(
        [
            46.2,
            50.4,
            55.8,
            61.8,
            67.5,
            72.1,
            68.0,
            66.8,
            60.3,
            53.0,
            46.5,
            40.4,
            45.4,
            48.0,
            52.2,
            59.7,
            64.8,
            68.3,
            70.2,
            71.6,
            68.0,
            65.9,
            61.1,
            58.3,
            55.3,
            50.8,
            44.5,
            41.6,
            49.8,
            58.2,
        ]
    ),
    "psoga": np.array(
        [
            37.3,
            42.6,
            46.5,
            50.0,
            53.3,
            57.8,
            54.4,
            49.1,
            44.2,
            40.7,
            35.1,
            31.5,
            34.9,
            37.0,
            42.4,
            47.4,
            50.3,
            53.6,
            55.9,
            52.7,
            50.8,
            47.0,
            45.2,
            42.1,
            40.5,
            38.6,
            34.6,
            30.5,
            32.9,
            37.5,
        ]
    ),
}
"""Table 1: absolute error after calibration."""
DRIFT_NT_H = 17.5
"""The catalogue's drift of the hard iron: the length of (12, -8, 10) nT/h."""
MAIN, SHORT = SETTINGS[0].label, SETTINGS[3].label


def rms_nT(trials: list[Trial], setting: str, name: str) -> Array:
    """The rms of |h| - F of the best after each iteration: (seeds, iterations) nT."""
    return np.array([t.rms_nT[setting, name] for t in trials])


def convergence_figure(trials: list[Trial]) -> Figure:
    """Like the paper's figure 10: median rms and its spread over the seeds against the iterations."""
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


def turn_figure(trials: list[Trial]) -> Figure:
    """Like the paper's figures 7 to 9: error at the printed positions before and after, ours beside the table's."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    ours, paper = figure.subplots(1, 2, sharey=True)
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
    """Rms after each ellipsoid fit and the error of its offset, against the drift."""
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
