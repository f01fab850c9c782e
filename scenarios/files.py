"""Reading what a user names: a regular file of a size that can be meant, or one clear line."""

from __future__ import annotations

from pathlib import Path

from scenarios.errors import InputError

MAX_TEXT_BYTES = 64_000_000
"""Longer than the manifest of 99,999 runs; what is longer than that is not a text that magbench reads."""


def check_regular(path: Path) -> None:
    """Refuse a pipe, a socket and a device, which could be read for ever; what is not there is left to the reader."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise InputError("is a pipe or a device", where=str(path), do="give a regular file")


def read_text(path: Path, do: str, encoding: str = "utf-8") -> str:
    """The text of a file; InputError, ending with what to `do`, for what cannot be read."""
    check_regular(path)
    try:
        if path.stat().st_size > MAX_TEXT_BYTES:
            raise InputError(f"is longer than {MAX_TEXT_BYTES // 10**6} MB", where=str(path), do=do)
        return path.read_text(encoding=encoding)
    except OSError as error:
        reason = error.strerror or "not readable"
        raise InputError(reason[0].lower() + reason[1:], where=str(path), do=do) from None
    except UnicodeDecodeError:
        raise InputError("not UTF-8 text", where=str(path), do=do) from None
