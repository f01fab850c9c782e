"""Files of a plan: scenario of the manoeuvre, numbers and page."""

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


def write_plan(plan: Plan | LegSequence, out: Path) -> dict[str, Any]:
    """Write OUT/plan-VEHICLE.toml, plan.json and report.html, and return the content of plan.json.

    No scenario is written where no further leg pays. Raises InputError where the system refuses to write.
    """
    file = out / f"plan-{plan.task.name}.toml"
    named = str(file) if plan.scenario else ""
    written = summary(plan, named) if isinstance(plan, Plan) else onward_summary(plan, named)
    with locked_directory(out):
        remove_leftovers(out)
        if plan.scenario:
            write_text(file, to_toml(plan.scenario))
        write_text(out / "plan.json", json.dumps(written, indent=1, allow_nan=False) + "\n")
        write_text(out / "report.html", plan_page(plan) if isinstance(plan, Plan) else next_leg_page(plan))
    return written
