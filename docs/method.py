"""The pictures of `diagnosis-method.md`, and what they show: `tests/test_method.py` draws them again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import shown
from matplotlib.figure import Figure
from method_example import draw_evidence, draw_residual, draw_surrogates
from method_flow import draw_flow

PAGE = Path(__file__).parent / "diagnosis-method.md"
FLOW, MOST_BYTES = "method-flow.png", 60_000
PICTURES: dict[str, Callable[[], Figure]] = {
    FLOW: draw_flow,
    "method-evidence.png": draw_evidence,
    "method-surrogates.png": draw_surrogates,
    "method-residual.png": draw_residual,
}


def kept() -> dict[str, dict[str, Any]]:
    """What each picture shows, for `generated.json`: of the flow its words, with the limits."""
    return {FLOW: {"words": flow_words()}} | {
        name: shown.shown(lambda _, draw=draw: draw(), None) for name, draw in PICTURES.items() if name != FLOW
    }


def flow_words() -> list[str]:
    """The words of the flow, from top to bottom."""
    return [text.get_text() for axis in draw_flow().axes for text in axis.texts if text.get_text()]
