"""The start of a dataset, new or resumed: which runs are left to simulate."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib import metadata
from itertools import islice
from typing import Any

from recordings.columns import Column
from recordings.description import describe
from recordings.files import canonical_json, remove_leftovers, system_errors_about, write_text
from recordings.layout import MOST_FILES, DatasetFile, DatasetLayout
from recordings.manifest import ELSEWHERE, MANIFEST, Manifest, folders, read_manifest
from recordings.metadata import FORMAT, RunFile, digest_of, read_metadata, run_file, runs_in
from recordings.split import Split
from recordings.url_path import Place
from scenarios.errors import InputError

PACKAGES = ("magbench", "mujoco-core", "numba", "numpy", "ppigrf", "pyarrow", "scipy")
_RUN_FILE = re.compile(r"runs?-\d{5,}\.parquet")


@dataclass(frozen=True)
class FileCheck:
    """A file that a dataset should have, to be compared with what is on disk."""

    out: Place
    seed: int
    scenario_sha256: str
    file: DatasetFile


Checked = Iterator[tuple[FileCheck, RunFile | None]]
Checker = Callable[[Sequence[FileCheck]], Checked]
"""Yields each check with the file's description, None for a file that is not whole, in any order."""


def check_file(check: FileCheck) -> RunFile | None:
    """Return the description of a file; None for a file that is unreadable, or of other runs or another dataset."""
    path = check.out / check.file.path
    try:
        found = read_metadata(path)
        wanted = (FORMAT, check.seed, check.file.first, check.scenario_sha256)
        same = (found.schema, found.seed, found.run, found.scenario_sha256) == wanted
        return run_file(path, check.file.first, check.out) if same and runs_in(path) == check.file.runs else None
    except InputError:
        return None


def check_here(checks: Sequence[FileCheck]) -> Checked:
    """Check the files one by one in this process."""
    return ((check, check_file(check)) for check in checks)


def open_dataset_for_writing(
    out: Place,
    scenario: Mapping[str, Any],
    seed: int,
    runs: int,
    columns: Sequence[Column],
    warn: Callable[[str], object] = lambda text: None,
    split: Split | None = None,
    runs_per_file: int = 1,
    checker: Checker = check_here,
) -> list[int]:
    """Begin or resume a dataset; return the first runs of the files that are still to write.

    Half-written files are removed. Complete files of the same scenario, seed and run numbers are kept; `runs` may grow.
    A file that differs from its entry in the manifest was changed by hand or by the disk: its runs are simulated again,
    which gives the same bytes as the first time, and `warn` gets a message.
    A dataset is not continued with other versions of the packages that decide the numbers.
    Raises InputError, and changes nothing, where the directory holds another dataset or cannot be written.
    """
    plain_scenario = json.loads(canonical_json(scenario))
    new = Manifest(FORMAT, False, seed, runs, versions(), plain_scenario, (), tuple(columns), split, runs_per_file)
    _check_number(new.layout, runs)
    with system_errors_about(out, ELSEWHERE):
        out.mkdir(parents=True, exist_ok=True)
    old = _existing(out, new)
    kept, changed = _kept(out, old, new, checker) if old else ({}, [])
    todo = sorted({file.first for file in new.layout.files(runs)} - set(kept))
    if old and kept and todo:
        _refuse("packages", old.packages, new.packages, out)
    _make_ready(out, new)
    packages = new.packages if old is None or todo else old.packages
    files = tuple(kept[first] for first in sorted(kept))
    write_text(out / MANIFEST, replace(new, packages=packages, files=files).to_json())
    _tell_changed(out, changed, warn)
    return todo


def _tell_changed(out: Place, names: Sequence[str], warn: Callable[[str], object]) -> None:
    """Warn about files that differ from their entries in the manifest."""
    if names:
        listed = ", ".join(names[:5]) + (", …" if len(names) > 5 else "")
        warn(f"{out}: not the files that {MANIFEST} lists, so made anew: {listed}")


def finish_dataset(out: Place, files: Iterable[RunFile] = ()) -> Manifest:
    """Mark a dataset complete; `files` are `run_file` of files just written, further files are hashed here.

    The description of a dataset whose rows have the number of the run is written first, see `recordings.description`.
    """
    begun = read_manifest(out)
    known = {entry.run: entry for entry in (*begun.files, *files)}
    wanted = begun.layout.files(begun.runs)
    entries = tuple(known.get(file.first) or run_file(out / file.path, file.first, out) for file in wanted)
    done = replace(begun, complete=True, files=entries)
    describe(out, done)
    write_text(out / MANIFEST, done.to_json())
    return done


def _check_number(layout: DatasetLayout, runs: int) -> None:
    """Raise InputError for more files than a manifest lists."""
    files = layout.count(runs)
    if files > MOST_FILES:
        least = -(-runs // MOST_FILES)
        what = f"{runs} runs in {files} files, a manifest lists {MOST_FILES}"
        raise InputError(what, where="--runs-per-file", do=f"put {least} runs or more into a file")


def _existing(out: Place, new: Manifest) -> Manifest | None:
    """Return the manifest in the directory, None for a new dataset; InputError for a different dataset."""
    if not (out / MANIFEST).exists():
        if any(_RUN_FILE.fullmatch(path.name) for folder in folders(out) for path in folder.iterdir()):
            raise InputError(f"holds run files but no {MANIFEST}", where=str(out), do=ELSEWHERE)
        return None
    old = read_manifest(out)
    _refuse("seed", old.seed, new.seed, out)
    _refuse("scenario", old.scenario, new.scenario, out)
    _refuse("split", old.split and asdict(old.split), new.split and asdict(new.split), out)
    _refuse("runs_per_file", old.runs_per_file, new.runs_per_file, out)
    if old.runs > new.runs:
        do = f"ask for {old.runs} runs or more, or {ELSEWHERE}"
        raise InputError(f"holds a dataset of {old.runs} runs, {new.runs} were asked for", where=str(out), do=do)
    return old


def _kept(out: Place, old: Manifest, new: Manifest, checker: Checker) -> tuple[dict[int, RunFile], list[str]]:
    """Return the complete files, equal to their entries in the manifest, by first run, and the names of others.

    A file that held fewer runs when the dataset was smaller is written anew without a word.
    """
    digest = digest_of(new.scenario)
    there = (file for file in new.layout.files(new.runs) if (out / file.path).exists())
    checks = [FileCheck(out, new.seed, digest, file) for file in there]
    whole = {check.file.first: found for check, found in checker(checks) if found is not None}
    listed = {entry.run: entry for entry in old.files if (out / entry.path).exists()}
    grown = {run for run in listed if old.layout.file_of(run, old.runs) != new.layout.file_of(run, new.runs)}
    changed = [run for run, entry in sorted(listed.items()) if whole.get(run) != entry and run not in grown]
    kept = {run: file for run, file in whole.items() if run not in changed}
    return kept, [listed[run].path.rpartition("/")[2] for run in changed]


def _make_ready(out: Place, dataset: Manifest) -> None:
    """Make the directories of the runs' files, and remove the half-written files of killed processes."""
    for folder in dataset.layout.folders(dataset.runs):
        with system_errors_about(out, ELSEWHERE):
            (out / folder).mkdir(parents=True, exist_ok=True)
    for there in folders(out):
        remove_leftovers(there)


def differences(key: str, old: Any, new: Any) -> str:
    """Return the first three differences between plain values, in words; empty for equal values."""
    found = list(islice(_differences(key, old, new), 4))
    return "; ".join(found[:3]) + ("; …" if len(found) > 3 else "")


def _refuse(what: str, old: Any, new: Any, out: Place) -> None:
    found = differences(what, old, new)
    if found:
        raise InputError(f"holds another dataset: {found}", where=str(out), do=ELSEWHERE)


def _differences(key: str, old: Any, new: Any) -> Iterator[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        for name in sorted(set(old) | set(new)):
            yield from _differences(f"{key}.{name}", old.get(name), new.get(name))
    elif old != new:
        there, here = _shortened(*("missing" if value is None else canonical_json(value) for value in (old, new)))
        yield f"{key} is {there} there and {here} here"


def _shortened(one: str, other: str) -> list[str]:
    """Return two texts, each cut to 40 characters around the first difference."""
    same = next((k for k, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), 0)
    start = max(same - 8, 0) if max(len(one), len(other)) > 40 else 0
    cut = (text[start:] for text in (one, other))
    return [("…" if start else "") + (text if len(text) <= 39 else text[:38] + "…") for text in cut]


def versions() -> dict[str, str]:
    """Return the installed versions of the packages that decide the numbers."""
    return {name: _version(name) for name in PACKAGES}


def _version(name: str) -> str:
    try:
        return version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


@cache
def version(name: str) -> str:
    """Return the version of an installed package; its metadata are parsed once (60 ms for all)."""
    return metadata.version(name)
