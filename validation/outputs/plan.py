"""A plan on disk: the scenario that flies it, the numbers, and a page."""

from __future__ import annotations

import json
from pathlib import Path

from scenarios.toml import to_toml
from sim.dataset.files import locked_directory, remove_leftovers, write_text
from validation.planning.plan import Plan
from validation.planning.words import summary
from validation.views.pages.plan import page

FILES = "{}.toml, plan.json, report.html"


def write_plan(found: Plan, out: Path) -> Path:
    """Write OUT/plan-VEHICLE.toml, plan.json and report.html; returns the scenario's file. InputError where refused."""
    file = out / f"{found.scenario.name}.toml"
    with locked_directory(out):
        remove_leftovers(out)
        write_text(file, to_toml(found.scenario))
        write_text(out / "plan.json", json.dumps(summary(found, str(file)), indent=1, allow_nan=False) + "\n")
        write_text(out / "report.html", page(found))
    return file
