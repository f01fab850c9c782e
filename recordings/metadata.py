"""The metadata in a run's Parquet file: seed, scenario and true parameters, so that a file is complete by itself."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import pyarrow.parquet as pq
from pydantic import BaseModel, Field, FiniteFloat, TypeAdapter

from recordings.files import canonical_json, sha256_of, system_errors_about
from recordings.readers import parquet_errors_about
from recordings.url_path import Place, arrow_source
from scenarios.files import validated

METADATA_KEY = "magbench"
RUNS_KEY = "magbench_runs"
"""A list of `FileRun`, in a file of several runs."""
TRACKING_KEY = "magbench_tracking"
"""A key of its own, since the tracking is known only when the run has ended, the rest before."""
FORMAT = 1
_WRITE_AGAIN = "write it again, or give the field with --field-strength-nT or --field-enu-nT"


class TrueParameters(BaseModel, extra="allow", frozen=True):
    """The true parameters of a run: the field, and all else `sim.simulation` writes."""

    field_enu_nT: Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)] | None = None


@dataclass(frozen=True)
class Metadata:
    """The metadata that readers use; a recording written for others has the schema alone, a measured log has none."""

    schema: int = FORMAT
    seed: int | None = None
    run: int | None = None
    scenario_sha256: str | None = None
    parameters: TrueParameters = field(default_factory=TrueParameters)


@dataclass(frozen=True)
class Tracking:
    """Distance between true and reference position at equal times, in m: rms and largest."""

    rms_m: float
    max_m: float


@dataclass(frozen=True)
class RunFile:
    """A finished file as the manifest lists it; tracking is None for a vehicle that follows no path."""

    run: int
    path: str
    rows: int
    bytes: int
    sha256: str
    tracking: Tracking | None = None


@dataclass(frozen=True)
class FileRun:
    """A run in a file of several: number, samples, true parameters and tracking error."""

    run: int
    rows: int
    parameters: TrueParameters
    tracking: Tracking | None = None


_METADATA, _TRACKING, _RUNS = TypeAdapter(Metadata), TypeAdapter(Tracking), TypeAdapter(list[FileRun])


def run_metadata(scenario: Mapping[str, Any], seed: int, run: int, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the metadata of a run's file; `parameters` are the run's true parameters of every effect."""
    return {
        "schema": FORMAT,
        "seed": seed,
        "run": run,
        "scenario": scenario,
        "scenario_sha256": digest_of(scenario),
        "parameters": parameters,
    }


def read_metadata(path: Place) -> Metadata:
    """Return the `magbench` metadata of a Parquet file, empty if missing; InputError for damaged metadata."""
    text = _texts(path).get(METADATA_KEY.encode())
    return (
        Metadata() if text is None else validated(_METADATA, text, f"{path}: metadata {METADATA_KEY!r}", _WRITE_AGAIN)
    )


def run_file(path: Place, run: int, out: Place | None = None) -> RunFile:
    """Describe the finished file of a run, with the path relative to `out`; InputError for a damaged file."""
    text = _texts(path).get(TRACKING_KEY.encode())
    where = f"{path}: metadata {TRACKING_KEY!r}"
    tracking = None if text is None else validated(_TRACKING, text, where, "remove the file, it is made anew")
    with parquet_errors_about(path), arrow_source(path) as source:
        rows = pq.read_metadata(source).num_rows
    with system_errors_about(path, "repeat the command: it resumes"):
        listed = path.relative_to(out or path.parent).as_posix()  # type: ignore[arg-type]
        return RunFile(run, listed, rows, path.stat().st_size, sha256_of(path), tracking)


def file_runs(path: Place, entry: RunFile) -> list[FileRun]:
    """Return the runs of a file in order, with their true parameters; InputError for damaged metadata."""
    texts = _texts(path)
    if RUNS_KEY.encode() in texts:
        where = f"{path}: metadata {RUNS_KEY!r}"
        return validated(_RUNS, texts[RUNS_KEY.encode()], where, "remove the file, it is made anew")
    return [FileRun(entry.run, entry.rows, read_metadata(path).parameters, entry.tracking)]


def runs_in(path: Place) -> tuple[int, ...]:
    """Return the numbers of the runs in a file, empty for a file of no run; InputError for a damaged file."""
    run = read_metadata(path).run
    return () if run is None else tuple(held.run for held in file_runs(path, RunFile(run, "", 0, 0, "")))


def digest_of(scenario: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a scenario's canonical JSON, hexadecimal."""
    return hashlib.sha256(canonical_json(scenario).encode()).hexdigest()


def _texts(path: Place) -> Mapping[bytes, bytes]:
    with parquet_errors_about(path), arrow_source(path) as source:
        return pq.read_metadata(source).metadata or {}
