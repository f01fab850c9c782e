"""The page of a plan: what it promises, its legs, the attitudes over time and the design behind it."""

from __future__ import annotations

from functools import partial

from validation.planning.plan import Plan
from validation.planning.words import HEADS, headline, rows
from validation.text import figure, quantity
from validation.views.pages.figure import on_page
from validation.views.pages.template import rendered
from validation.views.plots.plan import draw_angles, draw_design

PICTURES = (
    ("The attitudes over time", "As they are commanded; a vehicle that pushes tilts to either side in turn.",
     draw_angles),
    ("Where the field points in the body", "Blue: the legs, as large as their time. Grey: the optimal design of the "
     "tilts, yaw free. The angle from the body's z axis over the angle about it.", draw_design),
)  # fmt: skip


def page(found: Plan) -> str:
    """The page as HTML; all of it is inside."""
    unit = found.task.goal.unit
    tiles = [
        (*quantity(found.error, unit).rsplit(" ", 1), found.task.goal.name),
        (figure(found.ratio), "", "times the limit of its tilts"),
        (figure(found.time_s), "s", "time"),
        (str(len(found.choice.legs)), "", "attitudes"),
    ]
    return rendered(
        "plan.html",
        {
            "title": found.scenario.name,
            "lines": headline(found).splitlines(),
            "tiles": [tile if len(tile) == 3 else (tile[0], "", tile[1]) for tile in tiles],
            "heads": HEADS,
            "rows": rows(found),
            "pictures": [(name, caption, on_page(partial(draw, found), name)) for name, caption, draw in PICTURES],
        },
    )
