"""`magbench read`, and what a log tells of itself on its way to an answer."""

from __future__ import annotations

import datetime
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from ppigrf import igrf
from scipy.spatial.transform import Rotation

import magbench
from magbench.cli import main
from recordings import Origin, Recording, read_recording, write_recording
from recordings.applied import AppliedCalibration
from scenarios.errors import InputError

ZURICH, DAY = (47.3977, 8.5456, 488.0), datetime.date(2024, 5, 1)
OFFSET_NT = np.array([1200.0, -800.0, 2500.0])
IN_FORCE = AppliedCalibration(
    "px4", 1, np.array([10.0, -20.0, 30.0]), np.diag([1.1, 0.9, 1.0]), {"CAL_MAG1_XOFF": 1e-4, "CAL_MAG1_ID": 73225.0}
)
TOLD = Origin(frame="frd", magnetometer="1", magnetometers=("0", "1"), place=ZURICH, date=DAY, applied=IN_FORCE)


STRENGTH_NT = float(np.linalg.norm([*map(np.ravel, igrf(ZURICH[1], ZURICH[0], 0.488, datetime.datetime(2024, 5, 1)))]))


def tumble() -> Recording:
    """A full tumble in Zurich with a hard iron of OFFSET_NT and 20 nT of noise; the log tells place and date."""
    rng = np.random.default_rng(3)
    up = Rotation.random(900, random_state=4).apply([0.0, 0.0, STRENGTH_NT])
    return Recording(np.arange(900) * 0.1, up + OFFSET_NT + rng.normal(0, 20, (900, 3)), origin=TOLD)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    write_recording(tumble(), tmp_path / "flight.parquet")
    return tmp_path / "flight.parquet"


def test_what_a_log_tells_comes_back_from_parquet(log: Path) -> None:
    found = read_recording(log).origin
    assert (found.frame, found.magnetometer, found.place, found.date) == ("frd", "1", ZURICH, DAY)
    assert found.applied is not None
    assert_array_equal(found.applied.matrix, IN_FORCE.matrix)
    assert found.applied.parameters == IN_FORCE.parameters


def test_the_columns_of_a_log_that_was_turned_are_not_turned_again(log: Path) -> None:
    assert_array_equal(read_recording(log, reading=magbench.Reading(frame="frd")).mag_nT, read_recording(log).mag_nT)


def test_place_and_date_in_a_log_give_the_field(log: Path) -> None:
    found = magbench.calibrate(log)
    assert found.reference.strength_nT == pytest.approx(STRENGTH_NT, abs=0.1)
    assert found.status.kind == "ok"
    np.testing.assert_allclose(found.offset_nT, OFFSET_NT, atol=10)


def test_what_the_user_states_counts_before_what_the_log_tells(log: Path) -> None:
    assert magbench.calibrate(log, 50_000).reference.strength_nT == 50_000
    moved = magbench.calibrate(log, reading=magbench.Reading(place=(0.0, 0.0), date=DAY))
    assert moved.reference.strength_nT < 35_000


def test_a_place_without_a_date_asks_for_the_date(tmp_path: Path) -> None:
    write_recording(replace(tumble(), origin=replace(TOLD, date=None)), tmp_path / "a.parquet")
    with pytest.raises(InputError, match="date"):
        magbench.calibrate(tmp_path / "a.parquet")


def test_the_summary_tells_magnetometer_place_field_and_calibration(
    log: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(["read", str(log), "--json"]) == 0
    told = json.loads(capfd.readouterr().out)
    assert (told["format"], told["samples"], told["frame"]) == ("Parquet", 900, "frd")
    assert np.hypot.reduce(told["field_enu_nT"]) == pytest.approx(STRENGTH_NT, abs=0.1)
    assert told["applied"]["parameters"]["CAL_MAG1_ID"] == 73225
    assert main(["read", str(log)]) == 0
    assert "calibration in force (px4, compass 1), undone: b (10, -20, 30) nT" in capfd.readouterr().out


def test_a_log_is_not_replaced_by_its_recording(log: Path) -> None:
    before = log.read_bytes()
    assert main(["read", str(log), "-o", str(log)]) == 2
    assert log.read_bytes() == before


def test_damaged_facts_of_a_log_are_refused(log: Path, tmp_path: Path) -> None:
    data = log.read_bytes().replace(b'"frame":"frd"', b'"frame":12345')
    (tmp_path / "damaged.parquet").write_bytes(data)
    with pytest.raises(InputError, match="magbench_log"):
        read_recording(tmp_path / "damaged.parquet")
