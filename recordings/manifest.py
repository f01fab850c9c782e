"""The manifest of a dataset, `dataset.json`, and the paths of the dataset's runs."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, NonNegativeInt, TypeAdapter
from pydantic.dataclasses import dataclass

from recordings.columns import Column
from recordings.metadata import FORMAT, RunFile
from recordings.readers import marked_file
from recordings.split import PARTS, Split
from scenarios.errors import InputError
from scenarios.files import parsed_json, read_text, validated
from scenarios.plain import plain

MANIFEST = "dataset.json"
DATA = "data"
"""Directory of a split dataset's files, and of nothing else, so that other readers can open the directory whole."""
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

    def to_json(self) -> str:
        """Return the text of `dataset.json`, with `split` where the dataset is split."""
        content = asdict(self)
        if self.split is None:
            del content["split"]
        return json.dumps(plain(content), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


_MANIFEST = TypeAdapter(Manifest)


def read_manifest(out: Path) -> Manifest:
    """Read `dataset.json` of a directory; InputError for a missing or damaged file, and for another version."""
    path = out / MANIFEST
    text = read_text(path, "give a directory that `magbench simulate` wrote")
    where = f"{path}: is not a manifest of a dataset"
    head = parsed_json(text, where, ELSEWHERE)
    if isinstance(head, dict) and head.get("schema", FORMAT) != FORMAT:
        raise InputError(f"has schema {head['schema']!r}, this version reads {FORMAT}", where=str(path), do=ELSEWHERE)
    return validated(_MANIFEST, text, where, ELSEWHERE)


def run_path(out: Path, run: int, split: Split | None = None) -> Path:
    """Return the file of a run in a dataset directory; in a split dataset, in the directory of the run's part."""
    return out / _name(run) if split is None else out / DATA / split.part_of(run) / _name(run)


def folders(out: Path) -> list[Path]:
    """Return the existing directories in which a dataset, split or not, may have files."""
    return [folder for folder in (out, *(out / DATA / part for part in PARTS)) if folder.is_dir()]


def file_of(path: Path, run: int) -> Path:
    """Return the file that a user names: `path` itself, or a run of the dataset in the directory `path`.

    Raises InputError for a run that the dataset lacks.
    """
    if not path.is_dir() or marked_file(path) != path:
        return path
    files = [file for folder in folders(path) if (file := folder / _name(run)).exists()]
    runs = read_manifest(path).runs
    if not 0 <= run < runs:
        do = f"it has runs 0 to {runs - 1}" if runs > 1 else "it has run 0 alone" if runs else "it is empty"
        raise InputError(f"has no run {run}", where=str(path), do=do)
    if not files:
        raise InputError(f"run {run} is not there yet", where=str(path), do="repeat the `simulate` command: it resumes")
    return files[0]


def _name(run: int) -> str:
    return f"run-{run:05d}.parquet"
