"""Text logs as people have them: every dialect gives the numbers that were written, and tells what was left out."""

from __future__ import annotations

import datetime
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from recordings.readers import FileContents, load
from scenarios.errors import InputError
from tests.conftest import ROOT

CASES = ROOT / "tests" / "recordings" / "cases"
HEADER = "t,x,y,z"
LINES = [HEADER, *(f"{k / 10:.1f},{k + 1}.5,{-k}.25,{3 * k}.0" for k in range(9))]


def read(path: Path) -> FileContents:
    return load(path, lambda name: True)


def text(tmp: Path, lines: list[str] | str | bytes, name: str = "log.csv") -> FileContents:
    content = "\n".join(lines) + "\n" if isinstance(lines, list) else lines
    (tmp / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return read(tmp / name)


def column(contents: FileContents, name: str) -> list[object]:
    return contents.table.column(name).to_pylist()


SAME = [
    "bom",
    "comments",
    "sep_line",
    "units_row",
    "utf16",
    "trailing_comma",
    "iso_z",
    "iso_space",
    "german_date",
    "clock",
]


@pytest.mark.parametrize("name", [*(f"{name}.csv" for name in SAME), "whitespace.txt"])
def test_dialects_of_a_log_hold_the_same_numbers(name: str) -> None:
    expected, found = read(CASES / "base.csv"), read(CASES / name)
    assert found.table.column_names == expected.table.column_names
    for axis in "xyz":
        np.testing.assert_array_equal(column(found, f"mag_{axis}_nT"), column(expected, f"mag_{axis}_nT"))
    if pa.types.is_floating(found.table.schema.field("time_s").type):
        elapsed = np.array(column(found, "time_s")) - found.table.column("time_s")[0].as_py()
    else:
        elapsed = (found.table.column("time_s").cast(pa.timestamp("ns")).to_numpy().astype(np.int64)) / 1e9
        elapsed -= elapsed[0]
    np.testing.assert_allclose(elapsed, column(expected, "time_s"), atol=1e-6)
    assert found.notes == ()


def test_decimal_comma() -> None:
    found = read(CASES / "decimal_comma.csv")
    assert column(found, "mag_x_nT")[:2] == [12731.97, 16138.43]


def test_columns_without_a_header_are_numbered() -> None:
    found = read(CASES / "bare_magneto.txt").table
    assert found.column_names == ["column_1", "column_2", "column_3"]
    assert found.num_rows == 600
    assert [cell[0].as_py() for cell in found.columns] == [12.73, 11.35, -18.30]


def test_units_below_the_header_are_told_with_the_columns(tmp_path: Path) -> None:
    schema = read(CASES / "units_row.csv").table.schema
    assert [field.metadata for field in schema] == [{b"unit": b"s"}, *[{b"unit": b"nT"}] * 3]
    schema = text(tmp_path, ["t;x", "[ms];[µT]", "1;2", "2;3"]).table.schema
    assert [field.metadata[b"unit"].decode() for field in schema] == ["ms", "µT"]


def test_cells_without_a_value_are_empty() -> None:
    for name in ("nan_some.csv", "dash_some.csv"):
        found = read(CASES / name)
        assert [found.table.column(f"mag_{axis}_nT").null_count for axis in "xyz"] == [6, 6, 6]
        assert found.notes == ()


@pytest.mark.parametrize("mark", ["", "nan", "NaN", "NA", " null ", "--", "-", "inf", "-Infinity", "N/A"])
def test_marks_for_no_value(mark: str, tmp_path: Path) -> None:
    found = text(tmp_path, [*LINES, f"0.9,{mark},1,2"])
    assert column(found, "x")[-1] is None
    assert found.table.num_rows == 10


def test_last_line_that_was_cut_off(tmp_path: Path) -> None:
    found = read(CASES / "cut_last_line.csv")
    assert found.table.num_rows == 599
    assert found.notes == ("the last line is cut off and was skipped",)
    cut_in_a_number = text(tmp_path, "\n".join([*LINES, "0.9,1.5,2.25,31."]))
    assert cut_in_a_number.table.num_rows == 9
    assert cut_in_a_number.notes == ("the last line is cut off and was skipped",)
    whole = text(tmp_path, "\n".join(LINES))
    assert whole.table.num_rows == 9
    assert whole.notes == ()


SKIPPED: dict[str, tuple[Callable[[list[str]], list[str]], int, str]] = {
    "fewer cells": (
        lambda ls: [*ls[:4], "0.35,1", *ls[4:], "7"],
        9,
        "2 rows of fewer cells were skipped, the first in line 5",
    ),
    "more cells": (lambda ls: [*ls[:4], "0.35,1,2,3,4", *ls[4:]], 9, "1 row of more cells was skipped, in line 5"),
    "header": (lambda ls: [*ls[:4], ls[0], *ls[4:]], 9, "1 row with the header again was skipped, in line 5"),
    "damage": (
        lambda ls: [*ls[:4], "0.3\x15,1,2,3", *ls[4:]],
        9,
        "1 row with a cell that is no number was skipped, in line 5",
    ),
    "blank lines": (lambda ls: [*ls[:4], "", "", "5", *ls[4:]], 9, "1 row of fewer cells was skipped, in line 7"),
    "damage after all": (
        lambda ls: [*ls[:2], "", "1", *ls[2:4], "0.3,x,2,3", *ls[4:]],
        9,
        "1 row with a cell that is no number was skipped, in line 7",
    ),
    "free text above": (lambda ls: ["Logger 3, made here", "", *ls], 9, "1 line of text above the rows was not read"),
}


@pytest.mark.parametrize(("edit", "rows", "note"), SKIPPED.values(), ids=SKIPPED)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_that_are_no_rows_are_skipped_and_told(
    edit: Callable[[list[str]], list[str]], rows: int, note: str, end: str, tmp_path: Path
) -> None:
    found = text(tmp_path, end.join(edit(LINES)) + end)
    assert found.table.num_rows == rows
    assert note in found.notes
    np.testing.assert_array_equal(column(found, "x"), np.arange(rows) + 1.5)


def test_comments_between_rows_are_left_out_in_silence(tmp_path: Path) -> None:
    found = text(tmp_path, [*LINES[:3], "# a,b,c,d", "# fix lost", "% and found", *LINES[3:]])
    assert column(found, "x") == [k + 1.5 for k in range(9)]
    assert found.notes == ()


@pytest.mark.parametrize("header", ["# time, mx ,my,mz", "%time,mx,my,mz", "#time mx my mz", "// time;mx;my;mz"])
def test_header_in_a_comment(header: str, tmp_path: Path) -> None:
    found = text(tmp_path, ["# made by hand, really", header, *LINES[1:]])
    assert found.table.column_names == ["time", "mx", "my", "mz"]
    assert found.table.num_rows == 9


def test_padding_of_a_preallocated_file(tmp_path: Path) -> None:
    found = text(tmp_path, "\n".join(LINES).encode() + b"\n" + bytes(4096), "log.bin2")
    assert found.table.num_rows == 9
    assert found.notes == ("4096 bytes of padding at the end were left out",)


def test_a_word_that_repeats_among_numbers_is_no_value(tmp_path: Path) -> None:
    found = text(tmp_path, [*LINES, *(f"{k},nofix,0,0" for k in range(3))])
    assert column(found, "x")[-3:] == [None] * 3
    assert found.notes == ("x: 'nofix' in 3 cells was taken as empty",)


def test_more_lines_wrong_than_right(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="lines have other than 4 cells, the first is line 4"):
        text(tmp_path, [*LINES[:3], *["$GPGGA,1,2"] * 20])


def test_header_of_another_length(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the header names 5 columns, the rows have 4 cells"):
        text(tmp_path, ["a,b,c,d,e", *LINES[1:]])


@pytest.mark.parametrize("content", [b"\x00\x01\x02\x03" * 99, b"word " * 99, b"\n\n\n", b"one\ntwo\nthree\n"])
def test_what_holds_no_rows(content: bytes, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not a text table"):
        text(tmp_path, content, "log.txt")


@pytest.mark.parametrize("name", ["log", "log.dat", "log.asc", "LOG.LOG", "log.xyz"])
def test_any_suffix(name: str, tmp_path: Path) -> None:
    assert text(tmp_path, LINES, name).table.num_rows == 9


def test_quotes_and_units_in_names(tmp_path: Path) -> None:
    lines = ['"Time (s)","Magnetic field x (µT)","Label"', '0.0,"1.5","a, b"', '0.1,"2.5","say ""c"""']
    found = text(tmp_path, "\r\n".join(lines).encode("latin-1"))
    assert found.table.column_names == ["Time (s)", "Magnetic field x (µT)", "Label"]
    assert column(found, "Magnetic field x (µT)") == [1.5, 2.5]
    assert column(found, "Label") == ["a, b", 'say "c"']


UTC = datetime.UTC
TIMES: dict[str, tuple[list[str], list[object]]] = {
    "clock": (["12:00:00", "12:00:01"], [43200.0, 43201.0]),
    "clock with fractions": (["12:00:00.25", "12:00:01.5"], [43200.25, 43201.5]),
    "clock of twelve hours": (["11:59:59 AM", "12:00:00 PM", "12:00:01 pm"], [43199.0, 43200.0, 43201.0]),
    "midnight": (["23:59:59.5", "00:00:00.5", "0:00:01.0"], [86399.5, 86400.5, 86401.0]),
    "milliseconds after a colon": (["2024-05-01 12:00:00:250"], [datetime.datetime(2024, 5, 1, 12, 0, 0, 250_000)]),
    "day first": (["01.05.2024 12:00:00"], [datetime.datetime(2024, 5, 1, 12)]),
    "day first, two digits": (["1.5.24 12:00:00"], [datetime.datetime(2024, 5, 1, 12)]),
    "a day above 12": (["25/05/2024 12:00"], [datetime.datetime(2024, 5, 25, 12)]),
    "an American date": (["05/25/2024 1:00:00 PM"], [datetime.datetime(2024, 5, 25, 13)]),
    "order by rising": (
        ["01/02/2024 12:00", "02/02/2024 12:00", "01/03/2024 12:00"],
        [datetime.datetime(2024, 2, 1, 12), datetime.datetime(2024, 2, 2, 12), datetime.datetime(2024, 3, 1, 12)],
    ),
    "zone": (["2024-05-01T12:00:00,5+02:00"], [datetime.datetime(2024, 5, 1, 10, 0, 0, 500_000, UTC)]),
    "Z": (["2024/05/01 12:00:00Z"], [datetime.datetime(2024, 5, 1, 12, tzinfo=UTC)]),
    "compact": (["20240501T120000.5Z"], [datetime.datetime(2024, 5, 1, 12, 0, 0, 500_000, UTC)]),
    "month by name": (["01-May-2024 12:00:00"], [datetime.datetime(2024, 5, 1, 12)]),
}


@pytest.mark.parametrize(("cells", "expected"), TIMES.values(), ids=TIMES)
def test_times(cells: list[str], expected: list[object], tmp_path: Path) -> None:
    found = text(tmp_path, ["t;x;y", *(f"{cell};1.5;2" for cell in cells)])
    values = [value.to_pydatetime() if hasattr(value, "to_pydatetime") else value for value in column(found, "t")]
    assert values == expected


def test_order_of_day_and_month_that_nothing_tells(tmp_path: Path) -> None:
    found = text(tmp_path, ["t,x,y", "01/05/2024 12:00:00,1,2", "01/05/2024 12:00:01,1,2"])
    assert found.notes == ("t: dates were read as day/month/year; nothing in the file tells the order",)


@pytest.mark.parametrize("delimiter", [",", " "])
def test_date_and_clock_in_columns_of_their_own(delimiter: str, tmp_path: Path) -> None:
    rows = ["Date,Time,x", "01.05.2024,23:59:59.5,1", "02.05.2024,00:00:00.5,2"]
    found = text(tmp_path, [row.replace(",", delimiter) for row in rows])
    assert found.table.column_names == ["Time", "x"]
    assert [str(time) for time in column(found, "Time")] == ["2024-05-01 23:59:59.500000", "2024-05-02 00:00:00.500000"]
    assert found.notes == ("Date and Time were joined to one time",)


def test_damaged_time_costs_its_row(tmp_path: Path) -> None:
    found = text(tmp_path, ["t,x,y", "12:00:00.5,1,2", "12:0?:01.5,2,2", "12:00:02.5,3,2"])
    assert column(found, "x") == [1, 3]
    assert found.notes == ("1 row with a cell that is no number was skipped, in line 3",)


@pytest.mark.parametrize("form", ["({x}, {y}, {z})", "[{x},{y},{z}]", "{x} uT,{y} uT,{z} uT", "{x};{y};{z}*7F"])
def test_numbers_in_brackets_with_units_and_checksums(form: str, tmp_path: Path) -> None:
    found = text(tmp_path, [form.format(x=k + 0.5, y=-k, z=k * 1e3) for k in range(9)])
    read_back = np.column_stack([found.table.column(k).to_numpy() for k in range(3)])
    np.testing.assert_array_equal(read_back, [[k + 0.5, -k, k * 1e3] for k in range(9)])
    if "uT" in form:
        assert [field.metadata for field in found.table.schema] == [{b"unit": b"uT"}] * 3


@pytest.mark.parametrize("form", ['"{0:,.2f}","{1:,.2f}"', "{0:,.2f};{1:,.2f}", "{0:,.2f}\t{1:,.2f}"])
@pytest.mark.parametrize("swapped", [False, True])
def test_marks_between_thousands(form: str, swapped: bool, tmp_path: Path) -> None:
    if swapped and "," in form.replace(":,", ""):
        form = form.replace('","', '";"')
    rows = [form.format(k * 800.25, -12_345.5 * k) for k in range(9)]
    rows = [row.translate(str.maketrans(",.", ".,")) for row in rows] if swapped else rows
    found = text(tmp_path, rows)
    assert column(found, "column_1") == [k * 800.25 for k in range(9)]
    assert column(found, "column_2") == [-12_345.5 * k for k in range(9)]


def test_remarks_that_most_rows_lack(tmp_path: Path) -> None:
    lines = [
        "Date\t2024/05/01",
        "X_Value\tBx\tBy\tComment",
        "0.0\t1.5\t2\tstart",
        *(f"0.{k}\t1.5\t2" for k in range(1, 9)),
    ]
    found = text(tmp_path, lines)
    assert found.table.column_names == ["X_Value", "Bx", "By"]
    assert found.table.num_rows == 8
