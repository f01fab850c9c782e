"""The bench's report: figures against the bar, the whole confusion matrix, and every miss."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from benchmarks.diagnosis.score import confusion, failures, figures

BAR: tuple[tuple[str, str, float, bool], ...] = (
    ("null, white", "named", 0.01, False),
    ("null, coloured", "named", 0.02, False),
    ("single, 0.1 sigma", "in_class", 0.85, True),
    ("single, 0.1 sigma", "confidently_wrong", 0.02, False),
    *(
        (f"single, {s} sigma", what, limit, least)
        for s in ("0.3", "1")
        for what, limit, least in (
            ("in_class", 0.95, True), ("first_right", 0.92, True), ("one_name", 0.85, True),
            ("class_size", 1.5, False), ("extra_names", 0.05, False), ("confidently_wrong", 0.005, False),
        )
    ),
    ("left out", "misnamed", 0.01, False),
    ("outside the library", "unknown", 0.95, True),
    ("outside the library", "driver_in_first_two", 0.7, True),
    ("two effects, 1 to 1", "both", 0.9, True),
    ("two effects, 1 to 1", "extra_names", 0.1, False),
    ("two effects, 3 to 1", "both", 0.8, True),
    ("two effects, 3 to 1", "extra_names", 0.1, False),
    ("wide null, white", "named", 0.01, False),
    ("wide null, coloured", "named", 0.02, False),
    ("measured rest, shifted", "named", 0.02, False),
    ("measured rest, random phases", "named", 0.02, False),
    ("wide single, 0.1 sigma", "in_class", 0.85, True),
    ("wide single, 0.1 sigma", "confidently_wrong", 0.02, False),
    *(
        (f"wide single, {s} sigma", what, limit, least)
        for s in ("0.3", "1")
        for what, limit, least in (
            ("in_class", 0.95, True), ("first_right", 0.92, True), ("one_name", 0.85, True),
            ("class_size", 1.5, False), ("extra_names", 0.05, False), ("confidently_wrong", 0.005, False),
        )
    ),
    ("wide left out", "misnamed", 0.01, False),
    ("wide two effects, 1 to 1", "both", 0.85, True),
    ("wide two effects, 1 to 1", "extra_names", 0.05, False),
    ("gap", "median", 0.97, True),
    ("gap", "tenth_percentile", 0.85, True),
    ("seconds", "slowest", 30.0, False),
)  # fmt: skip
"""Group, figure, limit, whether it is a least one."""


def write_report(rows: Sequence[dict[str, Any]], out: Path, seeds: str) -> dict[str, Any]:
    """Write report.md, confusion.png and figures.json; returns the figures."""
    found = figures(rows)
    (out / "figures.json").write_text(json.dumps(found, indent=1) + "\n")
    _draw(rows, out / "confusion.png")
    lines = [
        f"# Diagnosis bench: {len(rows)} trials, {seeds}",
        "",
        "| group | figure | value | bar | |",
        "|---|---|---|---|---|",
    ]
    lines += [_line(found, *row) for row in BAR if row[0] in found]
    lines += ["", "![what was named first](confusion.png)", "", "```json", json.dumps(found, indent=1), "```", ""]
    lines += ["## Every miss", "", *(f"- {line}" for line in failures(rows)), ""]
    (out / "report.md").write_text("\n".join(lines))
    return found


def _line(found: dict[str, Any], group: str, what: str, limit: float, least: bool) -> str:
    value = found[group][what]
    holds = value is not None and (value >= limit if least else value <= limit)
    sign = "at least" if least else "at most"
    shown = "none" if value is None else f"{value:.3g}"
    return f"| {group} | {what.replace('_', ' ')} | {shown} | {sign} {limit:g} | {'holds' if holds else '**missed**'} |"


def _draw(rows: Sequence[dict[str, Any]], path: Path) -> None:
    hidden, columns, count = confusion(rows)
    if not hidden:
        return
    figure, axes = plt.subplots(figsize=(0.36 * len(columns) + 3, 0.32 * len(hidden) + 2.5), layout="constrained")
    axes.imshow(count / count.sum(axis=1, keepdims=True), cmap="Blues", vmin=0, vmax=1)
    axes.set_xticks(range(len(columns)), columns, rotation=90)
    axes.set_yticks(range(len(hidden)), hidden)
    for i, j in zip(*count.nonzero(), strict=True):
        share = count[i, j] / count[i].sum()
        axes.text(
            j, i, f"{count[i, j]:.0f}", ha="center", va="center", fontsize=7, color="white" if share > 0.5 else "k"
        )
    axes.set(xlabel="named first", ylabel="hidden")
    figure.savefig(path, dpi=110)
    plt.close(figure)
