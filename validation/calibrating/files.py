"""calibration.json: written, read again, and applied to another recording."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import calib
from calib import Calibration
from scenarios.errors import InputError
from scenarios.files import parsed_json, read_text
from sim.dataset import Recording, read_recording, write_recording
from sim.dataset.files import system_errors_about, write_text
from validation.calibrating.export import exported
from validation.calibrating.fitting import sensors

Array = NDArray[np.float64]
FILE = "calibration.json"
WANTED = "give a calibration.json that `magbench calibrate` wrote"
MAX_CONDITION, MAX_OFFSET_NT = 1e6, 1e9
"""No magnetometer's calibration is near these: such a matrix flattens the field, such an offset is a tesla."""


def write_calibrations(results: Mapping[str, Calibration], out: Path, forms: Sequence[str] = ()) -> None:
    """Write OUT/calibration.json, {name: calibration}, and of each the forms of `validation.calibrating.export`.

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
    parts = sensors(recording, chosen)
    used = {key: _usable(known, key, calibration) for key in parts}
    fields = [_corrected(used[key], part, f"{calibration}: {key}") for key, part in parts.items()]
    array = None if recording.array_mag_nT is None else np.stack(fields)
    write_recording(replace(recording, mag_nT=fields[0], array_mag_nT=array), out)
    doubts = [f"{key} is unobservable: {c.status.reason}" for key, c in used.items() if c.status.kind != "ok"]
    return {"calibrator": chosen, "samples": len(recording), "warning": "; ".join(doubts)}


def _corrected(calibration: Calibration, recording: Recording, where: str) -> Array:
    """The corrected field (n, 3); InputError where the calibration has no inverse at one of the recording's rates."""
    try:
        with np.errstate(all="ignore"):  # what comes of it is looked at as a whole
            field_nT = calibration.apply(recording)
    except (np.linalg.LinAlgError, ArithmeticError):
        field_nT = np.full((len(recording), 3), np.nan)
    wrong = ~np.isfinite(field_nT).all(axis=1)
    if wrong.any():
        what = f"corrects row {int(np.argmax(wrong)) + 1} to no finite field ({np.count_nonzero(wrong)} rows in all)"
        raise InputError(
            what, where=where, do="use another calibration, or leave out the rows that it cannot be used on"
        )
    return field_nT


def _check_kept(out: Path, sources: Sequence[Path]) -> None:
    """Refuse to write over one of the sources, or over a file in one that is a directory."""
    for source in sources:
        if out.exists() and source.exists() and (source.samefile(out.parent) or source.samefile(out)):
            raise InputError("would replace what it is made from", where=str(out), do="write to another file")


def _usable(known: Mapping[str, Calibration], key: str, where: Path) -> Calibration:
    if key not in known:
        each = "the recording is of an array, each sensor needs its own; " if "@" in key else ""
        do = f"{each}choose with --with among {', '.join(known)}"
        raise InputError(f"no calibration {key!r}", where=str(where), do=do)
    found = known[key]
    if found.status.kind in ("not_applicable", "not_converged"):
        raise InputError(f"{key} gave no calibration: {found.status.reason}", where=str(where))
    matrices = np.stack([found.matrix, *(part.matrix for part in found.segments)])
    offsets_nT = np.stack([found.offset_nT, *(part.offset_nT for part in found.segments)])
    if np.linalg.cond(matrices).max() > MAX_CONDITION or np.abs(offsets_nT).max() > MAX_OFFSET_NT:
        what = f"{key} is no calibration: its matrix is singular, or its offset a tesla"
        raise InputError(what, where=str(where), do=WANTED)
    return found
