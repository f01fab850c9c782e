"""The lines of a text file as an Arrow array, and chosen lines as the text of a table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
from numpy.typing import NDArray

_NEVER = "\x01"
"""A delimiter that no text holds."""


@dataclass(frozen=True, eq=False)
class ChosenLines:
    """Lines of a file.

    Parameters
    ----------
    text : (n,) without line ends.
    numbers : (n,) of the lines in the file, counted from 1.
    """

    text: pa.StringArray
    numbers: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.text)

    def matching(self, pattern: str) -> ChosenLines:
        """Return the lines in which a regular expression occurs."""
        mask = pc.match_substring_regex(self.text, pattern)
        return ChosenLines(self.text.filter(mask), self.numbers[np.asarray(mask.to_numpy(zero_copy_only=False))])

    def replaced(self, pattern: str, by: str, most: int | None = 1) -> ChosenLines:
        """Return the lines with the first match of a regular expression replaced, or `most` of them; None for all."""
        return ChosenLines(pc.replace_substring_regex(self.text, pattern, by, max_replacements=most), self.numbers)

    def joined(self, ended: bool) -> memoryview:
        """Return the lines as one text in UTF-8, the last with a line break if `ended`."""
        texts = pa.concat_arrays([self.text, pa.array([""] if ended else [], pa.string())]).cast(pa.binary())
        whole = pc.binary_join(pa.ListArray.from_arrays([0, len(texts)], texts), b"\n")
        return memoryview(whole[0].as_buffer() if len(self.text) else b"")


def lines_of(data: bytes) -> ChosenLines:
    """Return all lines of a text in UTF-8, empty lines too."""
    table = pyarrow.csv.read_csv(
        pa.BufferReader(data),
        read_options=pyarrow.csv.ReadOptions(use_threads=False, column_names=["line"]),
        parse_options=pyarrow.csv.ParseOptions(delimiter=_NEVER, quote_char=False, ignore_empty_lines=False),
        convert_options=pyarrow.csv.ConvertOptions(column_types={"line": pa.string()}, strings_can_be_null=False),
    )
    text = table.column(0).combine_chunks()
    return ChosenLines(text, np.arange(1, len(text) + 1))
