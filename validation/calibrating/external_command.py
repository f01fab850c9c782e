"""A calibrator that is an external program: the recording is written to a file, the calibration read from JSON."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, get_args

import numpy as np

from calib import Calibration, Reference, from_json
from calib.base import unusable
from calib.external import checked
from recordings import Recording, write_recording
from recordings.files import sha256_of
from scenarios.errors import InputError
from scenarios.files import read_text
from validation.calibrating.calibrator_entry import TimedCalibration, failed
from validation.calibrating.program import ProgramExit, run_program

RECORDINGS = {"recording": "recording.parquet", "recording.csv": "recording.csv"}
RESULT, VECTOR = "result", "field_enu_nT"
VARIABLES = {
    "field_strength_nT": "MAGBENCH_FIELD_STRENGTH_NT",
    VECTOR: "MAGBENCH_FIELD_ENU_NT",
    "seed": "MAGBENCH_SEED",
}
"""Values passed to a program, as placeholders and as environment variables."""
KNOWN = (*RECORDINGS, RESULT, *VARIABLES)
PLACEHOLDER = re.compile(r"\{([A-Za-z_][\w.]*)\}")
NAMED = re.compile(r"([A-Za-z][\w.-]*)(?::([\w,]+))?=(.+)", re.DOTALL)
Need = Literal["gyro", "accel", "attitude"]
"""Signals other than the magnetometer that a program may be declared to need."""
DECLARABLE: tuple[Need, ...] = get_args(Need)
MAX_RESULT_BYTES = 2**24
EXAMPLE = "--exec 'NAME=./mycal {recording} {result}'"


@dataclass(frozen=True)
class ExternalCommand:
    """A program given as words with placeholders.

    needs : some of DECLARABLE. time_limit_s : time limit of one fit. sha256 : digests of the files among the words, so
    that a resumed comparison notices a changed program.
    """

    name: str
    words: tuple[str, ...]
    time_limit_s: float
    sha256: tuple[str, ...]
    needs: tuple[str, ...] = ()

    @property
    def uses_vector(self) -> bool:
        """Whether the words hold the placeholder of the field vector."""
        return VECTOR in _placeholders(self.words)

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> TimedCalibration:
        """Run the program on a recording and return the calibration; every failure becomes the status."""
        needs = (*self.needs, *(("field_vector",) if self.uses_vector else ()))
        status = unusable(recording, reference, needs, self.name)
        if status is not None:
            return TimedCalibration(Calibration(name=self.name, status=status), 0.0)
        with TemporaryDirectory(prefix="magbench-", ignore_cleanup_errors=True) as made:
            place = Path(made)
            values = _values(reference, rng)
            files = self._write_inputs(place, recording, values)
            variables = {VARIABLES[key]: text for key, text in values.items()}
            ended = run_program(_filled(self.words, values | files), place, variables, self.time_limit_s)
            found = self._read_result(Path(files[RESULT]), ended)
        return TimedCalibration(replace(found, name=self.name, wall_s=ended.wall_s), ended.cpu_s)

    def _write_inputs(self, place: Path, recording: Recording, values: Mapping[str, str]) -> dict[str, str]:
        """Write the recording and reference.json; return the path of each file placeholder, the result's included."""
        files = {key: str(place / name) for key, name in RECORDINGS.items() if key in _placeholders(self.words)}
        for file in files.values():
            write_recording(recording, Path(file))
        numbers = {key: json.loads(f"[{text}]") for key, text in values.items()}
        reference = {key: several if key == VECTOR else several[0] for key, several in numbers.items()}
        (place / "reference.json").write_text(json.dumps(reference), encoding="utf-8")
        return files | {RESULT: str(place / "result.json")}

    def _read_result(self, result: Path, ended: ProgramExit) -> Calibration:
        """Return the calibration of a result file; status `not_converged` where the program or the file failed."""
        try:
            if ended.failure:
                raise InputError(ended.failure)
            return checked(from_json(_text(result), where=result.name), result.name)
        except InputError as error:
            reason = str(error).replace(f"{result.parent}/", "")
            return failed(self.name, f"{reason}; it said: {ended.output}" if ended.output else reason)


def parse_command(text: str, time_limit_s: float) -> ExternalCommand:
    """Parse an `--exec` text: words as a shell splits them, optionally after NAME= or NAME:NEEDS=.

    Words that name existing files become absolute paths. Raises InputError for a missing program, an unknown
    placeholder, and a text without {recording} or {result}.
    """
    named = NAMED.fullmatch(text.strip())
    name, declared, line = named.groups() if named else ("", None, text)
    try:
        words = shlex.split(line)
    except ValueError as error:
        raise InputError(f"cannot be split into words: {error}", where=f"--exec {text}", do=EXAMPLE) from None
    _check_placeholders(_placeholders(words), f"--exec {text}")
    found = (_program(words[0], text), *map(_whole_path, words[1:]))
    files = (Path(word) for word in found if os.path.isabs(word) and os.path.isfile(word))
    shas = tuple(sha256_of(file) for file in files)
    return ExternalCommand(name or Path(words[0]).stem, found, time_limit_s, shas, _needs(declared, text))


def _needs(declared: str | None, text: str) -> tuple[str, ...]:
    needs = tuple(declared.split(",")) if declared else ()
    if not set(needs) <= set(DECLARABLE):
        do = f"NAME:{DECLARABLE[0]}=..., some of {', '.join(DECLARABLE)}"
        raise InputError(f"needs {declared!r}", where=f"--exec {text}", do=do)
    return needs


def _check_placeholders(used: set[str], where: str) -> None:
    unknown = sorted(used - set(KNOWN))
    if unknown:
        what = f"no placeholder {', '.join(f'{{{one}}}' for one in unknown)}"
        raise InputError(what, where=where, do=f"known are {', '.join(f'{{{one}}}' for one in KNOWN)}")
    if RESULT not in used or not used & set(RECORDINGS):
        what = "does not say where the program finds the recording, and where it writes the result"
        raise InputError(what, where=where, do=EXAMPLE)


def _program(word: str, text: str) -> str:
    """Return the name of a program on the PATH, or the absolute path of a program given by path."""
    found = shutil.which(word)
    if found is None:
        what = "may not be run" if Path(word).is_file() else "no such program"
        do = f"chmod +x {word}" if Path(word).is_file() else "check its name, or give its path (./mycal)"
        raise InputError(f"{word}: {what}", where=f"--exec {text}", do=do)
    return os.path.abspath(found) if os.sep in word else word


def _whole_path(word: str) -> str:
    return os.path.abspath(word) if os.path.exists(word) else word


def _placeholders(words: Sequence[str]) -> set[str]:
    return {key for word in words for key in PLACEHOLDER.findall(word)}


def _values(reference: Reference, rng: np.random.Generator) -> dict[str, str]:
    """Return the values by placeholder, as text; the field vector only where known."""
    values = {"field_strength_nT": repr(float(reference.strength_nT)), "seed": str(int(rng.integers(2**31)))}
    if reference.field_enu_nT is not None:
        values[VECTOR] = ",".join(repr(float(value)) for value in reference.field_enu_nT)
    return values


def _filled(words: Sequence[str], values: Mapping[str, str]) -> list[str]:
    return [PLACEHOLDER.sub(lambda found: values[found[1]], word) for word in words]


def _text(path: Path) -> str:
    """Return the text of the result file; InputError for a missing file, a link, and more than MAX_RESULT_BYTES."""
    if not path.exists():
        raise InputError("the program wrote no result", where=path.name)
    if path.is_symlink() or (path.is_file() and path.stat().st_size > MAX_RESULT_BYTES):
        raise InputError("no file, or longer than a calibration can be", where=path.name)
    return read_text(path, "write a calibration as JSON")
