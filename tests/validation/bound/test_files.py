"""The experiment behind a scenario and a log: field, sensor and noise as they were."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from recordings import write_recording
from scenarios.errors import InputError
from sim.scenario import load
from tests.calib import conftest as standard
from tests.validation.bound.experiments import ACCEL_STD_M_S2, of_motion
from validation.bound.bound import Bound
from validation.bound.files import recording_experiment, scenario_experiment
from validation.bound.knowledge import KNOWLEDGE
from validation.bound.unobservable import observable, weak_directions

STRENGTH_NT = standard.REFERENCE.strength_nT


@pytest.mark.parametrize("attitude", [True, False])
def test_of_a_log(tmp_path: Path, attitude: bool) -> None:
    """Noise, matrix and bound as the truth gives them, to what six minutes tell."""
    recording = standard.with_accelerometer(standard.recording("full", 0))
    noise_m_s2 = np.random.default_rng(0).normal(0.0, ACCEL_STD_M_S2, recording.accel_m_s2.shape)
    recording = replace(recording, accel_m_s2=recording.accel_m_s2 + noise_m_s2)
    write_recording(recording if attitude else replace(recording, att_q=None), tmp_path / "log.parquet")
    enu = standard.FIELD_ENU_NT if attitude else None
    known = recording_experiment(tmp_path / "log.parquet", strength_nT=STRENGTH_NT, enu=enu)
    assert known.noise_std_nT == pytest.approx(standard.NOISE_STD_NT, rel=0.05)
    np.testing.assert_allclose(known.matrix, standard.SOFT, atol=1e-3)
    for knowledge in KNOWLEDGE if attitude else KNOWLEDGE.keys() - {"norm+gyro+accel"}:
        expected = Bound.of(of_motion("full"), knowledge).offset_rms_nT
        assert Bound.of(known, knowledge).offset_rms_nT == pytest.approx(expected, rel=0.1)


def test_of_a_scenario() -> None:
    known = scenario_experiment(load("standard-full"))
    assert known.noise_std_nT == 10.0  # as stated, not as the draws of one run scatter
    np.testing.assert_allclose(known.matrix, standard.SOFT, atol=1e-9)
    assert scenario_experiment(load("standard-full"), 3.0).noise_std_nT == 3.0


def test_iron_is_no_motion_where_the_attitude_is_known(tmp_path: Path) -> None:
    """Level turns with a strong hard iron that no calibration can take off: the vertical offset stays untold."""
    flat = standard.level_turns(1200, 0)
    write_recording(replace(flat, mag_nT=flat.mag_nT + np.array([8000.0, 0.0, 0.0])), tmp_path / "log.parquet")
    known = recording_experiment(tmp_path / "log.parquet", enu=standard.FIELD_ENU_NT)
    assert known.noise_std_nT == pytest.approx(standard.NOISE_STD_NT, rel=0.1)
    assert np.ptp(known.directions[:, 2]) < 1e-9
    assert np.isinf(Bound.of(known, "vector").offset_std_nT[2])


def test_a_level_turn_is_a_bound_and_no_error(tmp_path: Path) -> None:
    write_recording(standard.level_turns(1200, 0), tmp_path / "log.parquet")
    known = recording_experiment(tmp_path / "log.parquet", strength_nT=STRENGTH_NT)
    bound = Bound.of(known, "norm")
    assert not observable(known, bound)
    assert any("offset_z" in weak.what for weak in weak_directions(known, bound))


def test_without_turns_there_is_no_gyro(tmp_path: Path) -> None:
    write_recording(replace(standard.recording("full", 0), att_q=None, gyro_rad_s=None), tmp_path / "log.parquet")
    known = recording_experiment(tmp_path / "log.parquet", strength_nT=STRENGTH_NT)
    with pytest.raises(InputError, match="neither gyro nor attitude"):
        Bound.of(known, "norm+gyro")
