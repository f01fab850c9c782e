"""What a diagnosis of several recordings leaves on disk: the lot's four files, and each recording's own beside."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from reports.outputs.diagnosis import FILES, write_pooled_diagnosis
from reports.presentation.pooled import PresentedPool
from sim.scenario import load_model
from tests.diagnosis.several.test_workflow import NAMES, motor, together


@pytest.mark.usefixtures("undrawn")
def test_the_lot_and_each_recording_are_written(tmp_path: Path) -> None:
    found = together(motor(1.0), motor(1.3))
    folders = write_pooled_diagnosis(PresentedPool.of(found), tmp_path, "Diagnosis of 2 recordings")
    assert folders == ("01-first", "02-second")
    for place in (tmp_path, *(tmp_path / folder for folder in folders)):
        assert {one.name for one in place.iterdir() if one.is_file()} == set(FILES)
    page = (tmp_path / "report.html").read_text()
    assert page.index("not transferred") < page.index("The gap of each recording") < page.index("01-first/report.html")
    told = json.loads((tmp_path / "diagnosis.json").read_text())
    assert [one["name"] for one in told["recordings"]] == list(NAMES[:2])
    (effect,) = told["effects"]
    assert effect["evidence"] == "not-transferred"
    assert effect["agreement"]["p"] < 0.01
    low, high = (effect["recordings"][1]["parameters"]["gain_nT_A"][end] for end in ("low", "high"))
    assert all(a < 1.3 * true < b for a, true, b in zip(low, (3.0, -2.0, 4.0), high, strict=True))
    assert "motor_current" in [effect.name for effect in load_model(str(tmp_path / "model.toml")).chain()]
