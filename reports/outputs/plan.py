"""A plan on disk: the scenario that flies it, the numbers, and a page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from recordings.files import locked_directory, remove_leftovers, write_text
from reports.pages.plan import next_leg_page, plan_page
from scenarios.toml import to_toml
from validation.planning.next_leg import LegSequence
from validation.planning.next_leg_summary import summary as onward_summary
from validation.planning.plan import Plan
from validation.planning.summary import summary


def write_plan(found: Plan | LegSequence, out: Path) -> dict[str, Any]:
    """Write OUT/plan-WHO.toml, plan.json and report.html; returns what plan.json says. InputError where refused.

    Where no leg after a recording pays there is no scenario.
    """
    file = out / f"plan-{found.task.name}.toml"
    named = str(file) if found.scenario else ""
    told = summary(found, named) if isinstance(found, Plan) else onward_summary(found, named)
    with locked_directory(out):
        remove_leftovers(out)
        if found.scenario:
            write_text(file, to_toml(found.scenario))
        write_text(out / "plan.json", json.dumps(told, indent=1, allow_nan=False) + "\n")
        write_text(out / "report.html", plan_page(found) if isinstance(found, Plan) else next_leg_page(found))
    return told
