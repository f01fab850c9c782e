"""Observatory files: elements to X, Y, Z, gaps, and files that lack what is needed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from recordings import read_recording
from recordings.readers import load
from scenarios.errors import InputError
from tests.conftest import ROOT

CASES = ROOT / "tests" / "recordings" / "cases"
HEAD = " Format                 IAGA-2002                                    |\n # a comment                    |\n"


def written(tmp: Path, elements: str, rows: list[tuple[float, ...]]) -> Path:
    names = "      ".join(f"ABC{name}" for name in elements)
    lines = [f"DATE       TIME         DOY     {names}   |"]
    for minute, row in enumerate(rows):
        lines.append(f"2024-05-01 00:{minute:02}:00.000 122   " + " ".join(f"{value:9.2f}" for value in row))
    (tmp / "abc.min").write_text(HEAD + "\r\n".join(lines) + "\r\n")
    return tmp / "abc.min"


@pytest.mark.parametrize("name", ["iaga.min", "iaga.txt"])
def test_case_is_read_whatever_the_suffix(name: str) -> None:
    found = read_recording(CASES / name)
    assert len(found.time_s) == 299
    np.testing.assert_array_equal(found.mag_nT[0], [20000.02, 999.98, 44000.11])
    assert found.channels["scalar_nT"][0] == 48342.64
    assert found.time_s[-1] == 299 * 60
    notes = load(CASES / name, lambda column: True).notes
    assert notes[1:] == ("1 record without a value left out",)


def test_elements_of_other_kinds_give_the_same_vector(tmp_path: Path) -> None:
    """H = 20,000 nT, D = 3 degrees, I = 60 degrees, in minutes of arc; the sums of squares are H and F squared."""
    strength = 20_000 / np.cos(np.pi / 3)
    down = strength * np.sin(np.pi / 3)
    for elements, row in {"HDZF": (20_000, 180, down, strength), "DIFH": (180, 3600, strength, 99999)}.items():
        table = load(written(tmp_path, elements, [row] * 3), lambda name: True).table
        x, y, z = (table.column(f"mag_{axis}_nT")[0].as_py() for axis in "xyz")
        assert x**2 + y**2 == pytest.approx(20_000**2, rel=1e-5)
        assert y / x == pytest.approx(0.0524078, rel=1e-5)
        assert x**2 + y**2 + z**2 == pytest.approx(strength**2, rel=1e-5)


def test_what_is_no_vector_and_no_records(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="gives the elements H, Z, F: no whole vector"):
        load(written(tmp_path, "HZF", [(1, 2, 3)]), lambda name: True)
    (tmp_path / "cut.min").write_text(HEAD)
    with pytest.raises(InputError, match="without records"):
        load(tmp_path / "cut.min", lambda name: True)
