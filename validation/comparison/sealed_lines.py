"""Lines of JSON that begin with a checksum of the rest, so that a damaged line is never read as a result."""

from __future__ import annotations

import hashlib
import json
from typing import Any

DIGITS = 32
"""Hexadecimal digits of a line's checksum: 128 bits of SHA-256."""


def sealed(content: str) -> bytes:
    """Return the text of a JSON object as a line that begins with the checksum of what follows the checksum."""
    rest = content.encode()[1:] + b"\n"
    return _seal(rest) + rest


def matches(line: bytes) -> bool:
    """Return whether a line is as `sealed` made the line."""
    return line[:SEAL_BYTES] == _seal(line[SEAL_BYTES:])


def unsealed(line: bytes) -> dict[str, Any] | None:
    """Return the object of a line, None for a line that does not match its checksum."""
    if not matches(line):
        return None
    found: dict[str, Any] = json.loads(line)
    return found


def _seal(rest: bytes) -> bytes:
    return b'{"sha256":"' + hashlib.sha256(rest).hexdigest()[:DIGITS].encode() + b'",'


SEAL_BYTES = len(_seal(b""))
"""Length of a line's checksum with the bytes around the digits."""
