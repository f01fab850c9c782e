"""What passes a problem's chain, and the noise of neighbours where rows repeat the one before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.problem.motion import held, pauses_after
from sim.chain import apply_deterministic
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.effects.geometry import Misalignment, NonOrthogonality, Scale
from sim.effects.iron import HardIron, SoftIron
from sim.effects.offsets import SensorOffset
from tests.diagnosis.synthetic import FIELD_ENU_NT, STRENGTH_NT, problem, recording

GIVEN = tuple(one(**one.example) for one in (SoftIron, HardIron, Misalignment, NonOrthogonality, Scale, SensorOffset))
ADDS = [one for one in EFFECTS if one.stage == "vehicle" and one is not HardIron]


@pytest.mark.parametrize("effect", ADDS, ids=lambda one: one.name)
@pytest.mark.parametrize("given", [GIVEN, GIVEN[::-1]], ids=["physical", "reversed"])
def test_an_effect_meets_what_stands_ahead_and_passes_what_stands_behind(
    effect: type[Effect], given: tuple[Effect, ...]
) -> None:
    """But for a constant, which is hard iron."""
    posed, made = problem(recording(600), given), effect(**effect.example)
    with_it, without = (apply_deterministic(some, posed.state)[0] for some in (insert_effects(given, [made]), given))
    own = made.apply(posed.state, posed.input_nT(effect), np.random.default_rng(0), {})
    off = own @ posed.matrix_behind(effect).T - (with_it - without)
    assert off == pytest.approx(np.tile(off[0], (600, 1)), abs=1e-6)


def test_without_a_model_all_that_differs_is_iron() -> None:
    """Which an effect of the vehicle or of the sensor stands behind, and the earth's field before."""
    posed = problem(hidden={"soft_iron": {"matrix": SoftIron.example["matrix"]}})
    assert posed.turn - np.eye(3) == pytest.approx(np.array(SoftIron.example["matrix"]), abs=1e-3)
    for one in EFFECTS:
        assert posed.matrix_behind(one) == pytest.approx(posed.turn if one.stage == "field" else np.eye(3))


def test_a_leg_at_rest_without_noise_poses_a_problem() -> None:
    """The simulator's vehicle at rest: the same values for all but the rounding of a few."""
    turning = recording(400, noise_nT=1e-3)
    assert turning.att_q is not None
    mag_nT = np.tile(turning.mag_nT[:1], (400, 1))
    mag_nT[200, 2] += 1e-11
    resting = replace(turning, mag_nT=mag_nT, att_q=np.tile(turning.att_q[:1], (400, 1)))
    posed = pose(resting, Known(FIELD_ENU_NT, STRENGTH_NT))
    assert (posed.sigma_nT > 0).all()
    assert np.isfinite(posed.turn).all()


@pytest.mark.parametrize(("share", "found"), [(0.001, False), (0.003, True)])
def test_a_few_rows_that_are_repeated_are_held_where_no_rounding_brings_them_together(
    share: float, found: bool
) -> None:
    mag_nT = np.random.default_rng(0).normal(size=(2000, 3))
    again = np.arange(1, 2000, round(1 / share))
    mag_nT[again] = mag_nT[again - 1]
    assert held(mag_nT, mag_nT, STANDARD).any() == found


@pytest.mark.parametrize(("times", "found"), [(3, False), (8, True)])
def test_rows_are_held_beyond_what_rounding_repeats(times: int, found: bool) -> None:
    """Noise of 1 rounded to 1 repeats 2 % of its rows: 0.28 of each axis."""
    mag_nT = np.round(np.random.default_rng(0).normal(size=(4000, 3)))
    chance = 1 / (2 * np.sqrt(np.pi)) ** 3
    again = np.arange(1, 4000, round(1 / ((times - 1) * chance)))
    mag_nT[again] = mag_nT[again - 1]
    assert held(mag_nT, mag_nT, STANDARD).any() == found


@pytest.mark.parametrize(("intervals", "count"), [(4.0, 0), (6.0, 1)])
def test_a_gap_of_some_intervals_is_a_pause(intervals: float, count: int) -> None:
    time_s = np.arange(100.0)
    time_s[50:] += intervals - 1.0
    assert len(pauses_after(time_s, STANDARD)) == count
