"""Plot of a gate: value of each trial, and evidence after each trial."""

from __future__ import annotations

from itertools import chain, repeat
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from reports.palette import INK, LINES, RAW
from reports.plots.style import WIDTH_IN, label_decades
from validation.gates.gate_outcome import GateOutcome

KEPT, OVER = LINES[0], LINES[1]


def draw_gate_course(outcome: GateOutcome) -> Figure:
    """Draw each trial's value and the limit; below, evidence for and against the limit, which decides at 1."""
    figure = Figure(figsize=(WIDTH_IN, 4.6))
    values, evidence = figure.subplots(2, 1, sharex=True, gridspec_kw={"hspace": 0.24})
    figure.subplots_adjust(left=0.08, right=0.99, top=0.93, bottom=0.1)
    _draw_values(values, outcome)
    _draw_evidence(evidence, outcome)
    evidence.set_xlabel("trials looked at")
    evidence.xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure


def _draw_values(axis: Any, outcome: GateOutcome) -> None:
    gate, over = outcome.plan.gate, outcome.decision.exceeded
    trial = np.arange(1, len(over) + 1)
    finite = np.isfinite(outcome.values)
    for mask, colour, label in ((~over, KEPT, "within"), (over & finite, OVER, "over the limit")):
        axis.plot(trial[mask], outcome.values[mask], "o", markersize=4, color=colour, label=label)
    for where, label in zip(trial[~finite], chain(["without estimate"], repeat("_")), strict=False):
        axis.axvline(where, color=OVER, linewidth=0.6, alpha=0.5, label=label)
    axis.axhline(gate.factor, color=INK, linewidth=1.0, linestyle="--", label="limit")
    if (outcome.values[finite] > 0).any():
        axis.set_yscale("log")
        label_decades(axis.yaxis)
    unit = gate.unit or ("" if gate.kind == "limit" else f"x {gate.reference or 'baseline'}")
    axis.set_ylabel(", ".join(filter(None, (gate.score_definition.short, unit))))
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2)


def _draw_evidence(axis: Any, outcome: GateOutcome) -> None:
    decision, test = outcome.decision, outcome.plan.test
    trial = np.arange(1, decision.trials + 1)
    for log_evidence, needed, colour, label in (
        (decision.within, test.passing, KEPT, "evidence that the limit is kept"),
        (decision.over, test.failing, OVER, "evidence that the limit is exceeded"),
    ):
        axis.plot(trial, log_evidence / needed, ".-", markersize=3, color=colour, label=label)
    axis.axhline(1.0, color=INK, linewidth=1.0, linestyle="--")
    axis.axhline(0.0, color=RAW, linewidth=0.6)
    axis.set(ylim=(-1.2, 1.2), ylabel="log evidence / needed")
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)
