"""Print-outs of names and values, and lines that a serial monitor has stamped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from recordings.readers import FileContents, load
from recordings.readers.text.prints import print_form

VALUES = np.column_stack([np.arange(1, 9) * 1.5, np.arange(8) - 4.25, np.arange(8) * -10.0])


def text(tmp: Path, lines: list[str]) -> FileContents:
    (tmp / "serial.txt").write_text("\n".join(lines) + "\n")
    return load(tmp / "serial.txt", lambda name: True)


FORMS: dict[str, tuple[str, tuple[str, ...]]] = {
    "axes": ("X: {x} Y: {y} Z: {z}", ("X", "Y", "Z")),
    "axes and unit": ("X: {x}  Y: {y}  Z: {z} uT", ("X", "Y", "Z")),
    "equal signs": ("mx={x}, my={y}, mz={z}", ("mx", "my", "mz")),
    "tabs": ("Mag_X: {x}\tMag_Y: {y}\tMag_Z: {z}\tHeading (degrees): 12.5", ("Mag_X", "Mag_Y", "Mag_Z")),
    "a sensor's name before all": ("Mag X: {x} uT, Y: {y} uT, Z: {z} uT", ("Mag_X", "Mag_Y", "Mag_Z")),
    "a sensor's name with an arrow": (
        "Magnetometer -> X: {x} Y: {y} Z: {z}",
        tuple(f"Magnetometer_{a}" for a in "XYZ"),
    ),
    "JSON": ('{{"t": 1.5, "mx": {x}, "my": {y}, "mz": {z}}}', ("mx", "my", "mz")),
    "nested JSON": (
        '{{"ts":1,"acc":{{"x":0.1,"y":0,"z":9.8}},"mag":{{"x":{x},"y":{y},"z":{z}}}}}',
        ("mag_x", "mag_y", "mag_z"),
    ),
    "two sensors in a line": ("Acc X: 1 Y: 2 Z: 3 | Mag X: {x} Y: {y} Z: {z}", ("Mag_X", "Mag_Y", "Mag_Z")),
    "a clock before": ("12:30:00.5 X: {x} Y: {y} Z: {z}", ("X", "Y", "Z")),
    "a value a line": ("Mag X: {x}\nMag Y: {y}\nMag Z: {z}", ("Mag_X", "Mag_Y", "Mag_Z")),
    "several sensors": (
        "Accel X: 0.1 Y: 0.2 Z: 9.8\nGyro X: 0 Y: 0 Z: 0\nMag X: {x} Y: {y} Z: {z}\n",
        ("Mag_X", "Mag_Y", "Mag_Z"),
    ),
}


@pytest.mark.parametrize(("form", "names"), FORMS.values(), ids=FORMS)
def test_values_by_name(form: str, names: tuple[str, ...], tmp_path: Path) -> None:
    found = text(tmp_path, [form.format(x=x, y=y, z=z) for x, y, z in VALUES])
    np.testing.assert_array_equal(np.column_stack([found.table.column(name).to_numpy() for name in names]), VALUES)
    assert found.notes == ()
    if "uT" in form:
        assert [found.table.schema.field(name).metadata for name in names] == [{b"unit": b"uT"}] * 3


def test_lines_between_are_counted(tmp_path: Path) -> None:
    found = text(tmp_path, ["Boot", "", *(f"mx={x} my={y} mz={z}" for x, y, z in VALUES), "done", "mx=1 my="])
    assert found.table.num_rows == 8
    assert found.notes == ("3 of 11 lines without names and values were not read",)


def test_a_value_that_is_missing_in_a_round_is_empty(tmp_path: Path) -> None:
    lines = [f"X: {x}\nY: {y}\nZ: {z}" for x, y, z in VALUES]
    lines[3] = "X: 6.0\nZ: -30.0"
    found = text(tmp_path, lines).table
    assert found.column("Y").to_pylist()[2:5] == [-2.25, None, -0.25]
    assert found.num_rows == 8


STAMPS = [f"12:59:59.{k:03}" for k in (0, 250, 500, 750)] + [f"13:00:00.{k:03}" for k in (0, 250, 500, 750)]


@pytest.mark.parametrize("stamp", ["{} -> ", "[{}] ", "{}> "])
@pytest.mark.parametrize(
    ("form", "header", "names"),
    [
        ("{x},{y},{z}", "mx,my,mz", ("mx", "my", "mz")),
        ("{x} {y} {z}", None, ("column_2", "column_3", "column_4")),
        ("MAG:{x},{y},{z}", None, ("mag_x", "mag_y", "mag_z")),
        ("X: {x} Y: {y} Z: {z}", None, ("X", "Y", "Z")),
    ],
)
def test_stamps_of_a_serial_monitor(
    stamp: str, form: str, header: str | None, names: tuple[str, ...], tmp_path: Path
) -> None:
    rows = [stamp.format(time) + form.format(x=x, y=y, z=z) for time, (x, y, z) in zip(STAMPS, VALUES, strict=True)]
    found = text(tmp_path, [*([stamp.format("12:59:58.000") + header] if header else []), *rows]).table
    np.testing.assert_array_equal(np.column_stack([found.column(name).to_numpy() for name in names]), VALUES)
    time = "time" if "time" in found.column_names else "column_1"
    np.testing.assert_allclose(np.diff(found.column(time).to_numpy()), 0.25)


def test_a_line_of_a_thousand_words_is_no_print() -> None:
    assert print_form("word " * 20_000) is None
