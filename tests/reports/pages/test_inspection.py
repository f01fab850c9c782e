"""The page of an inspection: the same findings as its JSON, pictures where there is enough to draw."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path

import numpy as np
import pytest

from reports.outputs.inspection import write_inspection
from reports.pages.inspection import SECTIONS
from tests.reports.page import faults, figures, plain, read, without_scripts
from tests.validation.inspection.recordings import FIELD_ENU_NT, moved, noise
from validation.inspection.inspection import Inspection, inspect_file, summary

MOTION = moved(1500)


def inspected(folder: Path, samples: int) -> Inspection:
    mag_nT = (MOTION.body(FIELD_ENU_NT) + noise(1500, 5.0))[:samples]
    path = folder / "a<b>.csv"
    columns = np.column_stack([MOTION.time_s[:samples], mag_nT])
    np.savetxt(path, columns, delimiter=",", header="time_s,mag_x_nT,mag_y_nT,mag_z_nT", comments="", fmt="%.9g")
    return inspect_file(path)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Inspection, Path]:
    folder = tmp_path_factory.mktemp("page")
    found = inspected(folder, 1500)
    write_inspection(found, folder / "out")
    return found, folder / "out"


def test_page_and_numbers_are_written_and_nothing_else(written: tuple[Inspection, Path]) -> None:
    found, out = written
    assert sorted(path.name for path in out.iterdir()) == ["inspect.json", "report.html"]
    assert json.loads((out / "inspect.json").read_text(encoding="utf-8")) == summary(found)


def test_every_finding_is_on_the_page(written: tuple[Inspection, Path]) -> None:
    found, out = written
    page = (out / "report.html").read_text(encoding="utf-8")
    text = html.unescape(read(page))
    assert all(plain(finding.text) in text for finding in found.findings)
    assert "a&lt;b&gt;.csv" in page
    assert "a<b>" not in page
    assert not faults(page)


def test_the_page_needs_nothing_from_outside(written: tuple[Inspection, Path]) -> None:
    page = (written[1] / "report.html").read_text(encoding="utf-8")
    assert all(
        link.startswith(("data:image/", "#")) for link in re.findall(r'(?:src|href)="([^"]*)"', without_scripts(page))
    )
    assert figures(page) == len(SECTIONS)


def test_a_short_log_has_few_pictures(tmp_path: Path) -> None:
    write_inspection(inspected(tmp_path, 20), tmp_path / "out")
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert 0 < figures(page) < len(SECTIONS)
    assert "Allan" not in page
