"""The one exception for wrong use and bad input: what is wrong, where, and what to do."""

from __future__ import annotations


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
