"""The file calibration.json: write, read, and apply to a recording."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import calib
from calib import Calibration
from calib.models.scalar_terms import CHANNEL
from recordings import Recording, read_recording, write_recording
from recordings.applied import AppliedCalibration
from recordings.files import system_errors_about, write_text
from recordings.reading import Reading
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.files import parsed_json, read_text
from validation.calibrating.correction import corrected
from validation.calibrating.export import FORMATS, exported
from validation.calibrating.fitting import sensor_recordings
from validation.calibrating.output_unit import OutputUnit, in_unit

FILE = "calibration.json"
UNSAFE = re.compile(r"[^\w.@=-]+")
"""Characters of a calibrator with options that a folder's name cannot have on every system."""
WANTED = "give a calibration.json that `magbench calibrate` wrote"


class WrittenCalibrations(NamedTuple):
    """The files by name, and a line for each reason of refused exports."""

    files: tuple[str, ...]
    refused: tuple[str, ...]


def write_calibrations(
    results: Mapping[str, Calibration],
    out: Path,
    forms: Sequence[str] = (),
    *,
    force: bool = False,
    unit: OutputUnit | None = None,
    applied: AppliedCalibration | None = None,
    only: Collection[str] = (),
) -> WrittenCalibrations:
    """Write OUT/calibration.json, {name: calibration}, and each calibration in the export formats `forms`.

    Exports of several calibrations go to folders OUT/NAME/; only : the names to export, by default all.
    force : see `export.exported`.
    unit : of the C header and of a further file, calibration_in_UNIT.json. applied : what the autopilot of the log had
    in force. A refusal keeps back no other file. Raises InputError for a file that cannot be written.
    """
    files = _tables(results, unit)
    chosen = {key: result for key, result in results.items() if key in only or not only}
    refused: dict[str, list[str]] = {}
    for key, form in product(chosen, forms):
        folder = UNSAFE.sub("-", key) + "/" if len(chosen) > 1 else ""
        try:
            name, text = exported(chosen[key], form, force=force, unit=unit, applied=applied)
        except InputError as error:
            refused.setdefault(f"{key}: {error.what} ({error.do})", []).append(form)
            _remove_earlier(out / folder / FORMATS[form].file)
        else:
            files[folder + name] = text
    _write_all(files, out)
    return WrittenCalibrations(tuple(files), tuple(f"{', '.join(forms)} of {why}" for why, forms in refused.items()))


def _tables(results: Mapping[str, Calibration], unit: OutputUnit | None) -> dict[str, str]:
    """Return the JSON files by name: offset and matrix in nT, and in a unit where one is asked for."""
    files = {FILE: json.dumps({k: calib.to_dict(c) for k, c in results.items()}, indent=1, allow_nan=False) + "\n"}
    if unit is not None:
        table = json.dumps(in_unit(results, unit), indent=1, allow_nan=False) + "\n"
        files[f"calibration_in_{unit.measured}.json"] = table
    return files


def _write_all(files: Mapping[str, str], out: Path) -> None:
    """Write texts by name, in folders where a name has one."""
    for name, text in files.items():
        with system_errors_about((out / name).parent, "choose another directory"):
            (out / name).parent.mkdir(parents=True, exist_ok=True)
        write_text(out / name, text)


def _remove_earlier(export: Path) -> None:
    """Remove the export of an earlier calibration, which would be taken for the refused one."""
    with system_errors_about(export, "choose another directory"):
        export.unlink(missing_ok=True)


class RefusedExportsError(InputError):
    """Refused exports; every other file is written.

    calibrations : by name, of all calibrators
    """

    def __init__(self, refused: Sequence[str], calibrations: Any) -> None:
        self.refused, self.calibrations = tuple(refused), calibrations
        super().__init__("not exported: " + "; ".join(refused), where="--export")


def read_calibrations(path: Path) -> dict[str, Calibration]:
    """Read {name: calibration} from a calibration.json, or from a file of a single calibration.

    The JSON output of `run` and `calibrate` and scores.json are read too: key `calibrations`. Raises InputError for a
    file without a calibration and for invalid values.
    """
    data = parsed_json(read_text(path, WANTED, "utf-8-sig"), str(path), WANTED)
    if isinstance(data, dict) and isinstance(data.get("calibrations"), dict):
        data = data["calibrations"]
    if not isinstance(data, dict) or not data:
        raise InputError("holds no calibration", where=str(path), do=WANTED)
    if "matrix" in data:
        data = {str(data.get("name") or "external"): data}
    return {k: calib.from_json(json.dumps(v), name=k, where=f"{path}: {k}") for k, v in data.items()}


def first_ok(calibrations: dict[str, Calibration]) -> str:
    """Return the name of the first calibration whose status is ok, or of the first if none is."""
    usable = (name for name, one in calibrations.items() if one.status.kind == "ok")
    return next(usable, next(iter(calibrations)))


@dataclass(frozen=True, eq=False)
class AppliedFile:
    """A recording corrected by a calibration of a file; of an array each sensor by its own, under `name@1` ...

    used, parts, found : of each sensor the calibration, the recording, and the corrected field (n, 3) or strength (n,).
    """

    calibrator: str
    recording: Recording
    used: Mapping[str, Calibration]
    parts: Mapping[str, Recording]
    found: Mapping[str, Array]

    @property
    def scalar(self) -> bool:
        """Whether a scalar magnetometer's strength was corrected, in place of the field."""
        return next(iter(self.used.values())).corrects_scalar

    def corrected(self) -> Recording:
        """Return the recording with the corrected columns."""
        first, *_ = self.found.values()
        if self.scalar:
            return replace(self.recording, channels={**self.recording.channels, CHANNEL: first})
        array = None if self.recording.array_mag_nT is None else np.stack([*self.found.values()])
        return replace(self.recording, mag_nT=first, array_mag_nT=array)

    def summary(self) -> dict[str, Any]:
        """Return `calibrator`, `samples`, `corrected` (mag or scalar_nT), a `warning` of fits that are not ok."""
        doubts = [f"{key} is {_called(c)}: {c.status.reason}" for key, c in self.used.items() if c.status.kind != "ok"]
        what = CHANNEL if self.scalar else "mag"
        told = {"calibrator": self.calibrator, "samples": len(self.recording), "corrected": what}
        return told | {"warning": "; ".join(doubts)}


def apply_file(
    calibration: Path,
    data: Path,
    out: Path,
    *,
    name: str | None = None,
    run: int = 0,
    reading: Reading | None = None,
) -> AppliedFile:
    """Correct a recording with a calibration of a file and write the result to `out`, .parquet or .csv.

    name : the calibration, by default the first that is ok; for an array each sensor uses its calibration `name@1` ...
    A fit of a scalar magnetometer's terms corrects the channel scalar_nT in place of the field. Raises InputError for
    unusable files, an unknown name, a calibration without an estimate, and an `out` that would replace an input.
    """
    _check_kept(out, (calibration, data))
    known = read_calibrations(calibration)
    recording = read_recording(data, run=run, reading=reading)
    chosen = name or first_ok(known).split("@")[0]
    parts = sensor_recordings(recording, chosen)
    used = {key: _named(known, key, calibration) for key in parts}
    found = {key: corrected(used[key], part, f"{calibration}: {key}") for key, part in parts.items()}
    applied = AppliedFile(chosen, recording, used, parts, found)
    write_recording(applied.corrected(), out)
    return applied


def _called(calibration: Calibration) -> str:
    return calibration.status.kind.replace("_", " ")


def _check_kept(out: Path, sources: Sequence[Path]) -> None:
    """Raise InputError where `out` is a source, or a file in a source directory."""
    for source in sources:
        if out.exists() and source.exists() and (source.samefile(out.parent) or source.samefile(out)):
            raise InputError("would replace what it is made from", where=str(out), do="write to another file")


def _named(known: Mapping[str, Calibration], key: str, where: Path) -> Calibration:
    if key not in known:
        each = "the recording is of an array, each sensor needs its own; " if "@" in key else ""
        names = ", ".join(known)
        raise InputError(f"no calibration {key!r}", where=str(where), do=f"{each}choose with --with among {names}")
    return known[key]
