"""Lines that a serial monitor has stamped: `12:34:56.789 -> 1.0,2.0,3.0`, `[2024-05-01 12:34:56] X: 1.0 Y: 2.0`."""

from __future__ import annotations

import re
from collections.abc import Sequence

import pyarrow as pa
import pyarrow.compute as pc

from recordings.readers.text.dialect import dialect_of
from recordings.readers.text.encoding import EncodedText
from recordings.readers.text.lines import ChosenLines, lines_of
from recordings.readers.text.prints import print_forms
from recordings.readers.text.words import CLOCK, DATE

LEAST_SHARE = 0.8
"""Share of the lines that a monitor has stamped; the others were cut or copied."""
TIME = "time"
"""The name of the column of the stamps."""
_TIME = rf"((?:{DATE}[ T])?{CLOCK})"
STAMP = rf"^\s*(?:\[{_TIME}\]|{_TIME}\s*->|{_TIME}\s*>)\s*"
BARE = rf"^\s*{_TIME}()()[\s,;]+"
"""A time before names and values, which needs no sign of its own."""
_WITH_VALUES = STAMP + r"(?:.*[\s,;|:=\"])?[-+]?\.?\d"


def unstamped(text: EncodedText, lines: Sequence[str], quoted: bool) -> EncodedText:
    """Return a text whose stamps are the first cells, or the first named values, of their lines; as it is if none.

    Before a line without numbers, the header, stands the column's name in place of a stamp.
    """
    pattern = next((pattern for pattern in (STAMP, BARE) if _are_stamped(lines, pattern)), None)
    if pattern is None:
        return text
    rests = [re.sub(pattern, "", line) for line in lines]
    if pattern == BARE and not print_forms(rests):
        return text
    every = lines_of(text.data)
    if print_forms(rests):
        stamped = every.replaced(pattern, rf"{TIME}: \1\2\3 ").text
    else:
        delimiter = dialect_of(rests, quoted).delimiter
        cells = every.replaced(STAMP, rf"\1\2\3{delimiter}").text
        header = every.replaced(STAMP, f"{TIME}{delimiter}").text
        stamped = pc.if_else(pc.match_substring_regex(every.text, _WITH_VALUES), cells, header)
    whole = ChosenLines(pa.array(stamped), every.numbers).joined(text.ended)
    return EncodedText(bytes(whole), text.notes)


def _are_stamped(lines: Sequence[str], pattern: str) -> bool:
    written = [line for line in lines if line.strip()]
    return bool(written) and sum(bool(re.match(pattern, line)) for line in written) >= LEAST_SHARE * len(written)
