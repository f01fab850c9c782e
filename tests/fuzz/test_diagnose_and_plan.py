"""Damaged logs given to a diagnosis, to a plan that goes on from a log, and to exports of a calibration."""

from __future__ import annotations

import shutil
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import strategies as st

from tests.fuzz.contract import NIGHTLY, asked, fuzz, hold
from tests.fuzz.material import SCENARIO
from tests.fuzz.tables import Damage, damages

DIAGNOSES, PLANS, EXPORTS = 2, 3, 6
"""A ninth of the nightly cases; a diagnosis of a log that is not refused takes seconds, too long for every run."""
pytestmark = pytest.mark.slow
FIELD = ("--field-strength-nT", "44721")
FORMS = ("c", "px4", "ardupilot", "ros")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A directory with the scenario, and a run of some forty seconds, long enough for a diagnosis."""
    place = tmp_path_factory.mktemp("run")
    (place / "tiny.toml").write_text(SCENARIO.replace("duration_s = 12.0", "duration_s = 40.0"))
    assert hold(place / "none", "simulate", str(place / "tiny.toml"), "-o", str(place / "run"), "--jobs", "1") == 0
    return place


@pytest.fixture(scope="module")
def run(place: Path) -> pa.Table:
    """The run's rows, with its metadata."""
    return pq.read_table(place / "run" / "run-00000.parquet", partitioning=None)


def damaged_log(place: Path, table: pa.Table, case: tuple[Damage, ...]) -> str:
    """Write the damaged table; return its path."""
    metadata = table.schema.metadata
    for one in case:
        table = one.to(table)
    pq.write_table(table.replace_schema_metadata(metadata), place / "log.parquet")
    return str(place / "log.parquet")


def test_logs_to_diagnose(place: Path, run: pa.Table) -> None:
    model = str(place / "tiny.toml")

    def check(case: tuple[Damage, ...]) -> None:
        asked(place, "diagnose", damaged_log(place, run, case), "--model", model)

    fuzz(damages(run.column_names), check, DIAGNOSES, NIGHTLY)


def test_logs_to_go_on_from(place: Path, run: pa.Table) -> None:
    def check(case: tuple[Damage, ...]) -> None:
        log = damaged_log(place, run, case)
        asked(place, "plan", "turntable", "--time", "60", "--trials", "0", "--after", log)

    fuzz(damages(run.column_names), check, PLANS, NIGHTLY)


def test_exports(place: Path, run: pa.Table) -> None:
    """Parameters for an autopilot are written for a calibration that is ok, or not at all."""

    def check(case: tuple[tuple[Damage, ...], str]) -> None:
        log = damaged_log(place, run, case[0])
        shutil.rmtree(place / "out", ignore_errors=True)
        words = ("calibrate", log, "--with", "ellipsoid", "--export", case[1], *FIELD)
        hold(
            place / "out", *words, "-o", str(place / "out"), "--json"
        )  # what is not exported is calibrated all the same
        for path in (one for one in (place / "out").rglob("*") if one.suffix in (".h", ".params", ".param", ".yaml")):
            assert not {"nan", "inf"} & set(path.read_text().lower().replace(",", " ").split()), path

    fuzz(st.tuples(damages(run.column_names), st.sampled_from(FORMS)), check, EXPORTS, NIGHTLY)
