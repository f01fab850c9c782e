"""The one line with which the program ends on wrong use or bad input."""

from __future__ import annotations

import sys
from shutil import get_terminal_size
from textwrap import fill


def refuse(message: str, status: int = 2) -> int:
    """One line of printable characters on standard error; returns the exit status.

    A terminal gets the line broken between words, where a word is not longer than the terminal is wide.
    """
    line = "magbench: " + "".join(c if c.isprintable() else "?" for c in " ".join(message.split()))
    if sys.stderr.isatty():
        line = fill(line, get_terminal_size().columns, break_long_words=False, break_on_hyphens=False)
    print(line, file=sys.stderr, flush=True)
    return status
