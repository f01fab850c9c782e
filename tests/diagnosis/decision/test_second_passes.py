"""Recordings without attitude: strong disturbances, little motion, wanders of one axis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from diagnosis.decision import second_passes
from diagnosis.decision.second_passes import select_jointly
from diagnosis.decision.selection import select
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.arrays import Array
from sim.effects import BY_NAME
from sim.effects.currents import MotorCurrent
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import ALL_BUT_SEVEN
from tests.nightly import first_daily

FIELD_NT = 48_000.0
NOISE_NT, INTERVAL_S, SAMPLES = 20.0, 0.1, 6000
IRON = np.array([[1.05, 0.02, -0.01], [0.02, 0.97, 0.03], [-0.01, 0.03, 1.02]])
OFFSET_NT = np.array([800.0, -1500.0, 2500.0])
SIDE = np.array([0.6, -0.3, 0.74])


def _course(rng: np.random.Generator, memory_s: float) -> Array:
    values = gaussian_filter1d(rng.normal(size=SAMPLES), memory_s / INTERVAL_S)
    return np.asarray(values / values.std())


def _turned_by_hand(seed: int, tilt_deg: float, gain_nT_A: float = 0.0, wander_nT: float = 0.0) -> Recording:
    """Turns about the vertical with some tilt, a current that switches, a random walk of each axis."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(SAMPLES) * INTERVAL_S
    yaw = 2.0 * time_s + 9.0 * np.cumsum(_course(rng, 20.0)) * INTERVAL_S
    angles = np.column_stack([yaw, tilt_deg * _course(rng, 3.0), tilt_deg * _course(rng, 4.0)])
    field = Rotation.from_euler("ZYX", angles, degrees=True).inv().apply([0.0, 0.42 * FIELD_NT, -0.9075 * FIELD_NT])
    current = np.clip(8 + 2 * _course(rng, 8.0) + 3.0 * np.repeat(rng.random(SAMPLES // 300) > 0.5, 300), 0.0, None)
    walk = np.cumsum(rng.normal(size=(SAMPLES, 3)), axis=0)
    mag = field @ IRON + OFFSET_NT + np.outer(gain_nT_A * current, SIDE) + wander_nT * walk / walk.std()
    return Recording(time_s=time_s, mag_nT=mag + NOISE_NT * rng.normal(size=mag.shape), current_A=current[:, None])


def _diagnosed(recording: Recording, without: frozenset[str] = ALL_BUT_SEVEN) -> Diagnosis:
    strength_nT = float(np.hypot(0.42, 0.9075) * FIELD_NT)
    return diagnose(recording, ModelSpec(), strength_nT=strength_nT, fitted_base=True, without=without)


def _gain(found: Diagnosis) -> Array:
    (named,) = found.named
    assert isinstance(named.effect, MotorCurrent)
    return np.array(named.effect.gain_nT_A)


@pytest.mark.parametrize("unit_nT", first_daily([100.0, 1.0]))
def test_a_strong_disturbance_and_iron_are_found_jointly(unit_nT: float) -> None:
    """Linearised about iron that was fitted without it, a hundred times the noise left structure and a wrong gain.

    Counts for nanotesla are no error.
    """
    given = _turned_by_hand(1, 40.0, gain_nT_A=600.0)
    found = _diagnosed(replace(given, mag_nT=given.mag_nT / unit_nT))
    assert found.verdict is Verdict.NAMED
    assert found.after.clean
    assert np.allclose(unit_nT * _gain(found), 600.0 * SIDE, atol=3.0)
    assert np.allclose(unit_nT * found.problem.turn, IRON, atol=2e-3)


@pytest.mark.parametrize("tilt_deg", first_daily([2.0, 0.0]))
def test_a_motion_that_shows_no_ellipsoid_is_diagnosed_all_the_same(tilt_deg: float) -> None:
    found = _diagnosed(_turned_by_hand(2, tilt_deg, gain_nT_A=200.0))
    assert [one.name for one in found.named] == [MotorCurrent.name]
    sizes = np.linalg.svd(found.problem.turn)[1]
    assert 0.5 < sizes.min() < sizes.max() < 2.0


@pytest.mark.parametrize("seed", first_daily([3, 4, 5]))
def test_a_wander_of_the_axes_that_turns_with_the_field_is_no_effect(seed: int) -> None:
    """Seen by the strength it comes and goes with the direction of the field, as what an effect adds does."""
    found = _diagnosed(_turned_by_hand(seed, 40.0, wander_nT=100.0), frozenset())
    assert not [one for one in found.named if not one.effect.stochastic]


def test_iron_that_leaves_more_than_before_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Effects in a part of the run took the iron with them: the gap had grown by half, and was named."""

    def worse(problem: LinearProblem, disturbance_nT: Array) -> LinearProblem:
        gap = 3 * np.sin(np.arange(len(problem.target)) / 7)[:, None]
        return replace(problem, target=problem.target + gap)

    given = _turned_by_hand(1, 40.0, gain_nT_A=200.0)
    posed = pose(given, Known(None, float(np.hypot(0.42, 0.9075) * FIELD_NT)))
    others = frozenset(BY_NAME) - {MotorCurrent.name}
    once = select(posed, others)
    monkeypatch.setattr(second_passes, "refit_iron", worse)
    again = select_jointly(posed, others)
    assert np.array_equal(again.end.residual(), once.end.residual())


def test_names_that_leave_more_than_was_there_are_none() -> None:
    """A white log of a level rover: iron fitted beside an eddy current of a tenth of the noise left a colour."""
    posed = pose(_turned_by_hand(1, 40.0, gain_nT_A=200.0), Known(None, float(np.hypot(0.42, 0.9075) * FIELD_NT)))
    once = select(posed, frozenset(BY_NAME) - {MotorCurrent.name})
    assert once.accepted
    assert not once.before.clean
    as_bad = replace(once, after=once.before)
    assert [second_passes.rejected_if_worse(one) is one for one in (once, as_bad)] == [True, True]
    worse = second_passes.rejected_if_worse(replace(once, before=once.after, after=once.before))
    assert worse.accepted == ()
    assert worse.after.clean
    assert np.array_equal(worse.end.residual(), once.start.residual())
    assert worse.results[0].outcome.startswith("withdrawn")
