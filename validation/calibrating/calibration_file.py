"""calibration.json: written, read again, and applied to another recording."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import calib
from calib import Calibration
from recordings import read_recording, write_recording
from recordings.files import system_errors_about, write_text
from scenarios.errors import InputError
from scenarios.files import parsed_json, read_text
from validation.calibrating.correction import corrected_field
from validation.calibrating.export import exported
from validation.calibrating.fitting import sensor_recordings

FILE = "calibration.json"
WANTED = "give a calibration.json that `magbench calibrate` wrote"


def write_calibrations(results: Mapping[str, Calibration], out: Path, forms: Sequence[str] = ()) -> None:
    """Write OUT/calibration.json, {name: calibration}, and of each the forms of `validation.calibrating.export`.

    Exports of several calibrations go to folders of their names. Raises InputError, before anything is written, for a
    form that cannot hold a calibration, and when the system refuses.
    """
    files = {FILE: json.dumps({k: calib.to_dict(c) for k, c in results.items()}, indent=1, allow_nan=False) + "\n"}
    for key, result in results.items():
        folder = f"{key}/" if len(results) > 1 else ""
        for form in forms:
            name, text = exported(result, form)
            files[folder + name] = text
    for name, text in files.items():
        with system_errors_about((out / name).parent, "choose another directory"):
            (out / name).parent.mkdir(parents=True, exist_ok=True)
        write_text(out / name, text)


def read_calibrations(path: Path) -> dict[str, Calibration]:
    """Read a calibration.json: one calibration, or {name: calibration}; InputError says what is wrong with it.

    What `run` and `calibrate` print with --json, and scores.json, hold {name: calibration} under `calibrations`.
    """
    data = parsed_json(read_text(path, WANTED, "utf-8-sig"), str(path), WANTED)
    if isinstance(data, dict) and isinstance(data.get("calibrations"), dict):
        data = data["calibrations"]
    if not isinstance(data, dict) or not data:
        raise InputError("holds no calibration", where=str(path), do=WANTED)
    if "matrix" in data:
        data = {str(data.get("name") or "external"): data}
    return {k: calib.from_json(json.dumps(v), name=k, where=f"{path}: {k}") for k, v in data.items()}


def apply_file(
    calibration: Path, data: Path, out: Path, *, name: str | None = None, run: int = 0, maps: Sequence[str] = ()
) -> dict[str, Any]:
    """Correct a recording with one calibration of a file and write it to `out`, .parquet or .csv.

    Of an array every sensor is corrected by its own calibration, `name@1` and so on. Returns what was done, with a
    warning where the calibration is `unobservable`. Raises InputError for files that cannot be used, an unknown name,
    a calibration that gave no estimate, and an `out` that would replace what it is made from.
    """
    _check_kept(out, (calibration, data))
    known = read_calibrations(calibration)
    recording = read_recording(data, run=run, maps=maps)
    chosen = name or next(iter(known)).split("@")[0]
    parts = sensor_recordings(recording, chosen)
    used = {key: _named(known, key, calibration) for key in parts}
    fields = [corrected_field(used[key], part, f"{calibration}: {key}") for key, part in parts.items()]
    array = None if recording.array_mag_nT is None else np.stack(fields)
    write_recording(replace(recording, mag_nT=fields[0], array_mag_nT=array), out)
    doubts = [f"{key} is unobservable: {c.status.reason}" for key, c in used.items() if c.status.kind != "ok"]
    return {"calibrator": chosen, "samples": len(recording), "warning": "; ".join(doubts)}


def _check_kept(out: Path, sources: Sequence[Path]) -> None:
    """Refuse to write over one of the sources, or over a file in one that is a directory."""
    for source in sources:
        if out.exists() and source.exists() and (source.samefile(out.parent) or source.samefile(out)):
            raise InputError("would replace what it is made from", where=str(out), do="write to another file")


def _named(known: Mapping[str, Calibration], key: str, where: Path) -> Calibration:
    if key not in known:
        each = "the recording is of an array, each sensor needs its own; " if "@" in key else ""
        do = f"{each}choose with --with among {', '.join(known)}"
        raise InputError(f"no calibration {key!r}", where=str(where), do=do)
    return known[key]
