"""The one line with which the program ends on wrong use or bad input."""

from __future__ import annotations

import sys


def refuse(message: str, status: int = 2) -> int:
    """One line of printable characters on standard error; returns the exit status."""
    line = "".join(c if c.isprintable() else "?" for c in " ".join(message.split()))
    print("magbench: " + line, file=sys.stderr, flush=True)
    return status
