"""Files of recordings: read a series, check a file, find the viewer program."""

from __future__ import annotations

import subprocess
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from rerun.chunk import RrdReader

from reports.viewer.stream import TIMELINE
from scenarios.arrays import Array
from scenarios.errors import InputError

SCALARS = "Scalars:scalars"


def read_series(path: Path, entity: str) -> tuple[Array, Array]:
    """Return times (n,) in s, to the nanosecond, and values (n,) or (n, k) of a series of a recording.

    Raises InputError for a missing series; the message lists the series of the file.
    """
    store = RrdReader(path).store()
    found = [c.entity_path for c in store.schema().component_columns() if c.component == SCALARS]
    series = {name.replace("\\", "").strip("/"): name for name in found}
    if entity.strip("/") not in series:
        raise InputError(f"no series {entity!r}", where=str(path), do=f"there are: {', '.join(sorted(series))}")
    chunks = store.stream().filter(content=series[entity.strip("/")], components=SCALARS, is_static=False).to_chunks()
    parts = [_columns(chunk.to_record_batch()) for chunk in chunks]
    time_ns, values = np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
    order = np.argsort(time_ns, kind="stable")
    return time_ns[order] / 1e9, values[order]


def _columns(batch: Any) -> tuple[Any, Array]:
    time_ns = batch.column(TIMELINE).to_numpy(zero_copy_only=False).astype("timedelta64[ns]").astype(np.int64)
    flat = batch.column(SCALARS).flatten().to_numpy()
    return time_ns, flat if len(flat) == len(time_ns) else flat.reshape(len(time_ns), -1)


def viewer_program() -> Path:
    """Return the path of rerun's program with viewer and file tools (the script `rerun` is only a launcher).

    Raises InputError where the program was removed, as on a machine that only writes recordings.
    """
    package = find_spec("rerun_cli")
    for folder in (package and package.submodule_search_locations) or ():
        for name in ("rerun", "rerun.exe", "Rerun.app/Contents/MacOS/Rerun"):
            if (Path(folder) / name).is_file():
                return Path(folder) / name
    raise InputError("the viewer's program is not installed", where="rerun", do="reinstall the package rerun-sdk")


def verify(path: Path) -> None:
    """Check with rerun's own command that a recording can be read; raises InputError with the reason."""
    command = [str(viewer_program()), "rrd", "verify", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = next(
            (line for line in done.stderr.splitlines() if "rror" in line or path.name in line), "cannot be read"
        )
        raise InputError(reason.strip(), where=str(path), do="write the recording again")
