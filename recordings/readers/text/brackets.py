"""Vectors that a print-out writes in brackets, `mag=[1.0, 2.0, 3.0]`, as three names and values."""

from __future__ import annotations

import re
from collections.abc import Sequence

from recordings.readers.text.encoding import EncodedText
from recordings.readers.text.lines import lines_of
from recordings.readers.text.words import NUMBER

LEAST_SHARE = 0.5
"""Share of the lines that hold a named vector in brackets, in a print-out of such lines."""
LONGEST = 1000
"""Characters of a line that are looked at."""
_BETWEEN = r"\s*[,;\s]\s*"
VECTOR = (
    r'"?([A-Za-z]\w*)"?( ?\([^()]*\))?\s*[:=]?\s*[\[(]\s*'
    rf"({NUMBER}){_BETWEEN}({NUMBER}){_BETWEEN}({NUMBER})\s*[\])]"
)
"""A name, a unit in brackets or none, and three numbers in brackets."""
NAMED = r", \1_x\2=\3, \1_y\2=\4, \1_z\2=\5 "


def unbracketed(text: EncodedText, lines: Sequence[str]) -> EncodedText:
    """Return a text whose vectors in brackets are `mag_x=1.0, mag_y=2.0, mag_z=3.0`; as it is without such lines."""
    written = [line[:LONGEST] for line in lines if line.strip()]
    if not written or sum(bool(re.search(VECTOR, line)) for line in written) < LEAST_SHARE * len(written):
        return text
    return EncodedText(bytes(lines_of(text.data).replaced(VECTOR, NAMED, None).joined(text.ended)), text.notes)
