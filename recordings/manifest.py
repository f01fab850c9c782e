"""The manifest of a dataset, `dataset.json`, and the paths of the dataset's runs."""

from __future__ import annotations

import json
from dataclasses import asdict
from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, NonNegativeInt, PositiveInt, TypeAdapter
from pydantic.dataclasses import dataclass

from recordings.columns import Column
from recordings.files import remembered_sha256
from recordings.joined_runs import separate_run
from recordings.layout import DATA, DatasetLayout
from recordings.metadata import FORMAT, RunFile
from recordings.readers import marked_file
from recordings.split import PARTS, Split
from recordings.url_path import Place
from scenarios.errors import InputError
from scenarios.files import parsed_json, read_text, validated
from scenarios.plain import plain

MANIFEST = "dataset.json"
ELSEWHERE = "choose another output directory"


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class Manifest:
    """The content of `dataset.json`; equal commands and installations write equal bytes."""

    schema: int
    complete: bool
    seed: NonNegativeInt
    runs: NonNegativeInt
    packages: dict[str, str]
    scenario: dict[str, Any]
    files: tuple[RunFile, ...]
    columns: tuple[Column, ...]
    split: Split | None = None
    runs_per_file: PositiveInt = 1

    @property
    def layout(self) -> DatasetLayout:
        """Where the runs lie."""
        return DatasetLayout(self.split, self.runs_per_file)

    def to_json(self) -> str:
        """Return the text of `dataset.json`; `split` and `runs_per_file` only where stated."""
        content = asdict(self)
        if self.split is None:
            del content["split"]
        if self.runs_per_file == 1:
            del content["runs_per_file"]
        return json.dumps(plain(content), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


_MANIFEST = TypeAdapter(Manifest)


def read_manifest(out: Place) -> Manifest:
    """Read `dataset.json` of a directory; InputError for a missing or damaged file, and for another version."""
    path = out / MANIFEST
    text = _text(path, "give a directory that `magbench simulate` wrote")
    where = f"{path}: is not a manifest of a dataset"
    head = parsed_json(text, where, ELSEWHERE)
    if isinstance(head, dict) and head.get("schema", FORMAT) != FORMAT:
        raise InputError(f"has schema {head['schema']!r}, this version reads {FORMAT}", where=str(path), do=ELSEWHERE)
    return validated(_MANIFEST, text, where, ELSEWHERE)


def run_path(out: Path, run: int, split: Split | None = None, runs_per_file: int = 1) -> Path:
    """Return the file of a run in a dataset directory; in a split dataset, in the directory of the run's part."""
    return out / DatasetLayout(split, runs_per_file).file_of(run).path


def folders(out: Place) -> list[Place]:
    """Return the existing directories in which a dataset, split or not, may have files."""
    tops: list[Place] = [folder for folder in (out, *(out / DATA / part for part in PARTS)) if folder.is_dir()]
    return [*tops, *chain.from_iterable(_shards(top) for top in tops)]


def _shards(top: Place) -> list[Place]:
    """Return the subfolders of a folder of more than FILES_PER_FOLDER files."""
    inside: list[Place] = list(top.iterdir())
    return sorted((path for path in inside if path.name.isdecimal() and path.is_dir()), key=str)


def _text(path: Place, do: str) -> str:
    """Return the text of a manifest; InputError for an unreadable one."""
    if isinstance(path, Path):
        return read_text(path, do)
    try:
        return path.read_text()
    except (OSError, UnicodeDecodeError):
        raise InputError("no such file", where=str(path), do=do) from None


def is_dataset(path: Path) -> bool:
    """Return whether a path is a directory, and no log that consists of several files."""
    return path.is_dir() and marked_file(path) == path


def file_of(path: Path, run: int) -> Path:
    """Return the file that a user names: `path` itself, or a run of the dataset in the directory `path`.

    Of a file that runs share the run is taken out, see `separate_run`.
    Raises InputError for a run that the dataset lacks, and for a file that differs from the SHA-256 in the manifest.
    """
    if not is_dataset(path):
        return path
    manifest = read_manifest(path)
    runs = manifest.runs
    if not 0 <= run < runs:
        do = f"it has runs 0 to {runs - 1}" if runs > 1 else "it has run 0 alone" if runs else "it is empty"
        raise InputError(f"has no run {run}", where=str(path), do=do)
    listed = manifest.layout.file_of(run).path
    file = path / listed
    if not file.exists():
        raise InputError(f"run {run} is not there yet", where=str(path), do="repeat the `simulate` command: it resumes")
    sha256 = next((one.sha256 for one in manifest.files if one.path == listed), None)
    if sha256 is not None and remembered_sha256(file) != sha256:
        do = "repeat the `simulate` command: the file is made anew"
        raise InputError(f"differs from its SHA-256 in {MANIFEST}", where=str(file), do=do)
    return separate_run(file, run) if manifest.runs_per_file > 1 else file
