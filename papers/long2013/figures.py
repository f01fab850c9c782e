"""Figures of [Long2013]: strength, roll and pitch before and after, and errors against noise."""

from __future__ import annotations

import numpy as np

from papers.long2013.rows import LIMIT_PITCH_DEG, LIMIT_ROLL_DEG, LIMIT_SHARE, printed_figures
from papers.long2013.trials import STRENGTH_NT, LongTrial
from reports.palette import LINES, RAW
from reports.plots.style import Figure, panels


def strength_figure(trial: LongTrial) -> Figure:
    """Draw the field strength before and after calibration, and the deviation after."""
    figure, (top, bottom) = panels(4.6, 2, 1, sharex=True, width_in=7.0)
    sample = np.arange(len(trial.after_nT))
    top.plot(sample, trial.before_nT, color=RAW, label="before")
    top.plot(sample, trial.after_nT, color=LINES[0], label="after")
    top.axhline(STRENGTH_NT, color="0.3", linestyle=":", label="Earth field")
    top.set(ylabel="field strength (nT)", title="Turns about roll, pitch and yaw, then all three together")
    top.set_ylim(top=1.25 * float(trial.before_nT.max()))
    top.legend(ncols=3, loc="upper right")
    bottom.plot(sample, 100 * (trial.after_nT / STRENGTH_NT - 1), color=LINES[0])
    for limit in (-100 * LIMIT_SHARE, 100 * LIMIT_SHARE):
        bottom.axhline(limit, color="0.3", linestyle=":")
    bottom.set(xlabel="sample (a degree each)", ylabel="deviation after (%)", title="After (dotted: the paper's 2 %)")
    return figure


def attitude_figure(trial: LongTrial) -> Figure:
    """Draw roll and pitch errors on the turntable before and after, with and without the alignment of eq. 12."""
    figure, grid = panels(5.6, 2, 2, sharex=True, width_in=7.0)
    limits = (LIMIT_ROLL_DEG, LIMIT_PITCH_DEG)
    for row, (name, limit) in enumerate(zip(("roll", "pitch"), limits, strict=True)):
        grid[row, 0].plot(trial.raw_deg[:, row], color=RAW)
        grid[row, 0].set(ylabel=f"{name} error (degrees)", title=f"{name}, before".capitalize())
        grid[row, 1].plot(trial.corrected_deg[:, row], color=LINES[0], label="aligned (eq. 12)")
        grid[row, 1].plot(trial.unaligned_deg[:, row], color=LINES[1], label="symmetric, not aligned")
        for bound in (-limit, limit):
            grid[row, 1].axhline(bound, color="0.3", linestyle=":")
        grid[row, 1].set(title=f"{name}, after (dotted: the paper's)".capitalize())
    for axis in grid[1]:
        axis.set(xlabel="roll (degrees)")
    grid[0, 1].legend()
    return figure


def noise_figure(by_noise: dict[float, list[LongTrial]]) -> Figure:
    """Draw the largest errors over the printed figures against the noise."""
    figure, axis = panels(3.6, width_in=7.0)
    noises = np.array(list(by_noise))
    figures = [printed_figures(trials) for trials in by_noise.values()]
    parts = zip(
        ("strength / 2 %", "roll / 1 degree", "pitch / 2.2 degrees"),
        (LIMIT_SHARE, LIMIT_ROLL_DEG, LIMIT_PITCH_DEG),
        strict=True,
    )
    for k, (label, limit) in enumerate(parts):
        values = np.array([f[k] for f in figures]) / limit
        axis.plot(noises, np.median(values, axis=1), marker="o", color=LINES[k], label=label)
        axis.fill_between(noises, *np.quantile(values, (0.05, 0.95), axis=1), color=LINES[k], alpha=0.2, linewidth=0)
    axis.axhline(1.0, color="0.3", linestyle=":")
    axis.set(
        xlabel="noise of a component (nT)",
        ylabel="largest error / printed figure",
        xscale="log",
        yscale="log",
        title="What the printed figures bear (median, 5 to 95 % of seeds)",
    )
    axis.legend()
    return figure
