"""Page of a run: answer, scores, plots, true parameters and provenance."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from reports.pages.section import Section, drawn_sections
from reports.pages.template import render_page
from reports.plots.effects import draw_effect_sizes, draw_effects
from reports.plots.field import MOST_LINES, draw_norm, draw_residuals, draw_sphere
from reports.plots.motion import draw_path, draw_vehicle
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
from scenarios.toml import to_toml
from sim.tracking import warning
from validation.scoring.outcome import Outcome
from validation.text import digits, duration, plainly

PACKAGES = ("magbench", "numpy", "scipy", "mujoco-core", "numba", "filterpy", "ppigrf", "rerun-sdk")


SECTIONS = (
    Section("Error after correction",
            f"Corrected field minus truth, body frame. Best first; each row has its own scale. {ALIGNED}",
            draw_residuals, key="residuals"),
    Section("Field strength over time",
            "Above: raw, corrected and true strength. Below: corrected minus true strength of the best "
            f"{MOST_LINES} calibrators.", draw_norm, key="norm"),
    Section("Raw and corrected field on the sphere",
            "Body frame. The radius of the dashed circle and of the wire sphere is the true strength; colour: "
            "strength minus true strength.", draw_sphere, key="sphere"),
    Section("Size of each effect",
            "Root mean square of each injected contribution, in the order of the chain.",
            draw_effect_sizes, key="sizes"),
    Section("Contribution of each effect over time",
            "Body frame. True field plus all contributions is the measured field. Each panel has its own scale.",
            draw_effects, key="effects"),
    Section("Path", "True position, coloured by phase.", draw_path, lambda outcome: outcome.travels, "path"),
    Section("Attitude, temperature and currents",
            "True attitude (yaw from east, counter-clockwise; a positive pitch lowers the nose), and temperature and "
            "currents as recorded.", draw_vehicle, key="vehicle"),
)  # fmt: skip


def outcome_page(outcome: Outcome) -> str:
    """Return the report of an outcome as self-contained HTML.

    Long recordings are thinned to the least and greatest value of each stretch, so that spikes stay visible.
    """
    return render_page("outcome.html", _page(outcome))


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
        "changes": outcome.asked[1:],
        "figures": _tiles(outcome),
        "aligned": ALIGNED,
        "what": scenario_description(outcome),
        "astray": warning([outcome.tracking]),
        "scores": score_table(outcome),
        "calibrations": [outcome.calibrations[name] for name in outcome.ranking()[0]],
        "sections": drawn_sections(SECTIONS, outcome),
        "parameters": effect_parameters(outcome),
        "surroundings": surroundings(outcome),
        "versions": _versions(),
        "scenario_toml": to_toml(scenario),
    }


def _tiles(outcome: Outcome) -> list[tuple[str, str, str]]:
    """Return the headline figures (value, unit, label)."""
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
    """Return the true parameters as rows (effect, parameter, value), by sensor and in the order of the chain."""
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
    """Return the remaining true values of the run as rows (name, value): field, instruments, notes of the simulator."""
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
