"""A bound over values of one key, on disk: the numbers, and a page that needs nothing else."""

from __future__ import annotations

import json
from pathlib import Path

from reports.outputs.bound import write_bound, write_what_if
from scenarios.sweep import parse_sweep
from sim.scenario import load
from tests.reports.page import figures
from validation.bound.query import BoundQuery, WhatIf


def test_a_page_and_the_numbers(tmp_path: Path) -> None:
    scenario = load("standard-auv", ["phases.0.duration_s=120"])
    found = WhatIf.of(BoundQuery(), scenario, parse_sweep("pitch_amplitude_deg=0:40:20", scenario, "--what-if"))
    write_what_if(found, scenario.name, tmp_path / "out")
    told = json.loads((tmp_path / "out" / "bound.json").read_text())
    assert [point["value"] for point in told["points"]] == [0, 20, 40]
    text = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert figures(text) == 2
    assert "The offset error is least at phases.0.pitch_amplitude_deg = 40" in text


def test_a_single_bound_has_page_and_numbers(tmp_path: Path) -> None:
    found = BoundQuery().of_scenario(load("standard-auv", ["phases.0.duration_s=120"]))
    write_bound(found, "standard-auv", tmp_path / "out")
    assert len(json.loads((tmp_path / "out" / "bound.json").read_text())["offset_std_nT"]) == 3
    text = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert figures(text) == 1
    assert "No method can find the offset better than to" in text
