"""The exception for wrong use and bad input: what is wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class InputError(ValueError):
    """Wrong use or bad input, described in one line.

    Parameters
    ----------
    what : what was found and what was expected.
    where : file and key, option or column.
    do : what the user can do.
    """

    def __init__(self, what: str, *, where: str = "", do: str = "") -> None:
        self.what, self.where, self.do = what, where, do
        super().__init__(": ".join(filter(None, (where, what))) + (f" ({do})" if do else ""))


@contextmanager
def errors_relocated(where: str, instead_of: str) -> Iterator[None]:
    """Give InputErrors located at `instead_of` the location `where`, which identifies a recording among several."""
    try:
        yield
    except InputError as error:
        if error.where != instead_of:
            raise
        raise InputError(error.what, where=where, do=error.do) from None
