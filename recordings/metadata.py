"""The metadata in a run's Parquet file: seed, scenario and true parameters, so that a file is complete by itself."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import pyarrow.parquet as pq
from pydantic import BaseModel, Field, FiniteFloat, TypeAdapter

from recordings.files import canonical_json, sha256_of, system_errors_about
from recordings.readers import parquet_errors_about
from scenarios.files import validated

METADATA_KEY = "magbench"
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


_METADATA, _TRACKING = TypeAdapter(Metadata), TypeAdapter(Tracking)


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


def read_metadata(path: Path) -> Metadata:
    """Return the `magbench` metadata of a Parquet file, empty if missing; InputError for damaged metadata."""
    text = _texts(path).get(METADATA_KEY.encode())
    return (
        Metadata() if text is None else validated(_METADATA, text, f"{path}: metadata {METADATA_KEY!r}", _WRITE_AGAIN)
    )


def run_file(path: Path, run: int, out: Path | None = None) -> RunFile:
    """Describe the finished file of a run, with the path relative to `out`; InputError for a damaged file."""
    text = _texts(path).get(TRACKING_KEY.encode())
    where = f"{path}: metadata {TRACKING_KEY!r}"
    tracking = None if text is None else validated(_TRACKING, text, where, "remove the file, it is made anew")
    with parquet_errors_about(path):
        rows = pq.read_metadata(path).num_rows
    with system_errors_about(path, "repeat the command: it resumes"):
        listed = path.relative_to(out or path.parent).as_posix()
        return RunFile(run, listed, rows, path.stat().st_size, sha256_of(path), tracking)


def digest_of(scenario: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a scenario's canonical JSON, hexadecimal."""
    return hashlib.sha256(canonical_json(scenario).encode()).hexdigest()


def _texts(path: Path) -> Mapping[bytes, bytes]:
    with parquet_errors_about(path):
        return pq.read_metadata(path).metadata or {}
