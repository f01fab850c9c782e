"""The one exception for wrong use and bad input: what is wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class InputError(ValueError):
    """Wrong use or bad input, told in one line.

    Parameters
    ----------
    what : what was found and what was expected.
    where : file and key, option or column it was found in.
    do : what the user can do about it.
    """

    def __init__(self, what: str, *, where: str = "", do: str = "") -> None:
        self.what, self.where, self.do = what, where, do
        super().__init__(": ".join(filter(None, (where, what))) + (f" ({do})" if do else ""))


@contextmanager
def told_of(where: str, instead_of: str) -> Iterator[None]:
    """Within, an InputError that is told of `instead_of` is told of `where`, which says which of several it is."""
    try:
        yield
    except InputError as error:
        if error.where != instead_of:
            raise
        raise InputError(error.what, where=where, do=error.do) from None
