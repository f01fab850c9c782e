"""The report of one outcome: a single HTML page that needs nothing else."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from recordings.files import write_text
from reports.pages.section import figure_html
from reports.pages.template import render_page
from reports.plots.effects import draw_effect_sizes, draw_effects
from reports.plots.field import MOST_LINES, draw_norm, draw_residuals, draw_sphere
from reports.plots.motion import draw_path, draw_vehicle
from reports.plots.style import Draw
from reports.text.outcome import (
    ALIGNED,
    FAILED_LAST,
    ONE_RUN,
    compare_command,
    duration_s,
    failed_calibrators,
    scenario_description,
    score_table,
)
from sim.tracking import warning
from validation.scoring.outcome import Outcome
from validation.text import digits, duration, plainly

PACKAGES = ("magbench", "numpy", "scipy", "mujoco", "numba", "filterpy", "ppigrf", "rerun-sdk")


@dataclass(frozen=True)
class Section:
    """A picture of the report with its heading and what to look for in it."""

    key: str
    title: str
    caption: str
    draw: Draw


SECTIONS = (
    Section("residuals", "What is left after correction",
            f"Corrected field minus truth in the body frame. Best first, each row on its own scale. {ALIGNED}",
            draw_residuals),
    Section("norm", "Field strength over time",
            "Above: raw, corrected and true strength. Below: how far each corrected strength is from the truth "
            f"(the best {MOST_LINES} calibrators).", draw_norm),
    Section("sphere", "Raw and corrected field on the sphere",
            "Body-frame field. The dashed circle and the wire sphere have the true strength as radius; the colour "
            "is each point's distance from it.", draw_sphere),
    Section("sizes", "Size of each effect",
            "Root mean square of each injected contribution, in the order of the chain.", draw_effect_sizes),
    Section("effects", "Contribution of each effect over time",
            "What each effect added to the signal, body frame. True field plus all contributions is the measured "
            "field. Each panel has its own scale.", draw_effects),
    Section("path", "Path", "True position, coloured by phase.", draw_path),
    Section("vehicle", "Attitude, temperature and currents",
            "True attitude (yaw from east, counter-clockwise; a positive pitch lowers the nose) and what the vehicle's "
            "instruments recorded.", draw_vehicle),
)  # fmt: skip


def write_report(outcome: Outcome, path: Path) -> None:
    """Write the report as one HTML file: styles and pictures inside, no outside address.

    Long records are thinned for drawing by least and greatest value, so spikes stay in sight. The file is written
    beside `path` and renamed; on failure nothing is left. Raises InputError where it cannot be written.
    """
    write_text(path, render_page("outcome.html", _page(outcome)))


def _page(outcome: Outcome) -> dict[str, Any]:
    scenario = outcome.scenario
    return {
        "scenario": scenario,
        "sensors": outcome.sensors,
        "answer": outcome.answer(),
        "failures": failed_calibrators(outcome.answer()),
        "failed_last": FAILED_LAST,
        "one_run": ONE_RUN,
        "compare": compare_command(outcome),
        "tiles": _tiles(outcome),
        "aligned": ALIGNED,
        "what": scenario_description(outcome),
        "astray": warning([outcome.tracking]),
        "scores": score_table(outcome),
        "calibrations": [outcome.calibrations[name] for name in outcome.ranking()[0]],
        "pictures": [
            (section, figure_html(partial(section.draw, outcome), section.title))
            for section in SECTIONS
            if _has(section, outcome)
        ],
        "parameters": effect_parameters(outcome),
        "surroundings": surroundings(outcome),
        "versions": _versions(),
        "scenario_json": json.dumps(scenario.model_dump(mode="json", by_alias=True, exclude_unset=True), indent=2),
    }


def _has(section: Section, outcome: Outcome) -> bool:
    """Whether there is something to draw: a path needs a journey."""
    return section.key != "path" or outcome.travels


def _tiles(outcome: Outcome) -> list[tuple[str, str, str]]:
    """Headline figures: (value, unit, label)."""
    ok = sum(c.status.kind == "ok" for c in outcome.calibrations.values())
    length, unit = duration(duration_s(outcome)).split()
    tiles = [
        (length, unit, "duration"),
        (plainly(len(outcome.recording)), "", "samples"),
        (digits(outcome.field_strength_nT, 5), "nT", "field strength"),
        (f"{ok} of {len(outcome.calibrations)}", "", "calibrators ok"),
    ]
    if outcome.tracking is not None:
        tiles.append(
            (
                digits(outcome.tracking.max_m, 2),
                "m",
                f"farthest from the path, rms {digits(outcome.tracking.rms_m, 2)} m",
            )
        )
    return tiles


def effect_parameters(outcome: Outcome) -> list[tuple[str, str, str]]:
    """True parameters as rows (effect, parameter, value), in the order of the chain; of an array, sensor by sensor."""
    tables = outcome.truth.parameters.get("effects", [])
    order = list(outcome.truth.effects)
    rows = []
    for sensor, table in enumerate(tables, start=1):
        mark = f" (sensor {sensor})" if len(tables) > 1 else ""
        for name in sorted(table, key=lambda n: order.index(n) if n in order else len(order)):
            several = table[name] if isinstance(table[name], list) else [table[name]]
            for number, one in enumerate(several, start=1):
                which = f", {number}" if len(several) > 1 else ""
                rows += [(name + which + mark, key, value) for key, value in _flat(one)]
    return rows


def surroundings(outcome: Outcome) -> list[tuple[str, str]]:
    """The other true values of the run, as rows (name, value): field, instruments, whatever the simulator noted."""
    return list(_flat({k: v for k, v in outcome.truth.parameters.items() if k != "effects"}))


def _flat(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", _text(value)


def _text(value: Any) -> str:
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return str(value)
    if isinstance(value, int | float | np.number):
        return plainly(float(value))
    parts = [_text(v) for v in value]
    return "[" + ", ".join(parts) + "]"


def _versions() -> list[tuple[str, str]]:
    found = [("Python", platform.python_version())]
    for package in PACKAGES:
        try:
            found.append((package, version(package)))
        except PackageNotFoundError:
            continue
    return found
