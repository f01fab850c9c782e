"""Damaged recordings, measured ones and our own: the same door, and a line for what cannot be used."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
import pytest
from hypothesis import strategies as st

from tests.fuzz.contract import amounts, fuzz, hold
from tests.fuzz.material import CALIBRATION, log_table, scenario_in
from tests.fuzz.tables import Bytes, Damage, broken_bytes, damages
from tests.fuzz.values import damaged_json
from tests.nightly import first_daily

MEASURED, OWN = 100, 90
"""Cases of each in the normal run."""
METHODS = ("sphere", "ellipsoid", "twostep", "ml_newton", "vector_least_squares", "vector_lm", "ellipsoid_segmented")
METADATA = {"schema": 1, "seed": 3, "run": 0, "parameters": {"field_enu_nT": [0.0, 20000.0, -40000.0], "effects": []}}
MAPS = (
    "mag_x_nT=mag_y_nT",
    "mag_x_nT=mag_x_nT,unit=uT",
    "mag_z_nT=mag_z_nT,scale=1e300",
    "time_s=time_s,unit=ns",
    "time_s=wheel_rad_s,scale=1e-300",
    "phase=mag_x_nT",
    "temperature_degC=phase",
    "mag1_x_nT=mag_x_nT",
    "att_qw=att_qx",
    "mag_x_nT=no such column",
    "x\ny=\x00",
)


@dataclass(frozen=True)
class Case:
    """A file and what is asked of it."""

    own: bool
    damages: tuple[Damage, ...] = ()
    broken: Bytes | None = None
    metadata: str = json.dumps(METADATA)
    suffix: str = ".parquet"
    command: str = "calibrate"
    method: str = "sphere"
    options: tuple[str, ...] = ("--field-strength-nT", "44721")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> pa.Table:
    """A simulated run, truth and all."""
    place = tmp_path_factory.mktemp("run")
    assert hold(place / "out", "simulate", str(scenario_in(place)), "-o", str(place / "out"), "--jobs", "1") == 0
    return pq.read_table(place / "out" / "run-00000.parquet", partitioning=None)


@pytest.fixture
def place(tmp_path: Path) -> Iterator[Path]:
    """A directory with a calibration; `out` in it is what a command may write."""
    (tmp_path / "calibration.json").write_text(json.dumps(CALIBRATION))
    yield tmp_path
    shutil.rmtree(tmp_path)


def check(place: Path, table: pa.Table, case: Case) -> int:
    """Damage the table, ask the command, hold it to the contract; returns the status."""
    out = place / "out"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    file = place / f"log{case.suffix}"
    for one in case.damages:
        table = one.to(table)
    _write(table, file, case.metadata if case.own else None)
    if case.broken is not None:
        file.write_bytes(case.broken.to(file.read_bytes()))
    status = hold(out, *_arguments(place, file, case))
    if case.command == "apply":
        written = [] if status else ["corrected.html", "corrected.parquet"]
        assert sorted(path.name for path in out.iterdir()) == written
    return status


def _arguments(place: Path, file: Path, case: Case) -> list[str]:
    out = place / "out"
    arguments = {
        "calibrate": ("calibrate", str(file), "--with", case.method, "-o", str(out / "c"), "--json", *case.options),
        "inspect": ("inspect", str(file), "--json"),
        "report": ("inspect", str(file), "-o", str(out / "report")),
        "apply": ("apply", str(place / "calibration.json"), str(file), "-o", str(out / "corrected.parquet")),
    }[case.command]
    maps = [text for text in case.options if "=" in text and case.command != "calibrate"]
    return [*arguments, *(word for text in maps for word in ("--map", text))]


def _write(table: pa.Table, file: Path, metadata: str | None) -> None:
    if file.suffix == ".parquet":
        written = {} if metadata is None else {"magbench": metadata.encode("utf-8", "surrogateescape")}
        pq.write_table(table.replace_schema_metadata(written), file)
        return
    columns = [_as_text(table.column(i)) for i in range(table.num_columns)]
    pyarrow.csv.write_csv(pa.Table.from_arrays(columns, names=table.column_names), file)


def _as_text(column: pa.ChunkedArray) -> pa.ChunkedArray | pa.Array:
    """A column as CSV can hold it."""
    if pa.types.is_floating(column.type) or pa.types.is_string(column.type) or pa.types.is_integer(column.type):
        return column.cast(pa.float32()) if pa.types.is_float16(column.type) else column
    return pa.array([None if cell is None else str(cell) for cell in column.cast(_readable(column.type)).to_pylist()])


def _readable(kind: pa.DataType) -> pa.DataType:
    """The type that Python can show: without nanoseconds and far years, a number."""
    return pa.int64() if pa.types.is_temporal(kind) and not pa.types.is_date32(kind) else kind


def cases(own: bool, names: list[str]) -> st.SearchStrategy[Case]:
    """Every kind of damage to a file, and every command that reads it."""
    maps = st.sampled_from(MAPS).map(lambda text: ("--map", text))
    field = st.sampled_from(["44721", "30000", "48.2", "nan", "1e300", "-5", "x"]).map(
        lambda text: ("--field-strength-nT", text)
    )
    vector = st.sampled_from(["0,20000,-40000", "1,2", "nan,0,0", "0,0,1e300"]).map(
        lambda text: ("--field-enu-nT", text)
    )
    good = st.just(("--field-strength-nT", "44721"))
    mapped = st.tuples(maps, good).map(lambda two: two[0] + two[1])
    options = st.one_of(good, good, good, field, vector, st.just(()), mapped)
    commands = [*["calibrate"] * 8, *["apply"] * 6, *["inspect"] * 3]
    texts = damaged_json(METADATA) | st.sampled_from(["", "{", "[" * 5000, "\udcff", "\x00"])
    return st.builds(
        Case,
        st.just(own),
        damages(names),
        st.none() | st.none() | st.none() | broken_bytes,
        texts if own else st.just(""),
        st.just(".parquet") if own else st.sampled_from([".parquet", ".csv"]),
        st.sampled_from(commands),
        st.sampled_from(METHODS),
        options,
    )


@amounts
def test_measured_logs(place: Path, times: int) -> None:
    table = log_table()
    fuzz(cases(False, table.column_names), lambda case: check(place, table, case), MEASURED, times)


@amounts
def test_our_own_runs(place: Path, run: pa.Table, times: int) -> None:
    fuzz(cases(True, run.column_names), lambda case: check(place, run, case), OWN, times)


def damaged(how: str, column: str, word: str = "", row: int = 0, value: float = 0.0) -> dict[str, Any]:
    return {"damages": (Damage(how, column, row, value, word),)}


KNOWN: dict[str, tuple[dict[str, Any], int]] = {
    "nothing": ({}, 0),
    "a column missing": (damaged("drop", "mag_y_nT"), 2),
    "a component of the attitude missing": (damaged("drop", "att_qz"), 2),
    "text": (damaged("retype", "mag_x_nT", "text"), 2),
    "dates": (damaged("retype", "mag_x_nT", "dates"), 2),
    "dates in a gyro": (damaged("retype", "gyro_x_rad_s", "dates"), 2),
    "decimals": (damaged("retype", "temperature_degC", "decimals"), 0),
    "metadata that is not JSON": ({"metadata": "{", "options": ()}, 2),
    "metadata that is not JSON, and not asked": ({"metadata": "{"}, 0),
    "a field of infinity": ({"metadata": json.dumps(METADATA).replace("20000.0", "1e999"), "options": ()}, 2),
    "a field of nothing": ({"metadata": json.dumps(METADATA).replace("20000.0", "null"), "options": ()}, 2),
    "a zero interval": (damaged("scale", "time_s", value=0.0), 2),
    "an interval of next to nothing": (damaged("scale", "time_s", value=1e-300), 2),
    "a negative interval": (damaged("scale", "time_s", value=-1.0), 0),
    "not a number": (damaged("cells", "mag_x_nT", row=5, value=float("nan")), 0),
    "infinity": (damaged("cells", "att_qw", row=5, value=float("inf")), 2),
    "the largest number": (damaged("cells", "mag_z_nT", row=5, value=1.7e308), 0),
    "no rows": (damaged("cut", "time_s", row=0), 2),
    "three rows": (damaged("cut", "time_s", row=3), 2),
    "instants beyond the calendar": (damaged("retype", "time_s", "far instants"), 0),
    "words of 5,000 letters": (damaged("retype", "phase", "long text"), 2),
    "bytes overwritten": ({"broken": Bytes(400, b"\xff" * 6, False)}, 2),
    "a specific force of no size": (damaged("scale", "accel_y_m_s2", value=1e290), 2),
    "a short log, a component in steps": (
        {
            "damages": (
                Damage("cut", "mag_z_nT", 79),
                Damage("retype", "mag_z_nT", word="decimals"),
                Damage("scale", "mag_z_nT", value=1000.0),
            )
        },
        0,
    ),
    "cut off": ({"broken": Bytes(300, b"", True)}, 2),
}


DRAWN = ("nothing", "the largest number", "a short log, a component in steps")
"""Known cases whose figures are drawn by day: of usual values, of one beyond all others, of few."""


@pytest.mark.parametrize("command", ["calibrate", "apply", "inspect"])
@pytest.mark.parametrize("kind", KNOWN)
@pytest.mark.usefixtures("undrawn")
def test_known_cases_of_our_own_runs(place: Path, run: pa.Table, kind: str, command: str) -> None:
    changes, status = KNOWN[kind]
    found = check(place, run, Case(own=True, command=command, **changes))
    if command == "calibrate":
        assert found == status


@pytest.mark.parametrize("command", ["calibrate", "apply"])
@pytest.mark.parametrize("kind", first_daily(sorted(KNOWN, key=lambda kind: kind not in DRAWN), len(DRAWN)))
def test_figures_of_known_cases(place: Path, run: pa.Table, kind: str, command: str) -> None:
    changes, status = KNOWN[kind]
    assert check(place, run, Case(own=True, command=command, **changes)) == status or command == "apply"


@pytest.mark.usefixtures("undrawn")
def test_an_axis_that_repeats_another(place: Path, run: pa.Table) -> None:
    """No method may call such a matrix ok, and what it gives can be applied or is refused."""
    for method in METHODS:
        check(place, run, Case(own=True, method=method, damages=(Damage("copy", "mag_y_nT", row=1),)))
        answer = json.loads((place / "out" / "c" / "calibration.json").read_text())
        assert answer[method]["status"] != "ok", method


@pytest.mark.parametrize(
    ("changes", "options"),
    [
        (damaged("cells", "time_s", row=7, value=1e30), ()),
        (damaged("drop", "gyro_y_rad_s"), ("time_s=wheel_rad_s,scale=1e-300",)),
        (damaged("cells", "accel_y_m_s2", row=188, value=3.4e38), ()),
    ],
)
def test_an_inspection_of_what_is_no_time_and_no_number(
    place: Path, changes: dict[str, Any], options: tuple[str, ...]
) -> None:
    assert check(place, log_table(), Case(own=False, command="inspect", options=options, **changes)) == 0


def test_a_report_of_a_damaged_log(place: Path, run: pa.Table) -> None:
    assert check(place, run, Case(own=True, command="report", **damaged("empty", "mag_x_nT", row=3))) in (0, 2)
