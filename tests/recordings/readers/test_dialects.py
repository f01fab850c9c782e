"""A table written in random dialects reads back the numbers that were written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from recordings.readers import load

DIALECTS = 200
NAMES = ("t", "mx", "my", "mz")
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1")


class RandomDialect:
    """A dialect drawn from a seed, and how a table (n, 4) of up to two decimals is written in it."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.delimiter = str(rng.choice([",", ";", "\t", "|", "  ", " ; ", ", "]))
        self.decimal = "." if "," in self.delimiter or rng.random() < 0.5 else ","
        self.encoding = str(rng.choice(ENCODINGS))
        self.end = str(rng.choice(["\n", "\r\n", "\r"]))
        self.header = str(rng.choice(["plain", "none", "comment", "units"]))
        self.comments, self.trailing, self.blank_lines = rng.random(3) < 0.3
        self.quoted = bool(rng.random() < 0.2) and self.delimiter != "  "
        self.ended = bool(rng.random() < 0.7)
        self.rng = rng

    def __repr__(self) -> str:
        return repr({name: value for name, value in vars(self).items() if name != "rng"})

    def line(self, cells: list[str]) -> str:
        quoted = [f'"{cell}"' if self.quoted else cell for cell in cells]
        return self.delimiter.join(quoted) + (self.delimiter.strip(" ") if self.trailing else "")

    def written(self, values: np.ndarray) -> bytes:
        lines = [self.line([f"{value:.2f}".replace(".", self.decimal) for value in row]) for row in values]
        for remark in ("# sensor 1, roof; µT", "%", "// 2"):
            if self.comments:
                lines.insert(int(self.rng.integers(1, len(lines))), remark)
        if self.blank_lines:
            lines.insert(int(self.rng.integers(1, len(lines))), "")
        names = self.line(list(NAMES))
        above = {
            "plain": [names],
            "none": [],
            "comment": [f"# {names}"],
            "units": [names, self.line(["s", *["µT"] * 3])],
        }
        text = self.end.join([*above[self.header], *lines]) + (self.end if self.ended else "")
        return text.encode(self.encoding)


@pytest.mark.parametrize("seed", range(DIALECTS))
def test_numbers_come_back(seed: int, tmp_path: Path) -> None:
    dialect, rng = RandomDialect(seed), np.random.default_rng([seed, 1])
    values = np.round(np.column_stack([np.arange(40) * 0.25, rng.normal(0, 40, (40, 3))]), 2)
    (tmp_path / "log.txt").write_bytes(dialect.written(values))
    found = load(tmp_path / "log.txt", lambda name: True)
    names = NAMES if dialect.header != "none" else tuple(f"column_{k}" for k in range(1, 5))
    assert tuple(found.table.column_names) == names, dialect
    read = np.column_stack([found.table.column(name).to_numpy() for name in names])
    np.testing.assert_array_equal(read, values, err_msg=repr(dialect))
    assert found.notes == (), dialect
    if dialect.header == "units":
        units = [field.metadata[b"unit"].decode() for field in found.table.schema]
        assert units == ["s", *["µT"] * 3]
