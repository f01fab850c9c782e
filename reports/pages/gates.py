"""Gate results as an HTML page, and as Markdown for a pull request."""

from __future__ import annotations

from functools import partial

from reports.pages import section
from reports.pages.template import render_page
from reports.plots.gates import draw_gate_course
from reports.text.gates import HEADS, advice, detectable_defect, gate_rows, headline, sentence
from validation.gates.gate_outcome import GateOutcome
from validation.text import figure


def gates_page(outcomes: list[GateOutcome], title: str, false_fail_rate: float) -> str:
    """Return the page: table of gates, then trials and evidence of each gate."""
    gates = [
        {
            "name": one.plan.gate.name,
            "verdict": one.verdict,
            "sentences": [sentence(one), detectable_defect(one)],
            "advice": advice(one),
            "picture": section.figure_html(partial(draw_gate_course, one), f"trials of {one.plan.gate.name}"),
        }
        for one in outcomes
    ]
    values = {
        "title": title,
        "headline": headline(outcomes),
        "failed": any(one.verdict == "fail" for one in outcomes),
        "runs": figure(1.0 / false_fail_rate),
    }
    return render_page(
        "gates.html", values | {"heads": HEADS, "rows": gate_rows(outcomes, marks=False), "gates": gates}
    )


def gates_markdown(outcomes: list[GateOutcome], title: str) -> str:
    """Return a table of gates, then reason and remedy of each gate that did not pass."""
    rows = [HEADS, ("---",) * len(HEADS), *gate_rows(outcomes)]
    table = "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |\n" for row in rows)
    unsettled = [one for one in outcomes if one.verdict != "pass"]
    notes = "".join(f"- **{one.plan.gate.name}**: {sentence(one)}. {_capital(advice(one))}.\n" for one in unsettled)
    return f"### {title}: {headline(outcomes)}\n\n{table}" + (f"\n{notes}" if notes else "")


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
