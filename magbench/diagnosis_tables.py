"""A diagnosis as tables for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from magbench.console import show_table, show_text
from reports.presentation.diagnosis import GAP_HEADS, PARAMETER_HEADS, PART_HEADS, PresentedDiagnosis, Row, cells
from reports.presentation.pooled import PresentedPool
from reports.presentation.stated_iron import IRON_HEADS

MOST_DIFF_LINES = 40


def show_answer(found: PresentedDiagnosis | PresentedPool) -> None:
    """A diagnosis of one or of several recordings: words, tables, and the change of the model where it is short."""
    show_text(found.headline + "\n")
    if found.stated:
        iron = [row for one in found.stated for row in one.rows]
        show_table("the stated calibration against each recording", IRON_HEADS, iron, numbers=False)
    if isinstance(found, PresentedPool):
        _show_together(found)
    else:
        _show_diagnosis(found)
    if 0 < len(found.diff) <= MOST_DIFF_LINES:
        show_text("\nthe model's change\n" + "\n".join(found.diff))


def _show_together(found: PresentedPool) -> None:
    """Each effect by recording, and the gaps."""
    for one in found.common:
        show_table(f"{one.name}: {one.reach}", [found.scope.noun, "", *PARAMETER_HEADS], one.rows, numbers=False)
        show_text(one.test + "\n")
    show_table("", [*GAP_HEADS, "by itself"], found.gaps)


def _without_empty(heads: Sequence[str], rows: Sequence[Row]) -> tuple[list[str], list[list[str]]]:
    """Heads and rows without the columns that are empty throughout, such as alternatives where there are none."""
    kept = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    return [heads[k] for k in kept], [[row[k] for k in kept] for row in rows]


def _show_diagnosis(found: PresentedDiagnosis) -> None:
    """Effects, gap, and the parts of the run."""
    rows = [(one.name, ", ".join(one.alternatives), *cells(row)) for one in found.causes for row in one.parameters]
    if rows:
        show_table("missing effects", *_without_empty(["effect", "or", *PARAMETER_HEADS], rows), numbers=False)
    show_table("", GAP_HEADS, found.gaps)
    if found.parts:
        show_table("size of the gap over time", PART_HEADS, found.parts)
