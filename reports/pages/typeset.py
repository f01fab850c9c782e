"""Texts typeset as HTML: code, minus signs, units that stay with their number, names that may break at a line's end."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from markupsafe import Markup, escape

CODE = re.compile(r"(`[^`]+`|(?<![\w`-])--[a-z][\w-]+)")
"""What stands between backticks, and an option of the command line."""
MINUS = re.compile(r"(?<![\w.)\]&;#-])-(?=\d)")
"""The sign of a number: not a hyphen in a date, a name or an exponent."""
UNIT = re.compile(r"(?<=\d) (?=%|(?:nT|µT|nT/A|s|ms|min|h|d|Hz|m|nats|sigma)\b)")
"""The space between a number and its unit."""
DEGREES = re.compile(r"(?<=\d) deg\b")
TEXT = re.compile(r"(?:\b[^\W\d_]{2,}\b\W+){2,}[^\W\d_]{2,}")
"""Three words, which a cell of figures does not have."""


def coded(text: Any) -> Any:
    """Return a text as HTML: backticks and options as code, numbers typeset; whatever is no text as it is."""
    if not isinstance(text, str) or isinstance(text, Markup):
        return text
    parts = enumerate(CODE.split(text))
    return Markup("").join(
        Markup("<code>{}</code>").format(part.strip("`")) if k % 2 else _numbers(part) for k, part in parts
    )


def _numbers(text: str) -> Markup:
    text = MINUS.sub("\N{MINUS SIGN}", UNIT.sub("\N{NO-BREAK SPACE}", DEGREES.sub("°", text)))
    return escape(text)


def breakable(name: str) -> Markup:
    """Return a name that a narrow tile may break after underscores and dots between letters."""
    return Markup(re.sub(r"(?<=[_.])(?=[A-Za-z])", "<wbr>", str(escape(name))))


def columns_of_text(rows: Sequence[Sequence[str]]) -> set[int]:
    """Return the numbers of the columns that stand at the left: the first, and those with sentences."""
    return {0} | {k for row in rows for k, cell in enumerate(row) if TEXT.search(str(cell))}
