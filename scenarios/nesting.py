"""How deep a text nests tables and arrays, counted before a parser takes memory for them."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from scenarios.errors import InputError

MOST_TOML_BYTES = 2_000_000
"""Longer than a scenario of 10,000 poses; the parser takes some two hundred times this in memory."""
MOST_PARTS = 20
"""Parts of a dotted key; the deepest value of a scenario has six."""
MOST_LEVELS = 30
"""Arrays and inline tables within each other."""
_WORDS = re.compile(
    r'"""(?:[^"\\]++|\\.|"(?!""))*+(?:"""|\Z)'
    r"|'''(?:[^']++|'(?!''))*+(?:'''|\Z)"
    r'|"(?:[^"\\\n]++|\\.)*+"?'
    r"|'[^'\n]*+'?"
    r"|\#[^\n]*+",
    re.DOTALL,
)
"""Strings and comments of TOML; one that is not closed reaches to the end of the text or line."""
_ENDS = re.compile(r"[=\n,\[\]{}]")
_LEVELS = re.compile(r"[\[\]{}]")


def parsed_toml(text: str, where: str, do: str) -> dict[str, Any]:
    """Return the tables of a TOML text; InputError for other text, and for one that is long or nested deep."""
    if len(text) > MOST_TOML_BYTES:
        raise InputError(f"is longer than {MOST_TOML_BYTES / 1e6:.3g} MB", where=where, do=do)
    if is_nested_deep(text):
        raise InputError("nested too deep", where=where, do=do)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not TOML: {error}", where=where, do="correct the file there") from None
    except (RecursionError, ValueError):  # a number of thousands of digits
        raise InputError("nested too deep, or a number too long", where=where, do=do) from None


def is_nested_deep(text: str) -> bool:
    """Return whether a key of a TOML text has more than MOST_PARTS parts, or a value more than MOST_LEVELS levels."""
    bare = _WORDS.sub("", text)
    if any(piece.count(".") >= MOST_PARTS for piece in _ENDS.split(bare)):
        return True
    level = 0
    for found in _LEVELS.finditer(bare):
        level = level + 1 if found[0] in "[{" else max(level - 1, 0)
        if level > MOST_LEVELS:
            return True
    return False
