"""Reading of text and JSON files that a user names, with an InputError for every defect."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from scenarios.errors import InputError

Value = TypeVar("Value")
MAX_TEXT_BYTES = 64_000_000
"""Longer than the manifest of 99,999 runs, the longest text that magbench reads."""

MOST_JSON_VALUES = 5_000_000
"""Values of a JSON text, of some 70 bytes of memory each; the manifest of 99,999 runs has 800,000."""


def check_regular(path: Path) -> None:
    """Raise InputError for a pipe, a socket or a device, which may have no end; a missing file passes."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise InputError("is a pipe or a device", where=str(path), do="give a regular file")


def read_text(path: Path, do: str, encoding: str = "utf-8") -> str:
    """Return the text of a file; InputError, with the advice `do`, for an unreadable file."""
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


def parsed_json(text: str | bytes, where: str, do: str) -> Any:
    """Return the plain values of a JSON text; InputError for other texts, NaN, and too many values."""
    if _values(text) > MOST_JSON_VALUES:
        what = f"more than {MOST_JSON_VALUES:.3g} values"
        raise InputError(what, where=where, do=do)
    try:
        return json.loads(text, parse_float=_finite, parse_constant=_finite)
    except RecursionError:
        raise InputError("nested too deep", where=where, do=do) from None
    except ValueError as error:
        raise InputError(f"not JSON: {error}", where=where, do=do) from None


def validated(schema: TypeAdapter[Value], text: str | bytes, where: str, do: str) -> Value:
    """Return the value in a JSON text, of the schema's type; InputError for the first wrong key."""
    parsed_json(text, where, do)
    try:
        return schema.validate_json(text, strict=True)
    except ValidationError as error:
        problem = error.errors(include_url=False)[0]
        place = ": ".join([where, *map(str, problem["loc"])])
        what = problem["msg"][:1].lower() + problem["msg"][1:]
        raise InputError(" ".join(what.split()), where=place, do=do) from None


def _values(text: str | bytes) -> int:
    """Return the number of values of a JSON text, or more where strings hold its signs."""
    if isinstance(text, bytes):
        return sum(map(text.count, (b"[", b"{", b",")))
    return sum(map(text.count, ("[", "{", ",")))


def _finite(word: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(f"{word[:40]} is not a finite number")
    return value
