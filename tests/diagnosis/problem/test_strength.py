"""A scalar magnetometer beside the vector one is the strength, sample by sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import rank_candidates
from diagnosis.library.candidates import Candidate, propose_candidates
from diagnosis.problem.formulation import pose
from diagnosis.problem.formulation import pose_model as problem_of
from diagnosis.problem.known import Known
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.sensors import needs_field
from diagnosis.problem.strength import turns_too_fast
from diagnosis.workflow import diagnose
from recordings import Recording
from recordings.channels import SCALAR
from scenarios.errors import InputError
from sim.effects.nonlinearity import Hysteresis
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, NOISE_NT, STRENGTH_NT, recording, without_attitude


def in_a_changing_field() -> tuple[Recording, np.ndarray]:
    """Without attitude, in a field whose strength changes by 2 parts in a thousand along the path."""
    given = recording()
    share = 1 + 2e-3 * np.sin(np.arange(len(given)) / 170.0)
    return replace(given, mag_nT=given.mag_nT * share[:, None], att_q=None), STRENGTH_NT * share


def pose_model(given: Recording) -> LinearProblem:
    return pose(given, Known(FIELD_ENU_NT, STRENGTH_NT))


def left_nT(problem: LinearProblem) -> float:
    """Rms of what iron fitted anew leaves."""
    return float(np.sqrt(((Baseline.of(problem).residual() * problem.sigma_nT) ** 2).mean()))


def test_a_field_that_changes_along_the_path_is_no_gap_where_its_strength_is_measured() -> None:
    given, strength_nT = in_a_changing_field()
    noise = np.random.default_rng(3).normal(scale=0.1, size=len(given))
    measured = replace(given, channels={**given.channels, SCALAR: strength_nT + noise})
    assert left_nT(pose_model(given)) > 10 * NOISE_NT
    assert left_nT(pose_model(measured)) == pytest.approx(NOISE_NT, rel=0.05)


def test_the_measured_strength_goes_before_a_stated_one() -> None:
    given, strength_nT = in_a_changing_field()
    scaled = replace(given, channels={**given.channels, SCALAR: 1.01 * strength_nT})
    size_nT = np.linalg.norm(pose_model(scaled).state.field_nT, axis=1)
    assert size_nT == pytest.approx(1.01 * STRENGTH_NT, rel=3e-3)


def test_where_the_strength_is_measured_no_field_need_be_known() -> None:
    given, strength_nT = in_a_changing_field()
    measured = replace(given, channels={SCALAR: strength_nT})
    nobody_says = problem_of(measured, ModelSpec(), None, None)
    assert not needs_field(measured, ModelSpec(), stated=False)
    assert needs_field(given, ModelSpec(), stated=False)
    assert left_nT(nobody_says) == pytest.approx(NOISE_NT, rel=0.05)
    assert np.linalg.norm(nobody_says.state.field_enu_nT) == pytest.approx(STRENGTH_NT, rel=3e-3)


def test_a_strength_with_gaps_is_left_and_one_that_is_none_is_refused() -> None:
    given, strength_nT = in_a_changing_field()
    gaps, none = strength_nT.copy(), strength_nT - STRENGTH_NT
    gaps[5] = np.nan
    assert left_nT(pose_model(replace(given, channels={SCALAR: gaps}))) > 10 * NOISE_NT
    with pytest.raises(InputError, match="strength of a field"):
        pose_model(replace(given, channels={SCALAR: none}))


def test_what_follows_the_fields_rate_is_found_without_attitude_and_gyro() -> None:
    """The rate is that of the field that is measured: its direction turns, and the strength shows what that induces."""
    matrix = [[0.02, 0.01, 0.0], [-0.01, -0.02, 0.015], [0.0, 0.01, 0.01]]
    given = without_attitude(recording(hidden={"eddy_current": {"matrix_s": matrix}}, noise_nT=5.0))
    assert given.gyro_rad_s is None
    gap = pose_model(given)
    assert rank_candidates(Baseline.of(gap), propose_candidates(gap))[0].name == "eddy_current"


def test_a_play_that_is_never_left_is_iron() -> None:
    """Its columns are those of the base: along a smoothed direction they followed the noise, and had a name."""
    level = pose_model(without_attitude(recording(noise_nT=40.0)))
    columns = Candidate(Hysteresis, (("threshold_nT", 1e6),)).columns(level)[:, 0]
    left = columns - level.base @ np.linalg.lstsq(level.base, columns, rcond=None)[0]
    assert np.abs(left).max() < 1e-6 * np.abs(columns).max()


def test_a_magnet_that_turns_beside_a_sensor_at_rest_is_no_motion_of_it() -> None:
    """An ellipse, four times a second, beside a slow drift: iron lays it on a sphere, on which a drift has a name."""
    rng, time_s = np.random.default_rng(0), np.arange(4000) * 0.02
    phase = 2 * np.pi * np.cumsum(4 + 0.3 * time_s / time_s[-1]) * 0.02
    ellipse = np.outer(np.cos(phase), [4.2e4, 1e3, 5e3]) + np.outer(np.sin(phase), [-3e3, 4e3, -4.8e4])
    mag_nT = np.array([-5.5e4, -2.9e4, 1.8e4]) + ellipse + 800.0 * np.outer(time_s / time_s[-1], [1.0, 0.0, 1.0])
    seen = Recording(time_s=time_s, mag_nT=mag_nT + 600.0 * rng.normal(size=mag_nT.shape))
    told = diagnose(seen, ModelSpec(), strength_nT=48_000.0, fitted_base=True)
    assert told.verdict == "unknown"
    assert told.sentence.startswith("The field turns at")
    assert not told.named
    turned = replace(seen, gyro_rad_s=np.tile([0.0, 26.0, 0.0], (len(time_s), 1)))
    assert not turns_too_fast(pose_model(turned))
