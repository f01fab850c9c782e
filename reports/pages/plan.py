"""Page of a plan: predicted error, legs, attitudes over time and optimal design."""

from __future__ import annotations

from collections.abc import Sequence

from reports.pages.section import DrawnSection, Section, drawn_sections
from reports.pages.template import render_page
from reports.plots.plan import draw_angles, draw_design, draw_gains
from validation.bound.goal import Goal
from validation.planning.next_leg import LegSequence
from validation.planning.next_leg_summary import headline as onward_headline
from validation.planning.next_leg_summary import rows as onward_rows
from validation.planning.plan import Plan
from validation.planning.summary import HEADS, LIMITS, headline, limits, rows
from validation.text import figure, symbol

SECTIONS = (
    Section("Attitudes over time", "Commanded angles. A vehicle that needs thrust tilts to either side in turn.",
            draw_angles),
    Section("Direction of the field in the body frame",
            "Blue: the legs, area in proportion to time. Grey: the optimal design for the permitted tilts, yaw free. "
            "Rings: the optimal design for attitudes that keep the vehicle in place. Vertical: angle from the body's "
            "z axis; horizontal: angle about the z axis.", draw_design),
)  # fmt: skip
GAINS = (
    Section("Error after each leg", "Least error of the goal after the recording and the legs; grey: no longer pays.",
            draw_gains, lambda sequence: len(sequence.legs) + bool(sequence.idle) > 1),
)  # fmt: skip


def plan_page(plan: Plan) -> str:
    """Return the page of a plan as self-contained HTML."""
    tiles = [
        _tile(plan.error, plan.task.goal),
        (figure(plan.ratio), "", "times the limit of its tilts"),
        (figure(plan.time_s), "s", "time"),
        (str(len(plan.choice.legs)), "", "attitudes"),
    ]
    return _rendered(
        plan.scenario.name, headline(plan), tiles, rows(plan), drawn_sections(SECTIONS, plan), limits(plan)
    )


def next_leg_page(sequence: LegSequence) -> str:
    """Return the page of the legs to fly after a recording."""
    error = sequence.task.error_before if sequence.error is None else sequence.error
    tiles = [_tile(error, sequence.task.goal), (str(len(sequence.legs)), "", "legs that pay")]
    title, sections = f"plan-{sequence.task.name}", drawn_sections(GAINS, sequence)
    return _rendered(title, onward_headline(sequence), tiles, onward_rows(sequence), sections, after=True)


def _tile(value: float, goal: Goal) -> tuple[str, str, str]:
    return figure(value), symbol(goal.unit), f"{goal.short}, rms error at best"


def _rendered(
    title: str,
    words: str,
    figures: Sequence[tuple[str, str, str]],
    table: Sequence[tuple[str, ...]],
    sections: Sequence[DrawnSection],
    limited: Sequence[tuple[str, ...]] = (),
    *,
    after: bool = False,
) -> str:
    values = {"title": title, "lines": words.splitlines(), "figures": figures, "heads": HEADS, "rows": table}
    return render_page(
        "plan.html", values | {"sections": sections, "limit_heads": LIMITS, "limits": limited, "after": after}
    )
