"""The page of a plan: what it promises, its legs, the attitudes over time and the design behind it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from markupsafe import Markup

from reports.pages.section import figure_html
from reports.pages.template import render_page
from reports.plots.plan import draw_angles, draw_design
from validation.bound.goal import Goal
from validation.planning.next_leg import LegSequence
from validation.planning.next_leg_summary import headline as onward_headline
from validation.planning.next_leg_summary import rows as onward_rows
from validation.planning.plan import Plan
from validation.planning.summary import HEADS, LIMITS, headline, limits, rows
from validation.text import figure, symbol

PICTURES = (
    ("The attitudes over time", "As they are commanded; a vehicle that pushes tilts to either side in turn.",
     draw_angles),
    ("Where the field points in the body", "Blue: the legs, as large as their time. Grey: the optimal design of the "
     "tilts, yaw free; rings: of those that stay in their place. The angle from the body's z axis over the angle "
     "about it.", draw_design),
)  # fmt: skip


def plan_page(found: Plan) -> str:
    """The page as HTML; all of it is inside."""
    tiles = [
        _tile(found.error, found.task.goal),
        (figure(found.ratio), "", "times the limit of its tilts"),
        (figure(found.time_s), "s", "time"),
        (str(len(found.choice.legs)), "", "attitudes"),
    ]
    pictures = [(name, caption, figure_html(partial(draw, found), name)) for name, caption, draw in PICTURES]
    return _rendered(found.scenario.name, headline(found), tiles, rows(found), pictures, limits(found))


def next_leg_page(found: LegSequence) -> str:
    """The page of legs after a recording."""
    told = found.task.error_before if found.error is None else found.error
    tiles = [_tile(told, found.task.goal), (str(len(found.legs)), "", "legs that pay")]
    return _rendered(f"plan-{found.task.name}", onward_headline(found), tiles, onward_rows(found), [])


def _tile(value: float, goal: Goal) -> tuple[str, str, str]:
    return figure(value), symbol(goal.unit), goal.name


def _rendered(
    title: str,
    words: str,
    tiles: Sequence[tuple[str, str, str]],
    table: Sequence[tuple[str, ...]],
    pictures: Sequence[tuple[str, str, Markup]],
    limited: Sequence[tuple[str, ...]] = (),
) -> str:
    values = {"title": title, "lines": words.splitlines(), "tiles": tiles, "heads": HEADS, "rows": table}
    return render_page("plan.html", values | {"pictures": pictures, "limit_heads": LIMITS, "limits": limited})
