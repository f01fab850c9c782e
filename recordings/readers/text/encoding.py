"""The bytes of a text file as UTF-8, whatever the encoding, without a byte order mark and without padding."""

from __future__ import annotations

import codecs
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from recordings.files import system_errors_about
from recordings.readers.base import HEAD_BYTES

PADDING = b"\0\x1a"
"""What preallocated files and old editors leave at the end."""
MOST_CONTROL = 0.01
"""The largest share of control characters in the head of a text; binary formats have a tenth and more."""
_MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
_CONTROL = frozenset(range(32)) - frozenset(b"\t\n\r\f\x1b")


@dataclass(frozen=True, eq=False)
class EncodedText:
    """A text file in UTF-8.

    Parameters
    ----------
    data : the bytes, line ends as in the file.
    notes : what was left out.
    """

    data: bytes
    notes: tuple[str, ...] = ()

    @property
    def ended(self) -> bool:
        """Whether the last line ends with a line break, as complete lines do."""
        return self.data.endswith((b"\n", b"\r"))

    def head(self) -> list[bytes]:
        """Return the whole lines of the first HEAD_BYTES, line ends included."""
        lines = self.data[:HEAD_BYTES].splitlines(keepends=True)
        return lines[:-1] if len(self.data) > HEAD_BYTES and len(lines) > 1 else lines


def text_of(path: Path) -> EncodedText:
    """Read a file; InputError where the operating system refuses."""
    with system_errors_about(path, "check the path and the permissions"):
        return decoded(path.read_bytes())


def decoded(data: bytes) -> EncodedText:
    """Return bytes in UTF-8: from UTF-16 with or without a mark, from UTF-8, else from Latin-1."""
    mark = next((mark for mark in _MARKS if data.startswith(mark)), b"")
    encoding = _MARKS.get(mark) or _wide(data[:HEAD_BYTES]) or "utf-8"
    data = data[len(mark) :] if mark else data
    if encoding != "utf-8":
        data = data.decode(encoding, "replace").encode()
    whole = data.rstrip(PADDING)
    padding = len(data) - len(whole)
    notes = (f"{padding} bytes of padding at the end were left out",) if padding > 1 else ()
    return EncodedText(_valid(whole), notes)


def is_text(head: bytes) -> bool:
    """Return whether the head of a file, in UTF-8, has next to no control characters."""
    controls = sum(head.count(code) for code in _CONTROL)
    return bool(head) and controls <= MOST_CONTROL * len(head)


def _wide(head: bytes) -> str | None:
    """Return the kind of UTF-16, where every other byte of a text in a European language is zero."""
    pairs = np.frombuffer(head[: len(head) // 2 * 2], np.uint8).reshape(-1, 2)
    zero = (pairs == 0).mean(axis=0) if len(pairs) else (0.0, 0.0)
    if zero[1] > 0.8 and zero[0] < 0.2:
        return "utf-16-le"
    return "utf-16-be" if zero[0] > 0.8 and zero[1] < 0.2 else None


def _valid(data: bytes) -> bytes:
    """Return valid UTF-8: as it is, with damaged bytes replaced, or from Latin-1 where the head is no UTF-8 either."""
    if not data or int(np.frombuffer(data, np.uint8).max()) < 128:
        return data
    try:
        codecs.getincrementaldecoder("utf-8")().decode(data[:HEAD_BYTES])
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data.decode("utf-8", "replace").encode()
