"""A logged attitude at other times than its own, repeated by a log, and the rate of turn from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.motion import attitude_at, attitude_at_its_time, attitude_course, quieter_rate
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.arrays import Array
from sim.rotation import matrix_from_q
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import ALL_BUT_SEVEN, FIELD_ENU_NT, recording

TIME_S = np.arange(0.0, 20.0, 0.1)


def _turned(time_s: Array) -> Array:
    """Quaternions (n, 4) of turns about the vertical at 0.3 rad/s."""
    half = 0.15 * time_s
    return np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)


def test_between_its_values_an_attitude_turns_on_whichever_sign_they_have() -> None:
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(len(TIME_S), 1))
    between_s = TIME_S[:-1] + 0.04
    found = attitude_at(attitude_course(TIME_S, signs * _turned(TIME_S)), between_s)
    assert matrix_from_q(found) == pytest.approx(matrix_from_q(_turned(between_s)), abs=1e-6)


def test_behind_its_last_value_an_attitude_stands() -> None:
    """How it turned on is not known."""
    found = attitude_at(attitude_course(TIME_S, _turned(TIME_S)), TIME_S[-1] + np.array([0.0, 1.0, 50.0]))
    assert found == pytest.approx(np.repeat(_turned(TIME_S[-1:]), 3, axis=0))


@pytest.mark.parametrize(("every", "derived"), [(13, True), (8, False)])
def test_an_attitude_that_is_held_gives_no_rate(every: int, derived: bool) -> None:
    """A tenth of its rows may be: however noisy the gyro is."""
    q = _turned(TIME_S)
    again = np.arange(1, len(q), every)
    q[again] = q[again - 1]
    gyro = np.random.default_rng(0).normal(size=(len(q), 3))
    given = Recording(time_s=TIME_S, mag_nT=np.zeros((len(q), 3)), att_q=q, gyro_rad_s=gyro)
    assert (quieter_rate(given, STANDARD) is not gyro) is derived


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
    told = diagnose(late, MODEL, fitted_base=True, without=ALL_BUT_SEVEN)
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
