"""The exception for wrong use and bad input: what is wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

MOST_LETTERS = 500
"""Letters of a message: what a file says of itself, quoted, may be of any length."""
LEAST_LETTERS = 150
"""Letters that each of the three parts of a message keeps."""


class InputError(ValueError):
    """Wrong use or bad input, described in one line.

    Parameters
    ----------
    what : what was found and what was expected.
    where : file and key, option or column.
    do : what the user can do.

    The message has at most MOST_LETTERS letters: the longest part is shortened in its middle.
    """

    def __init__(self, what: str, *, where: str = "", do: str = "") -> None:
        self.what, self.where, self.do = what, where, do
        where, what, do = _shortened([where, what, do])
        super().__init__(": ".join(filter(None, (where, what))) + (f" ({do})" if do else ""))

    def _render_traceback_(self) -> list[str]:
        """Return the lines that a notebook (IPython) shows in place of a traceback: the caller's own line is known."""
        return [f"InputError: {self}"]


def _shortened(parts: list[str]) -> list[str]:
    """Return the parts of a message, of MOST_LETTERS letters together with the signs between them."""
    for _ in parts:
        over = sum(map(len, parts)) + len(": ()") + 1 - MOST_LETTERS
        if over > 0:
            longest = max(range(len(parts)), key=lambda k: len(parts[k]))
            parts[longest] = _cut(parts[longest], max(len(parts[longest]) - over, LEAST_LETTERS))
    return parts


def _cut(text: str, letters: int) -> str:
    """Return a text of this many letters, the middle left out."""
    end = (letters - 3) // 2
    return f"{text[: letters - 3 - end]}...{text[-end:]}"


@contextmanager
def errors_relocated(where: str, instead_of: str) -> Iterator[None]:
    """Give InputErrors located at `instead_of` the location `where`, which identifies a recording among several."""
    try:
        yield
    except InputError as error:
        if error.where != instead_of:
            raise
        raise InputError(error.what, where=where, do=error.do) from None
