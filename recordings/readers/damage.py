"""What a format's library raises about a file, as one error about the file; what it prints is silenced."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

from recordings.url_path import Place
from scenarios.errors import InputError
from scenarios.text import figure

MOST_VALUES = 40_000_000
"""Numbers that a reader takes from one file: 320 MB as float64."""

LEAST_EXPANDED_BYTES, MOST_RATIO = 200_000_000, 50
"""Bytes that a compressed file may hold, or this multiple of its size where more: noise does not compress, and the
columns that never change seldom outnumber the others by fifty."""


@contextmanager
def library_errors_about(path: Path, form: str) -> Iterator[None]:
    """Within, call a format's library alone: whatever it raises becomes an InputError about a damaged file.

    Libraries raise errors of any class over damaged bytes: of their own, KeyError, struct.error, MemoryError.
    """
    try:
        with warnings.catch_warnings(), redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except Exception as error:
        do = "copy or convert it again; a file that was cut off while being written cannot be read"
        raise InputError(f"is cut off or damaged {form}", where=str(path), do=do) from error


def check_values(path: Path, values: int) -> None:
    """Raise InputError for more than MOST_VALUES numbers, before memory is taken for them."""
    if values > MOST_VALUES:
        what = f"holds {figure(values)} numbers, at most {figure(MOST_VALUES)} are read"
        raise InputError(what, where=str(path), do="give a part of the log, or fewer variables")


def check_expansion(path: Place, declared: int) -> None:
    """Raise InputError for a file whose content, in bytes as read, is out of proportion to the file's size."""
    if declared > most_expanded(path.stat().st_size):
        what = f"expands to {figure(declared / 1e6)} MB, more than {MOST_RATIO} times its size"
        raise InputError(what, where=str(path), do="give a part of the log, or fewer variables")


def most_expanded(size: int) -> int:
    """Return the bytes that a file of this size may expand to."""
    return max(LEAST_EXPANDED_BYTES, MOST_RATIO * size)
