"""The start of a dataset, new or resumed: which runs are left to simulate."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from importlib.metadata import PackageNotFoundError, version
from itertools import islice
from pathlib import Path
from typing import Any

from recordings.columns import Column
from recordings.description import describe
from recordings.files import canonical_json, remove_leftovers, system_errors_about, write_text
from recordings.manifest import DATA, ELSEWHERE, MANIFEST, Manifest, folders, read_manifest, run_path
from recordings.metadata import FORMAT, RunFile, digest_of, read_metadata, run_file
from recordings.split import Split
from scenarios.errors import InputError

PACKAGES = ("magbench", "mujoco", "numba", "numpy", "ppigrf", "pyarrow", "scipy")
_RUN_FILE = re.compile(r"run-\d{5,}\.parquet")


def open_dataset_for_writing(
    out: Path,
    scenario: Mapping[str, Any],
    seed: int,
    runs: int,
    columns: Sequence[Column],
    warn: Callable[[str], object] = lambda text: None,
    split: Split | None = None,
) -> list[int]:
    """Begin or resume a dataset; return the runs that are still to simulate.

    Half-written files are removed. Runs with a complete file of the same scenario, seed and run number are kept; `runs`
    may grow. A file that differs from its entry in the manifest was changed by hand or by the disk: the run is
    simulated again, which gives the same bytes as the first time, and `warn` gets a message.
    A dataset is not continued with other versions of the packages that decide the numbers.
    Raises InputError, and changes nothing, where the directory holds another dataset or cannot be written.
    """
    new = Manifest(
        FORMAT, False, seed, runs, versions(), json.loads(canonical_json(scenario)), (), tuple(columns), split
    )
    with system_errors_about(out, ELSEWHERE):
        out.mkdir(parents=True, exist_ok=True)
    old = _existing(out, new)
    kept, changed = _kept(out, old, new) if old else ({}, [])
    todo = sorted(set(range(runs)) - set(kept))
    if old and kept and todo:
        _refuse("packages", old.packages, new.packages, out)
    _make_ready(out, new)
    packages = new.packages if old is None or todo else old.packages
    write_text(out / MANIFEST, replace(new, packages=packages, files=tuple(kept.values())).to_json())
    if changed:
        names = ", ".join(changed[:5]) + (", …" if len(changed) > 5 else "")
        warn(f"{out}: not the files that {MANIFEST} lists, so made anew: {names}")
    return todo


def finish_dataset(out: Path, files: Iterable[RunFile] = ()) -> Manifest:
    """Mark a dataset complete; `files` are `run_file` of runs just written, further runs are hashed here.

    The description of a split dataset is written first, see `recordings.description`.
    """
    begun = read_manifest(out)
    known = {entry.run: entry for entry in (*begun.files, *files)}
    entries = tuple(known.get(run) or _file(out, begun, run) for run in range(begun.runs))
    done = replace(begun, complete=True, files=entries)
    if done.split:
        describe(out, done, done.split)
    write_text(out / MANIFEST, done.to_json())
    return done


def _existing(out: Path, new: Manifest) -> Manifest | None:
    """Return the manifest in the directory, None for a new dataset; InputError for a different dataset."""
    if not (out / MANIFEST).exists():
        if any(_RUN_FILE.fullmatch(path.name) for folder in folders(out) for path in folder.iterdir()):
            raise InputError(f"holds run files but no {MANIFEST}", where=str(out), do=ELSEWHERE)
        return None
    old = read_manifest(out)
    _refuse("seed", old.seed, new.seed, out)
    _refuse("scenario", old.scenario, new.scenario, out)
    _refuse("split", old.split and asdict(old.split), new.split and asdict(new.split), out)
    if old.runs > new.runs:
        do = f"ask for {old.runs} runs or more, or {ELSEWHERE}"
        raise InputError(f"holds a dataset of {old.runs} runs, {new.runs} were asked for", where=str(out), do=do)
    return old


def _kept(out: Path, old: Manifest, new: Manifest) -> tuple[dict[int, RunFile], list[str]]:
    """Return the runs with a complete file, equal to its entry in the manifest, and the names of files that differ."""
    whole = {run: file for run in range(new.runs) if (file := _whole(out, new, run)) is not None}
    listed = {file.run: file for file in old.files if run_path(out, file.run, old.split).exists()}
    changed = [run for run, file in sorted(listed.items()) if whole.get(run) != file]
    kept = {run: file for run, file in whole.items() if run not in changed}
    return kept, [run_path(out, run, old.split).name for run in changed]


def _whole(out: Path, dataset: Manifest, run: int) -> RunFile | None:
    """Return the file of a run; None for a file that is unreadable, or of another run or dataset."""
    try:
        found = read_metadata(run_path(out, run, dataset.split))
        wanted = (FORMAT, dataset.seed, run, digest_of(dataset.scenario))
        same = (found.schema, found.seed, found.run, found.scenario_sha256) == wanted
        return _file(out, dataset, run) if same else None
    except InputError:
        return None


def _file(out: Path, dataset: Manifest, run: int) -> RunFile:
    return run_file(run_path(out, run, dataset.split), run, out)


def _make_ready(out: Path, dataset: Manifest) -> None:
    """Make the directories of the runs' files, and remove the half-written files of killed processes."""
    counts = dataset.split.counts(dataset.runs) if dataset.split else {}
    for part in (part for part, runs in counts.items() if runs):
        with system_errors_about(out, ELSEWHERE):
            (out / DATA / part).mkdir(parents=True, exist_ok=True)
    for folder in folders(out):
        remove_leftovers(folder)


def differences(key: str, old: Any, new: Any) -> str:
    """Return the first three differences between plain values, in words; empty for equal values."""
    found = list(islice(_differences(key, old, new), 4))
    return "; ".join(found[:3]) + ("; …" if len(found) > 3 else "")


def _refuse(what: str, old: Any, new: Any, out: Path) -> None:
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
    except PackageNotFoundError:
        return "not installed"
