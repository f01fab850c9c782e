"""Colours of pages and recordings, from the palette of Okabe and Ito for colour-blind readers."""

from __future__ import annotations

from validation.scoring.outcome import Outcome

XYZ = ("#0072b2", "#d55e00", "#009e73")
LINES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
BEFORE, AFTER = LINES[1], LINES[0]
"""Gap of the given model, and of the new model."""
INK, RAW, SOFT = "#1b1f24", "#8a929b", "#4b535c"


def phase_colours(outcome: Outcome) -> dict[str, str]:
    """Return the colour of each phase label, in order of first appearance."""
    labels = dict.fromkeys(label for label, _, _ in outcome.phases())
    return {label: LINES[i % len(LINES)] for i, label in enumerate(labels)}


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue (0 to 255) of a colour "#rrggbb"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
