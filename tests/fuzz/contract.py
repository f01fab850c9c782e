"""What holds whatever a command is given: a status, at most one line, and nothing half-written or not finite."""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import random
import re
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn
from unittest import mock

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
import pytest
import typer.main
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.strategies import SearchStrategy

from magbench.app import app, call
from recordings.files import sha256_of
from scenarios.errors import InputError
from tests.results import check_printed

PROGRESS = ("simulating", "running", "diagnosis:")
"""How lines begin that tell how far a command has come."""
SO_LONG = re.compile(r"(?!magbench: ).+: (?:\d+ %, )?\d+ s")
"""A line that tells how long a command has worked: every five seconds, so that a busy machine prints one anywhere."""
QUIET = (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning)
"""What Python does not show to users."""
LONGEST_REFUSAL = 700
"""Letters of a refusal at most: a message of 500, and a path."""
NIGHTLY, DAILY_SHARE = 9, 5
"""Some ten thousand cases in the nightly run; every door is tried in the normal run too, with a few hundred in all."""
COMMAND = typer.main.get_command(app)
"""The command line, which typer otherwise makes anew at every call: a third of a case's time."""
amounts = pytest.mark.parametrize("times", [1, pytest.param(NIGHTLY, marks=pytest.mark.slow)])


def fuzz(strategy: SearchStrategy[Any], check: Callable[[Any], None], cases: int, times: int) -> None:
    """Check drawn inputs: in the normal run a few, always the same ones; every night `cases` times `times` others.

    A failure shows the input, shrunk; MAGBENCH_FUZZ_SEED repeats a night.
    """
    number = int(os.environ.get("MAGBENCH_FUZZ_SEED", random.randrange(2**32)))

    @settings(
        max_examples=cases * times if times > 1 else -(-cases // DAILY_SHARE),
        derandomize=times == 1,
        database=None,
        deadline=None,
        print_blob=True,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    @given(strategy)
    def every(case: Any) -> None:
        check(case)

    try:
        (every if times == 1 else seed(number)(every))()
    except BaseException as error:
        error.add_note(f"MAGBENCH_FUZZ_SEED={number}")
        raise


def hold(place: Path, *arguments: str) -> int:
    """Run a command in this process, hold it to the contract, return its status; it writes to `place` alone."""
    out, err = io.StringIO(), io.StringIO()
    with warnings.catch_warnings(record=True) as leaked:
        warnings.simplefilter("always")
        for quiet in QUIET:
            warnings.simplefilter("ignore", quiet)
        made = mock.patch("typer.main.get_command", return_value=COMMAND)
        with made, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = call(list(arguments))
    said = f"{' '.join(arguments)}\nstatus {status}\n{err.getvalue()}"
    assert not leaked, f"{said}\nwarned: {leaked[0].filename}:{leaked[0].lineno}: {leaked[0].message}"
    check_answer(status, out.getvalue(), err.getvalue(), said, as_json="--json" in arguments)
    if status != 2 and "--json" in arguments:
        check_printed(arguments, json.loads(out.getvalue()))
    check_written(place)
    return status


def answered(ask: Callable[[], object]) -> bool:
    """Whether a question to the library had an answer, without a warning; a refusal is short, and told in one line."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for quiet in QUIET:
            warnings.simplefilter("ignore", quiet)
        try:
            ask()
        except InputError as error:
            said = str(error)  # the command line folds what a file says of itself into one line
        else:
            return True
    assert len(said) <= LONGEST_REFUSAL
    return False


NOT_EXPORTED = "--export: not exported"
"""How a refused export begins, whose calibration is told."""


def check_answer(status: int, out: str, err: str, said: str, *, as_json: bool) -> None:
    """Status 2 is one line of printable characters on standard error, and nothing on standard output.

    A calibration that cannot be exported is on standard output all the same.
    """
    assert status in (0, 1, 2), said
    lines = [line for line in err.splitlines() if not (line.startswith(PROGRESS) or SO_LONG.fullmatch(line))]
    assert "Traceback" not in err, said
    if status == 2:
        assert out == "" or NOT_EXPORTED in err, said
        assert len(lines) == 1, said
        assert lines[0].startswith("magbench: "), said
        assert lines[0].isprintable(), said
    elif as_json:
        json.loads(out, parse_constant=_not_finite)


def check_written(place: Path) -> None:
    """Every file is whole, and no number in it is NaN or infinite."""
    for path in place.rglob("*") if place.exists() else ():
        if path.suffix == ".json":
            json.loads(path.read_text(), parse_constant=_not_finite)
        elif path.suffix in (".parquet", ".csv"):
            table = pq.read_table(path, partitioning=None) if path.suffix == ".parquet" else pyarrow.csv.read_csv(path)
            _check_finite(path, table)
        assert path.suffix != ".magbench-part", path


def check_dataset(out: Path) -> None:
    """A dataset that a command was content with is complete, and its files are those that it lists."""
    manifest = json.loads((out / "dataset.json").read_text())
    assert manifest["complete"]
    assert len(manifest["files"]) == manifest["runs"]
    for file in manifest["files"]:
        assert sha256_of(out / file["path"]) == file["sha256"]
        assert pq.read_metadata(out / file["path"]).num_rows == file["rows"]


def _check_finite(path: Path, table: pa.Table) -> None:
    for name in table.column_names:
        column = table.column(name)
        if pa.types.is_floating(column.type):
            assert np.isfinite(column.to_numpy()).all(), f"{path}: {name}"


def _not_finite(word: str) -> NoReturn:
    raise AssertionError(f"{word} was written as JSON: {math.nan}")


def asked(place: Path, *words: str) -> int:
    """Ask a command that writes to `out`; a refusal leaves nothing there."""
    out = place / "out"
    shutil.rmtree(out, ignore_errors=True)
    status = hold(out, *words, "-o", str(out), "--json")
    if status == 2:
        assert not out.exists() or not any(path.is_file() for path in out.rglob("*"))
    return status
