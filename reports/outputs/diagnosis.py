"""A diagnosis on disk: model.toml, diagnosis.json, report.html and recording.rrd, all of them or none."""

from __future__ import annotations

import json
import re
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from diagnosis.result import Diagnosis
from diagnosis.several.result import PooledDiagnosis
from recordings.files import atomic_write, system_errors_about
from reports.pages.diagnosis import diagnosis_page
from reports.pages.pooled import pooled_page
from reports.viewer.diagnosis import diagnosis_recording
from reports.viewer.pooled import pooled_recording
from scenarios.plain import json_ready
from scenarios.toml import to_toml

FILES = ("report.html", "diagnosis.json", "model.toml", "recording.rrd")
NEXT = "next.toml"
"""Beside them, where a leg is advised."""


def write_diagnosis(found: Diagnosis, out: Path, title: str) -> None:
    """Write FILES into a directory that this process holds (`locked_directory`).

    They are made in memory, written beside, and renamed once all of them are whole, so that files of two diagnoses do
    not stand side by side. Raises InputError where writing is refused.
    """
    summary = json_text(found.as_dict())
    texts = (diagnosis_page(found, title), summary, to_toml(found.model))
    write_whole(out, (*(text.encode() for text in texts), diagnosis_recording(found, title)))
    _write_next(found, out / NEXT)


def _write_next(found: Diagnosis, path: Path) -> None:
    """The scenario to fly next; one of an earlier diagnosis goes."""
    with system_errors_about(path):
        if found.onward is None:
            path.unlink(missing_ok=True)
            return
        with atomic_write(path) as part:
            part.write_text(to_toml(found.onward.scenario), encoding="utf-8")


def write_pooled_diagnosis(found: PooledDiagnosis, out: Path, title: str) -> tuple[str, ...]:
    """Write FILES of several recordings, and each one's own in a folder beside; returns the folders' names."""
    folders = tuple(f"{i:02d}-{_as_folder(name)}" for i, name in enumerate(found.names, start=1))
    for name, folder, own in zip(found.names, folders, found.each, strict=True):
        with system_errors_about(out / folder):
            (out / folder).mkdir(exist_ok=True)
        write_diagnosis(own, out / folder, f"Diagnosis of {name}")
    texts = (pooled_page(found, title, folders), json_text(found.as_dict()), to_toml(found.model))
    write_whole(out, (*(text.encode() for text in texts), pooled_recording(found, title)))
    return folders


def _as_folder(name: str) -> str:
    """A recording's name as a folder's."""
    return re.sub(r"[^\w.-]+", "-", name).strip("-.") or "recording"


def json_text(values: dict[str, Any]) -> str:
    """What `--json` prints, as a file of the directory that holds the model."""
    return json.dumps(json_ready(values) | {"model_out": "model.toml"}, indent=1, allow_nan=False) + "\n"


def write_whole(out: Path, contents: tuple[bytes, ...]) -> None:
    """Write the contents of FILES beside, and rename them once all of them are whole."""
    with ExitStack() as whole:
        for name, content in zip(FILES, contents, strict=True):
            part = whole.enter_context(atomic_write(out / name))
            with system_errors_about(out / name):
                part.write_bytes(content)
