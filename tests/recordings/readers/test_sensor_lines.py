"""Logs whose lines name their sensor: the magnetometer's lines are found, the others brought to their times."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from recordings.readers import FileContents, load
from scenarios.errors import InputError
from tests.conftest import ROOT

CASES = ROOT / "tests" / "recordings" / "cases"
TIMES = np.arange(12) / 10
MAG = np.column_stack([np.cos(TIMES), np.sin(TIMES), TIMES]) * 40


def text(tmp: Path, lines: list[str], stream: str | None = None) -> FileContents:
    (tmp / "serial.log").write_text("\n".join(lines) + "\n")
    return load(tmp / "serial.log", lambda name: True, stream)


def block(contents: FileContents, *names: str) -> np.ndarray:
    return np.column_stack([contents.table.column(name).to_numpy() for name in names])


XYZ = ("mag_x", "mag_y", "mag_z")


def test_interleaved_case() -> None:
    found = load(CASES / "interleaved.csv", lambda name: True)
    assert found.table.column_names[:4] == ["t", *XYZ]
    assert found.table.num_rows == 600
    np.testing.assert_array_equal(block(found, "t", *XYZ)[0], [0, 12.73, 11.35, -18.30])
    np.testing.assert_allclose(block(found, "accel_z", "gyro_x"), [[9.8, 0.01]] * 600)
    assert found.notes == (
        "the magnetometer's lines are those of MAG",
        "the lines of ACC, GYR were brought to their times",
    )


def test_counts_of_motioncal_become_units(tmp_path: Path) -> None:
    found = load(CASES / "motioncal.txt", lambda name: True)
    names = [f"raw_{kind}_{axis}" for kind in ("accel", "gyro", "mag") for axis in "xyz"]
    assert found.table.column_names == names
    np.testing.assert_allclose(block(found, *names)[0], [0, 0, 1, 1 / 16, -2 / 16, 0, 12.7, 11.4, -18.3])
    units = [found.table.schema.field(name).metadata[b"unit"] for name in names[::3]]
    assert units == [b"g", b"deg/s", b"uT"]
    lines = [f"{kind}:{','.join('123456789')}" for kind in ("Raw", "Uni") * 6]
    mixed = text(tmp_path, ["Adafruit AHRS", *lines[:3], "Ori: 1.0, 2.0, 3.0", *lines[3:], "Ori: 1.0, 2.0, 3.0"])
    assert mixed.table.num_rows == 6
    assert mixed.notes == ("the magnetometer's lines are those of Raw", "the lines of Uni, Ori were not read")


def rows(word: str, form: str, values: np.ndarray = MAG) -> list[str]:
    return [form.format(word=word, t=t, x=x, y=y, z=z) for t, (x, y, z) in zip(TIMES, values, strict=True)]


@pytest.mark.parametrize("word", ["MAG", "mag", "$MAG", "Magnetometer", "M", "Mag", "UncalMag", "compass"])
@pytest.mark.parametrize(
    "form",
    [
        "{word},{x:.6f},{y:.6f},{z:.6f}",
        "{word}: {x:.6f} {y:.6f} {z:.6f}",
        "{word}:{x:.6f},{y:.6f},{z:.6f}",
        "{word}\t{t:.1f}\t{x:.6f}\t{y:.6f}\t{z:.6f}",
        "{t:.1f};{word};{x:.6f};{y:.6f};{z:.6f}",
        "{word} {t:.1f} {x:.6f} {y:.6f} {z:.6f}",
    ],
)
def test_words_and_forms_of_lines(word: str, form: str, tmp_path: Path) -> None:
    other = rows("A", form, MAG + 100)
    found = text(tmp_path, [line for pair in zip(other, rows(word, form), strict=True) for line in pair])
    np.testing.assert_allclose(block(found, *XYZ), MAG, atol=1e-6)
    if "{t" in form:
        np.testing.assert_allclose(block(found, "time")[:, 0], TIMES)
        np.testing.assert_allclose(block(found, "accel_x", "accel_y", "accel_z"), MAG + 100, atol=1e-6)


def test_log_of_a_phone_with_headers_in_comments(tmp_path: Path) -> None:
    names = "utcTimeMillis,elapsedRealtimeNanos,UncalMagXMicroT,UncalMagYMicroT,UncalMagZMicroT,BiasXMicroT"
    head = ["# Version: v3.0", f"# UncalMag,{names}", "#", "# Fix,Provider,Latitude", "# Status,A,B"]
    lines = [
        f"UncalMag,{1714564800000 + 100 * k},{10**9 * k},{x:.4f},{y:.4f},{z:.4f},1.5" for k, (x, y, z) in enumerate(MAG)
    ]
    found = text(tmp_path, [*head, *(line for one in lines for line in (one, "Fix,gps,50.1", "Status,,1"))])
    assert found.table.column_names == names.split(",")
    np.testing.assert_allclose(block(found, *names.split(",")[2:5]), MAG, atol=1e-4)


def test_words_that_name_no_magnetometer(tmp_path: Path) -> None:
    form = "{word},{t:.1f},{x:.6f},{y:.6f},{z:.6f}"
    lines = [line for pair in zip(rows("S1", form, MAG + 1), rows("S2", form), strict=True) for line in pair]
    with pytest.raises(InputError, match=r"holds lines of S1, S2, and no known magnetometer .*--stream WORD"):
        text(tmp_path, lines)
    with pytest.raises(InputError, match="and none of S3"):
        text(tmp_path, lines, "S3")
    np.testing.assert_allclose(block(text(tmp_path, lines, "s2"), "s2_x", "s2_y", "s2_z"), MAG, atol=1e-6)


def test_words_of_a_table_stay_its_column(tmp_path: Path) -> None:
    table = [
        "phase,t,mag_x,mag_y,mag_z",
        *rows("level", "{word},{t},{x},{y},{z}"),
        *rows("magnet", "{word},{t},{x},{y},{z}"),
    ]
    found = text(tmp_path, table)
    assert found.table.column_names == ["phase", "t", "mag_x", "mag_y", "mag_z"]
    assert found.table.num_rows == 24


def test_damaged_lines_are_told_with_their_place_in_the_file(tmp_path: Path) -> None:
    lines = [
        line
        for pair in zip(rows("ACC", "{word},{x},1,2"), rows("MAG", "{word},{x},{y},{z}"), strict=True)
        for line in pair
    ]
    lines[9] = "MAG,1.0,2.0"
    assert "1 row of fewer cells was skipped, in line 10" in text(tmp_path, lines).notes


def test_lines_of_a_receiver_between_rows(tmp_path: Path) -> None:
    table = rows("", "{t:.1f},{x:.6f},{y:.6f},{z:.6f}")
    between = "$GPGGA,120000.00,5000.0,N,01000.0,E,1,08,0.9,100.0,M,46.9,M,,*47"
    found = text(tmp_path, ["t,mx,my,mz", *table[:4], between, *table[4:8], between, *table[8:]])
    np.testing.assert_allclose(block(found, "mx", "my", "mz"), MAG, atol=1e-6)
    assert found.notes == ("2 rows of more cells were skipped, the first in line 6",)


def test_unit_and_checksum_behind_the_last_value(tmp_path: Path) -> None:
    found = text(tmp_path, rows("M", "{word}: {x:.6f}, {y:.6f}, {z:.6f} gauss"))
    np.testing.assert_allclose(block(found, *XYZ), MAG, atol=1e-6)
    assert [field.metadata for field in found.table.schema] == [{b"unit": b"gauss"}] * 3
    found = text(tmp_path, rows("$MAG", "{word},{x:.6f},{y:.6f},{z:.6f}*2A"))
    np.testing.assert_allclose(block(found, *XYZ), MAG, atol=1e-6)


def test_words_and_numbers_behind_the_vector(tmp_path: Path) -> None:
    found = text(tmp_path, rows("mag", "{word}:\t{x:.6f}\t{y:.6f}\t{z:.6f}\theading:\t12.5"))
    np.testing.assert_allclose(block(found, *XYZ), MAG, atol=1e-6)


@pytest.mark.parametrize(
    "lines",
    [
        ["M: 1.0, 2.0", "M: 1.0, 2.0, 3.0", "M: 1.0"],
        ["MAG,5.00.01,1,2,3", "MAG,0.2,1,2,3", "MAG,0.3,1,2,3"],
        ["M: word", "M: 3 words", "1 M"],
        ["%", "# ", "%time,x,y", "MAG,,,", "MAG,-,-,-"],
    ],
)
def test_damaged_lines_are_read_or_refused(lines: list[str], tmp_path: Path) -> None:
    with suppress(InputError):
        assert text(tmp_path, lines).table.num_columns
