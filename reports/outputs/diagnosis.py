"""Files of a diagnosis: model.toml, diagnosis.json, report.html and recording.rrd, all or none."""

from __future__ import annotations

import json
import re
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from recordings.files import atomic_write, system_errors_about
from reports.pages.diagnosis import diagnosis_page
from reports.pages.pooled import pooled_page
from reports.presentation.answer import PresentedAnswer
from reports.presentation.diagnosis import PresentedDiagnosis
from reports.presentation.pooled import PresentedPool
from reports.viewer.diagnosis import diagnosis_recording
from reports.viewer.pooled import pooled_recording
from scenarios.plain import json_ready

FILES = ("report.html", "diagnosis.json", "model.toml", "recording.rrd")
NEXT = "next.toml"
"""Beside them, where a leg is advised."""


def write_diagnosis(found: PresentedDiagnosis, out: Path, title: str) -> None:
    """Write FILES into a directory locked by the process (`locked_directory`).

    The contents are made in memory, written to temporary files, and renamed together, so that a directory never mixes
    two diagnoses. Raises InputError where the system refuses to write.
    """
    write_whole(out, found, diagnosis_page(found, title), diagnosis_recording(found, title))
    _write_next(found.next_flight, out / NEXT)


def _write_next(scenario: str | None, path: Path) -> None:
    """Write the scenario to fly next, or remove the scenario of an earlier diagnosis."""
    with system_errors_about(path):
        if scenario is None:
            path.unlink(missing_ok=True)
            return
        with atomic_write(path) as part:
            part.write_text(scenario, encoding="utf-8")


def write_pooled_diagnosis(pooled: PresentedPool, out: Path, title: str) -> tuple[str, ...]:
    """Write FILES of a pooled diagnosis, and FILES of each recording in a folder beside; return the folders' names."""
    folders = tuple(f"{i:02d}-{_as_folder(name)}" for i, name in enumerate(pooled.names, start=1))
    for name, folder, own in zip(pooled.names, folders, pooled.each, strict=True):
        with system_errors_about(out / folder):
            (out / folder).mkdir(exist_ok=True)
        write_diagnosis(own, out / folder, f"Diagnosis of {name}")
    write_whole(out, pooled, pooled_page(pooled, title, folders), pooled_recording(pooled, title))
    return folders


def _as_folder(name: str) -> str:
    """Return a recording's name as a folder name."""
    return re.sub(r"[^\w.-]+", "-", name).strip("-.") or "recording"


def json_text(values: dict[str, Any]) -> str:
    """Return the JSON of `--json` for a file beside model.toml."""
    return json.dumps(json_ready(values) | {"model_out": "model.toml"}, indent=1, allow_nan=False) + "\n"


def write_whole(out: Path, found: PresentedAnswer, page: str, recording: bytes) -> None:
    """Write the contents of FILES to temporary files, and rename them after the last write."""
    texts = (page, json_text(found.summary), found.model)
    with ExitStack() as whole:
        for name, content in zip(FILES, (*map(str.encode, texts), recording), strict=True):
            part = whole.enter_context(atomic_write(out / name))
            with system_errors_about(out / name):
                part.write_bytes(content)
