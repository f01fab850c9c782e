"""A diagnosis on disk: model.toml, diagnosis.json, report.html and recording.rrd, all of them or none."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path

from scenarios.plain import json_ready
from scenarios.toml import to_toml
from sim.dataset.files import beside, system_errors_about
from validation.diagnosis.result import Diagnosis
from validation.views.pages.diagnosis import page_html
from validation.views.recording.diagnosis import diagnosis_recording

FILES = ("report.html", "diagnosis.json", "model.toml", "recording.rrd")


def write_diagnosis(found: Diagnosis, out: Path, title: str) -> None:
    """Write FILES into a directory that this process holds (`locked_directory`).

    They are made in memory, written beside, and renamed once all of them are whole, so that files of two diagnoses do
    not stand side by side. Raises InputError where writing is refused.
    """
    summary = json.dumps(json_ready(found.as_dict()) | {"model_out": "model.toml"}, indent=1, allow_nan=False) + "\n"
    texts = (page_html(found, title), summary, to_toml(found.model))
    contents = (*(text.encode() for text in texts), diagnosis_recording(found, title))
    with ExitStack() as whole:
        for name, content in zip(FILES, contents, strict=True):
            part = whole.enter_context(beside(out / name))
            with system_errors_about(out / name):
                part.write_bytes(content)
