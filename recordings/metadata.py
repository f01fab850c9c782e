"""What a run's Parquet file says of itself, so that it can travel alone."""

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
"""Known only when the run has ended, so it stands beside what its file said from the start."""
FORMAT = 1
_WRITE_AGAIN = "write it again, or say with --field-strength-nT or --field-enu-nT what it should tell"


class TrueParameters(BaseModel, extra="allow", frozen=True):
    """The true parameters of a run: the field, and whatever else `sim.simulation` writes."""

    field_enu_nT: Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)] | None = None


@dataclass(frozen=True)
class Metadata:
    """What a reader looks at; a recording written for others tells its schema alone, a file of others nothing."""

    schema: int = FORMAT
    seed: int | None = None
    run: int | None = None
    scenario_sha256: str | None = None
    parameters: TrueParameters = field(default_factory=TrueParameters)


@dataclass(frozen=True)
class Tracking:
    """Distance of the true position from the reference position at the same time: rms and largest, in m."""

    rms_m: float
    max_m: float


@dataclass(frozen=True)
class RunFile:
    """A finished file as the manifest lists it; tracking is None where the vehicle follows no path."""

    run: int
    path: str
    rows: int
    bytes: int
    sha256: str
    tracking: Tracking | None = None


_METADATA, _TRACKING = TypeAdapter(Metadata), TypeAdapter(Tracking)


def run_metadata(scenario: Mapping[str, Any], seed: int, run: int, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """What a run's file says of itself; `parameters` are the true parameters of every effect in this run."""
    return {
        "schema": FORMAT,
        "seed": seed,
        "run": run,
        "scenario": scenario,
        "scenario_sha256": digest_of(scenario),
        "parameters": parameters,
    }


def read_metadata(path: Path) -> Metadata:
    """The `magbench` metadata of a Parquet file, empty where there is none; InputError for what is damaged."""
    text = _texts(path).get(METADATA_KEY.encode())
    return (
        Metadata() if text is None else validated(_METADATA, text, f"{path}: metadata {METADATA_KEY!r}", _WRITE_AGAIN)
    )


def run_file(path: Path, run: int, out: Path | None = None) -> RunFile:
    """Describe the finished file of a run, its path as seen from `out`; InputError for one that is damaged."""
    text = _texts(path).get(TRACKING_KEY.encode())
    where = f"{path}: metadata {TRACKING_KEY!r}"
    tracking = None if text is None else validated(_TRACKING, text, where, "remove the file, it is made anew")
    with parquet_errors_about(path):
        rows = pq.read_metadata(path).num_rows
    with system_errors_about(path, "repeat the command: it resumes"):
        listed = path.relative_to(out or path.parent).as_posix()
        return RunFile(run, listed, rows, path.stat().st_size, sha256_of(path), tracking)


def digest_of(scenario: Mapping[str, Any]) -> str:
    """SHA-256 of a scenario's canonical JSON, hexadecimal."""
    return hashlib.sha256(canonical_json(scenario).encode()).hexdigest()


def _texts(path: Path) -> Mapping[bytes, bytes]:
    with parquet_errors_about(path):
        return pq.read_metadata(path).metadata or {}
