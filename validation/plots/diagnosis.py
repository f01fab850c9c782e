"""Pictures of a diagnosis: the gap before and after, in time, in frequency and against the channel it goes with."""

from __future__ import annotations

import itertools
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from validation.diagnosis.localise import channels
from validation.diagnosis.result import Diagnosis
from validation.plots.style import Figure

BEFORE, AFTER = "#c2513d", "#2a6f97"
MOST_POINTS = 4000
Array = np.ndarray[Any, np.dtype[np.float64]]


def draw_gap(found: Diagnosis) -> Figure:
    """Measured minus simulated over time, before and after, means over parts of the record."""
    labels = ("x", "y", "z") if found.before_nT.shape[1] == 3 else ("|m|",)
    figure: Figure
    figure, axes = plt.subplots(len(labels), 1, figsize=(11, 1.9 * len(labels) + 0.7), sharex=True, squeeze=False)
    time, before, after = (_thin(v) for v in (found.problem.state.time_s[:, None], found.before_nT, found.after_nT))
    for i, axis in enumerate(axes[:, 0]):
        axis.plot(time[:, 0], before[:, i], color=BEFORE, label="before")
        axis.plot(time[:, 0], after[:, i], color=AFTER, label="after")
        axis.set_ylabel(f"{labels[i]} (nT)")
    axes[0, 0].legend(loc="upper right", ncols=2)
    axes[0, 0].set_title("Measured minus simulated")
    axes[-1, 0].set_xlabel("time (s)")
    figure.tight_layout()
    return figure


def draw_spectrum(found: Diagnosis) -> Figure:
    """Power density of the gap before and after, beside the noise that neighbouring samples show."""
    figure: Figure
    figure, axis = plt.subplots(figsize=(11, 3.4))
    interval = found.problem.state.interval_s
    for values, colour, label in ((found.before_nT, BEFORE, "before"), (found.after_nT, AFTER, "after")):
        f, density = _density(values, interval)
        axis.loglog(f, density, color=colour, label=label)
    level = float(np.sqrt((found.problem.sigma_nT**2).mean() * 2 * interval))
    axis.axhline(level, color="#777777", linestyle="--", label="noise of a sample")
    axis.set_xlabel("frequency (Hz)")
    axis.set_ylabel("nT/√Hz")
    axis.legend()
    figure.tight_layout()
    return figure


def draw_channel(found: Diagnosis) -> Figure:
    """The gap against the channels it goes with most, before and after."""
    values = dict(channels(found.problem))
    names = [name for name, _, _ in found.where[:3]] or ["time_s"]
    figure: Figure
    figure, axes = plt.subplots(1, len(names), figsize=(11, 3.2), squeeze=False)
    for axis, name in zip(axes[0], names, strict=True):
        channel = _thin(values[name][:, None])[:, 0]
        for residual, colour in ((found.before_nT, BEFORE), (found.after_nT, AFTER)):
            component = int(np.argmax((_thin(found.before_nT) ** 2).sum(axis=0)))
            axis.plot(channel, _thin(residual)[:, component], ".", markersize=2, color=colour, alpha=0.5)
        axis.set_xlabel(name)
        axis.set_ylabel("nT")
    figure.tight_layout()
    return figure


def draw_ranking(found: Diagnosis) -> Figure:
    """Evidence of every candidate in the first round, on a signed log scale of nats."""
    rows = found.ranking[:12][::-1]
    figure: Figure
    figure, axis = plt.subplots(figsize=(11, 0.3 * max(len(rows), 2) + 1.0))
    axis.barh([name for name, _, _ in rows], [d for _, d, _ in rows], color=AFTER)
    axis.set_xscale("symlog", linthresh=5)
    axis.axvline(np.log(100), color=BEFORE, linestyle="--")
    axis.set_xlabel("evidence on held-out data (nats); accepted beyond the dashed line")
    figure.tight_layout()
    return figure


def _thin(values: Array) -> Array:
    """Means over parts of a record (n, k), at most MOST_POINTS of them."""
    length = max(1, -(-len(values) // MOST_POINTS))
    m = len(values) // length
    return np.asarray(values[: m * length].reshape(m, length, -1).mean(axis=1))


def _density(values: Array, interval_s: float) -> tuple[Array, Array]:
    n = len(values)
    power = (np.abs(np.fft.rfft(values - values.mean(axis=0), axis=0)) ** 2).mean(axis=1) * 2 * interval_s / n
    f = np.fft.rfftfreq(n, interval_s)
    edges = np.unique(np.geomspace(1, len(f) - 1, 300).astype(int))
    cut = list(itertools.pairwise(edges))
    return np.array([f[a:b].mean() for a, b in cut]), np.sqrt(np.array([power[a:b].mean() for a, b in cut]))
