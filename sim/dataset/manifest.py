"""The manifest of a dataset, `dataset.json`, and what is still to do when a dataset is begun again."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from itertools import islice
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from scenarios.errors import InputError
from scenarios.files import read_text
from sim.dataset.columns import Column
from sim.dataset.files import canonical_json, plain, remove_leftovers, system_errors_about, write_text
from sim.dataset.writer import FORMAT, METADATA_KEY, RunFile, run_file

MANIFEST = "dataset.json"
PACKAGES = ("magbench", "magpylib", "mujoco", "numba", "numpy", "ppigrf", "pyarrow", "scipy")
_RUN_FILE = re.compile(r"run-\d{5,}\.parquet")
_ELSEWHERE = "choose another output directory"


@dataclass(frozen=True)
class Manifest:
    """What `dataset.json` says; the same command on the same installation writes the same bytes."""

    schema: int
    complete: bool
    seed: int
    runs: int
    packages: dict[str, str]
    scenario: dict[str, Any]
    files: tuple[RunFile, ...]
    columns: tuple[Column, ...]

    def to_json(self) -> str:
        """The text of `dataset.json`."""
        return json.dumps(asdict(self), indent=1, allow_nan=False, ensure_ascii=False, default=plain) + "\n"


def read_manifest(out: Path) -> Manifest:
    """Read `dataset.json` of a directory; InputError where it is missing, unreadable or of another version."""
    path = out / MANIFEST
    text = read_text(path, "give a directory that `magbench simulate` wrote")
    try:
        raw = json.loads(text)
        if raw["schema"] != FORMAT:
            raise InputError(f"has schema {raw['schema']}, this version reads {FORMAT}", where=str(path))
        files = tuple(RunFile.read(entry) for entry in raw.pop("files"))
        columns = tuple(Column(**entry) for entry in raw.pop("columns"))
        return Manifest(**raw, files=files, columns=columns)
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise InputError("is not a manifest of a dataset", where=str(path), do=_ELSEWHERE) from error


def run_path(out: Path, run: int) -> Path:
    """File of a run in a dataset directory."""
    return out / f"run-{run:05d}.parquet"


def run_metadata(scenario: Mapping[str, Any], seed: int, run: int, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """What a run's file says of itself; `parameters` are the true parameters of every effect in this run."""
    return {
        "schema": FORMAT,
        "seed": seed,
        "run": run,
        "scenario": scenario,
        "scenario_sha256": _digest(scenario),
        "parameters": parameters,
    }


def read_metadata(path: Path) -> dict[str, Any] | None:
    """The `magbench` metadata of a Parquet file; None where there is none."""
    text = (pq.read_metadata(path).metadata or {}).get(METADATA_KEY.encode())
    return None if text is None else dict(json.loads(text))


def open_dataset_for_writing(
    out: Path, scenario: Mapping[str, Any], seed: int, runs: int, columns: Sequence[Column]
) -> list[int]:
    """Begin or resume a dataset; returns the runs that are still to do.

    Leftovers (`*.part`) are removed. Runs whose file is whole and of this scenario, seed and run number are kept;
    `runs` may grow. A dataset is not continued with other versions of the packages that decide its numbers.
    Raises InputError, and changes nothing, where the directory holds another dataset or cannot be written.
    """
    new = Manifest(FORMAT, False, seed, runs, _versions(), json.loads(canonical_json(scenario)), (), tuple(columns))
    with system_errors_about(out, _ELSEWHERE):
        out.mkdir(parents=True, exist_ok=True)
    old = _existing(out, new)
    done = [run for run in range(runs) if _is_whole(run_path(out, run), new, run)] if old else []
    todo = sorted(set(range(runs)) - set(done))
    if old and done and todo:
        _refuse("packages", old.packages, new.packages, out)
    remove_leftovers(out)
    packages = new.packages if old is None or todo else old.packages
    known = tuple(entry for entry in (old.files if old else ()) if entry.run in done)
    write_text(out / MANIFEST, replace(new, packages=packages, files=known).to_json())
    return todo


def finish_dataset(out: Path, files: Iterable[RunFile] = ()) -> Manifest:
    """Mark a dataset complete; `files` are what `run_file` told of runs just written, others are hashed here."""
    begun = read_manifest(out)
    known = {entry.run: entry for entry in (*begun.files, *files)}
    entries = tuple(known.get(run) or run_file(run_path(out, run), run) for run in range(begun.runs))
    done = replace(begun, complete=True, files=entries)
    write_text(out / MANIFEST, done.to_json())
    return done


def _existing(out: Path, new: Manifest) -> Manifest | None:
    """The manifest that is already there, if it is of the same dataset."""
    if not (out / MANIFEST).exists():
        if any(_RUN_FILE.fullmatch(path.name) for path in out.iterdir()):
            raise InputError(f"holds run files but no {MANIFEST}", where=str(out), do=_ELSEWHERE)
        return None
    old = read_manifest(out)
    _refuse("seed", old.seed, new.seed, out)
    _refuse("scenario", old.scenario, new.scenario, out)
    if old.runs > new.runs:
        do = f"ask for {old.runs} runs or more, or {_ELSEWHERE}"
        raise InputError(f"holds a dataset of {old.runs} runs, {new.runs} were asked for", where=str(out), do=do)
    return old


def _refuse(what: str, old: Any, new: Any, out: Path) -> None:
    differences = list(islice(_differences(what, old, new), 4))
    if differences:
        told_of = "; ".join(differences[:3]) + ("; …" if len(differences) > 3 else "")
        raise InputError(f"holds another dataset: {told_of}", where=str(out), do=_ELSEWHERE)


def _differences(key: str, old: Any, new: Any) -> Iterator[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        for name in sorted(set(old) | set(new)):
            yield from _differences(f"{key}.{name}", old.get(name), new.get(name))
    elif old != new:
        yield f"{key} is {_short(old)} there and {_short(new)} here"


def _short(value: Any) -> str:
    text = "missing" if value is None else canonical_json(value)
    return text if len(text) <= 40 else text[:37] + "…"


def _is_whole(path: Path, dataset: Manifest, run: int) -> bool:
    """Whether the file's footer can be read and says that it is this run of this dataset."""
    try:
        said = read_metadata(path) or {}
    except (OSError, pa.ArrowInvalid, ValueError):
        return False
    wanted = (FORMAT, dataset.seed, run, _digest(dataset.scenario))
    return tuple(said.get(key) for key in ("schema", "seed", "run", "scenario_sha256")) == wanted


def _digest(scenario: Mapping[str, Any]) -> str:
    return hashlib.sha256(canonical_json(scenario).encode()).hexdigest()


def _versions() -> dict[str, str]:
    """Versions of the packages that decide the numbers."""
    return {name: _version(name) for name in PACKAGES}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
