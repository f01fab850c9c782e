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
from scenarios.errors import InputError
from scenarios.files import read_text
from sim.dataset import read_recording, write_recording
from sim.dataset.files import told, write_text
from validation.export import exported
from validation.fitting import sensors

FILE = "calibration.json"


def write_calibrations(results: Mapping[str, Calibration], out: Path, forms: Sequence[str] = ()) -> None:
    """Write OUT/calibration.json, {name: calibration}, and of each calibration the forms of `validation.export`.

    Exports of several calibrations go to folders of their names. Raises InputError, before anything is written, for a
    form that cannot hold a calibration, and when the system refuses.
    """
    files = {FILE: json.dumps({k: calib.to_dict(c) for k, c in results.items()}, indent=1, allow_nan=False) + "\n"}
    for key, result in results.items():
        folder = f"{key}/" if len(results) > 1 else ""
        for form in forms:
            name, text = exported(result, form.strip())
            files[folder + name] = text
    for name, text in files.items():
        with told(out, "choose another directory"):
            (out / name).parent.mkdir(parents=True, exist_ok=True)
        write_text(out / name, text)


def read_calibrations(path: Path) -> dict[str, Calibration]:
    """Read a calibration.json: one calibration, or {name: calibration}; InputError says what is wrong with it."""
    text = read_text(path, "give a calibration.json that `magbench calibrate` wrote")
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"not JSON: {error}", where=str(path)) from None
    if not isinstance(data, dict) or not data:
        raise InputError("holds no calibration", where=str(path))
    if "matrix" in data:
        data = {str(data.get("name") or "external"): data}
    return {k: calib.from_json(json.dumps(v), name=k, where=f"{path}: {k}") for k, v in data.items()}


def apply_file(
    calibration: Path, data: Path, out: Path, *, name: str | None = None, run: int = 0, maps: Sequence[str] = ()
) -> dict[str, Any]:
    """Correct a recording with one calibration of a file and write it to `out`, .parquet or .csv.

    Of an array every sensor is corrected by its own calibration, `name@1` and so on. Returns what was done. Raises
    InputError for files that cannot be used, an unknown name, and a calibration that gave no estimate.
    """
    known = read_calibrations(calibration)
    recording = read_recording(data, run=run, maps=maps)
    chosen = name or next(iter(known)).split("@")[0]
    parts = sensors(recording, chosen)
    corrected = {key: _usable(known, key, calibration).apply(one) for key, one in parts.items()}
    fields = list(corrected.values())
    array = None if recording.array_mag_nT is None else np.stack(fields)
    write_recording(replace(recording, mag_nT=fields[0], array_mag_nT=array), out)
    return {"calibrator": chosen, "samples": len(recording)}


def _usable(known: Mapping[str, Calibration], key: str, where: Path) -> Calibration:
    if key not in known:
        raise InputError(f"no calibration {key!r}", where=str(where), do=f"choose with --with among {', '.join(known)}")
    if known[key].status.kind in ("not_applicable", "not_converged"):
        raise InputError(f"{key} gave no calibration: {known[key].status.reason}", where=str(where))
    return known[key]
