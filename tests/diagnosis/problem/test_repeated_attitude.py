"""A navigation slower than the magnetometer, whose last attitude a log repeats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.motion import attitude_at_its_time
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from recordings import Recording
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, recording

MODEL = ModelSpec.model_validate({"field": {"enu_nT": FIELD_ENU_NT.tolist()}})


def _joined(given: Recording, last_new: np.ndarray) -> Recording:
    """A log whose rows have the attitude of earlier ones."""
    assert given.att_q is not None
    return replace(given, att_q=given.att_q[last_new])


@pytest.mark.parametrize("pace", [2.0, 2.6, 5.0])
def test_a_slower_attitude_is_taken_between_its_own_values(pace: float) -> None:
    given = recording()
    rows = np.arange(len(given))
    is_new = np.diff(rows // pace, prepend=-1.0) > 0
    last_new = np.maximum.accumulate(np.where(is_new, rows, 0))
    problem = pose_model(_joined(given, last_new), MODEL, None, None)
    assert np.sqrt((problem.target**2).mean()) < 1.05
    assert "repeated in" in problem.corrections[0].words


def test_nothing_is_missing_where_an_attitude_repeats() -> None:
    given = recording()
    told = diagnose(_joined(given, np.arange(len(given)) // 5 * 5), MODEL, fitted_base=True)
    assert told.verdict is Verdict.NONE
    assert told.sentence.startswith("The attitude is repeated in 80 % of the rows")
    assert any("own times" in line for line in told.advice)


def test_a_late_and_slower_attitude_is_taken_so_and_moved() -> None:
    """The last rows have an attitude that stands: what is moved to its time does not reach into them."""
    given = recording()
    assert given.att_q is not None
    last_new = 10 + np.arange(len(given) - 10) // 4 * 4
    late = Recording(time_s=given.time_s[10:], mag_nT=given.mag_nT[10:], att_q=given.att_q[last_new - 2])
    told = diagnose(late, MODEL, fitted_base=True)
    assert "comes 200 ms later" in told.sentence
    assert told.verdict is Verdict.NONE


def test_a_rest_is_no_slower_attitude() -> None:
    """Half of the rows are one rest; the others are new each."""
    given = recording()
    rows = np.arange(len(given))
    still = np.where((rows > 1000) & (rows < 3000), 1000, rows)
    resting = _joined(given, still)
    assert attitude_at_its_time(resting, 0.0, STANDARD)[0] is resting


def test_a_rest_stays_one_beside_a_slower_attitude() -> None:
    given = recording()
    rows = np.arange(len(given)) // 4 * 4
    still = np.where((rows > 1000) & (rows < 3000), 1000, rows)
    found, share, unknown = attitude_at_its_time(_joined(given, still), 0.0, STANDARD)
    assert share > 0.3
    assert np.flatnonzero(unknown).tolist() == [3997, 3998, 3999]
    assert found.att_q is not None
    assert given.att_q is not None
    assert found.att_q[1004:2990] == pytest.approx(np.tile(given.att_q[1000], (1986, 1)), abs=1e-6)


def test_a_log_that_repeats_whole_rows_is_told_by_the_magnetometer() -> None:
    given = recording()
    rows = np.arange(len(given)) // 2 * 2
    whole = replace(_joined(given, rows), mag_nT=given.mag_nT[rows])
    assert attitude_at_its_time(whole, 0.0, STANDARD)[1] == 0.0
