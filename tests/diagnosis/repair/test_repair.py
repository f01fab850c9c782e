"""Refined parameters against the closed form, open directions, joined chains, and a second recording."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.evidence.baseline import Baseline
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.repair.refinement import chain_residual, determined, predict, refine
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects import BY_NAME, EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.effects.dynamics import Latency
from sim.effects.earth import RegionalField
from sim.effects.electronics import Quantisation
from sim.effects.free_parameters import FreeParameters
from sim.effects.iron import SoftIron
from sim.effects.noise import WhiteNoise
from sim.effects.nonlinearity import Hysteresis
from sim.effects.offsets import OffsetJump
from tests.diagnosis.synthetic import problem, recording, without_attitude

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
GAIN = (2.0, -1.0, 4.0)
TRUTH = DRIVEN(**{DRIVEN.linear[0]: GAIN})
STRONG = DRIVEN(**{DRIVEN.linear[0]: (200.0, -100.0, 400.0)})
START = DRIVEN(**{DRIVEN.linear[0]: (1.5, -0.5, 3.0)})
EVERY = np.ones(4000, bool)
IRON = {
    "soft_iron": {"matrix": [[0.3, 0.1, 0.0], [0.1, -0.2, 0.0], [0.0, 0.1, 0.2]]},
    "hard_iron": {"offset_nT": [1200.0, 800.0, -2000.0]},
}
CORE: dict[str, Any] = {
    "rounded_gain": (0.01,) * 3, "rounded_threshold_nT": 2000.0, "rounded_start_nT": (-20.0, 30.0, 10.0),
}  # fmt: skip


def _dense(refit_iron: bool) -> tuple[Array, Array]:
    """Coefficients and standard deviations by one least squares on all columns: the effect is linear in its gain."""
    posed = problem(hidden={DRIVEN.name: {DRIVEN.linear[0]: GAIN}})
    columns = Candidate(DRIVEN).contribution_nT(posed).reshape(-1, 3)
    if refit_iron:  # of the iron, which is nearly one, only what is beside the effect matters
        iron = np.column_stack([posed.predicted_nT / 5e4, np.ones(4000)])
        base = np.kron(iron[:, None, :], np.eye(3)).reshape(-1, 12)
        columns = np.concatenate([columns, base], axis=1)
    weight = 1 / np.tile(posed.sigma_nT, 4000)
    A = columns * weight[:, None]
    b = ((posed.recording.mag_nT - posed.predicted_nT).ravel()) * weight
    size = np.linalg.norm(A, axis=0)
    c = np.linalg.lstsq(A / size, b, rcond=None)[0] / size
    std = np.sqrt(np.diag(np.linalg.inv((A / size).T @ (A / size)))) / size
    return c[:3], std[:3]


@pytest.mark.parametrize("refit_iron", [True, False])
def test_refined_parameters_are_those_of_the_closed_form(refit_iron: bool) -> None:
    posed = problem(hidden={DRIVEN.name: {DRIVEN.linear[0]: GAIN}})
    (fine,), (spread,) = refine(posed, [START], EVERY, refit_iron=refit_iron)
    c, std = _dense(refit_iron)
    assert getattr(fine, DRIVEN.linear[0]) == pytest.approx(c, abs=0.02 * std.max() + 1e-3)
    assert spread[DRIVEN.linear[0]] == pytest.approx(std, rel=0.02)
    assert np.abs(c - GAIN).max() < 4 * std.max()


def test_colour_widens_by_its_root() -> None:
    posed = problem(hidden={DRIVEN.name: {DRIVEN.linear[0]: GAIN}})
    plain, wide = (refine(posed, [START], EVERY, V)[1][0][DRIVEN.linear[0]] for V in (1.0, 9.0))
    assert wide == pytest.approx(3 * plain, rel=1e-6)


def test_a_state_of_the_start_is_fitted_to_the_start() -> None:
    """Where it decays in a second, segments that begin later say nothing of it, and what they fit is anything."""
    core = Hysteresis(**CORE)
    posed = problem(hidden={core.name: CORE})
    train = ~Baseline.of(posed, [Candidate.of(core).columns(posed)]).held_out_samples()
    left = chain_residual(posed, refine(posed, [core], train)[0], train)
    assert np.abs(left[:20]).max() < 5


def test_without_attitude_nothing_is_refined() -> None:
    posed = problem(without_attitude(recording()))
    assert refine(posed, [START], EVERY)[0] == (START,)


def test_a_direction_that_the_data_leave_open_has_no_interval() -> None:
    """Two columns alike: their sum is known, each of them is not; the third is."""
    rng = np.random.default_rng(0)
    J = rng.normal(size=(500, 3))
    J[:, 1] = J[:, 0] * 2
    found, _ = determined(J.T @ J, STANDARD)
    assert np.isinf(found[:2]).all()
    assert found[2] == pytest.approx(1 / (J[:, 2] ** 2).sum(), rel=0.05)
    full = rng.normal(size=(500, 3))
    assert determined(full.T @ full, STANDARD)[0] == pytest.approx(np.diag(np.linalg.inv(full.T @ full)))


def test_a_step_goes_nowhere_where_the_data_are_silent() -> None:
    """Of two columns alike only the sum is known: what is added to one and taken from the other is taken back."""
    rng = np.random.default_rng(0)
    J = rng.normal(size=(500, 3))
    J[:, 1] = J[:, 0] * 2
    start, silent = np.array([3.0, 1.0, -2.0]), np.array([2.0, -1.0, 0.0])
    kept = determined(J.T @ J, STANDARD)[1] @ (start + 500 * silent)
    assert J @ kept == pytest.approx(J @ start, rel=1e-6)
    assert np.linalg.norm(kept) < 5
    assert kept[2] == pytest.approx(start[2])
    full = rng.normal(size=(500, 3))
    assert determined(full.T @ full, STANDARD)[1] == pytest.approx(np.eye(3))


@pytest.mark.parametrize("effect", [e for e in EFFECTS if not e.stochastic], ids=lambda e: e.name)
def test_numbers_go_out_and_come_back(effect: type[Effect]) -> None:
    made = effect(**effect.example)
    numbers = FreeParameters((made, TRUTH))
    again = FreeParameters(numbers.at(numbers.values))
    assert again.values == pytest.approx(numbers.values, rel=1e-9, abs=1e-12)
    assert (numbers.scale > 0).all()
    spread = numbers.spread(numbers.scale)
    assert all(np.shape(part) == np.shape(getattr(made, name)) for name, part in spread[0].items())
    fixed = [p.name for p in made.parameters() if p.role in ("fixed", "motor", "moment")]
    assert not set(fixed) & set(spread[0])


def test_new_effects_stand_at_their_physical_place() -> None:
    given = (WhiteNoise((1.0,) * 3), Quantisation(1.0))
    order = [effect.name for effect in insert_effects(given, [TRUTH, OffsetJump()])]
    rank = {name: i for i, name in enumerate(BY_NAME)}
    assert order == sorted(order, key=rank.__getitem__)
    assert insert_effects((TRUTH,), [START]) == (TRUTH, START)


def test_a_prediction_is_smooth_where_the_converter_rounds() -> None:
    posed = problem(model=(Quantisation(100.0),))
    assert len(np.unique(predict(posed, [TRUTH])[:, 0])) > 3000


def test_without_a_model_what_is_fitted_predicts_the_measurement() -> None:
    given = recording(noise_nT=0.1, hidden=IRON)
    left_nT = given.mag_nT - predict(replace(problem(given), iron_known=False), ())
    assert np.sqrt((left_nT**2).mean()) == pytest.approx(0.1, rel=0.05)


@pytest.mark.parametrize(
    "effect", [RegionalField((300.0, -200.0, 100.0)), Latency(0.3), STRONG], ids=lambda one: one.name
)
def test_a_correction_of_the_iron_turns_what_is_ahead_of_it_or_follows_the_field(effect: Effect) -> None:
    """The model has no iron, of which the sensor has much: with it fitted only the noise is left."""
    values = {p.name: getattr(effect, p.name) for p in effect.parameters() if getattr(effect, p.name) is not None}
    left = chain_residual(problem(hidden=IRON | {effect.name: values}), [effect], EVERY)
    assert np.sqrt((left**2).mean()) == pytest.approx(1.0, abs=0.05)


def test_iron_is_brought_into_its_bounds() -> None:
    """A direction that a motion hardly shows has any coefficient."""
    soft, _ = replace(problem(), turn=np.diag([1.0, 1.0, -1e3])).fitted_iron
    assert soft.coefficients().reshape(3, 3) == pytest.approx(np.diag([0.0, 0.0, SoftIron.parameters()[0].low]))


def test_the_right_effect_takes_the_gap_away() -> None:
    posed = problem(hidden={DRIVEN.name: {DRIVEN.linear[0]: GAIN}})
    for train in (None, EVERY):
        before, after = (float((chain_residual(posed, new, train) ** 2).mean()) for new in ([], [TRUTH]))
        assert before > 1.5
        assert after == pytest.approx(1.0, abs=0.08)


def test_numbers_that_do_not_go_together_are_refused() -> None:
    numbers = FreeParameters((TRUTH,))
    assert numbers.at(np.array([1e12, 0.0, 0.0]))[0].coefficients()[0] < 1e12
    with pytest.raises((InputError, ValueError)):
        numbers.at(np.array([np.nan, 0.0, 0.0]))
    assert replace(TRUTH) == TRUTH


@pytest.mark.parametrize(("apart", "open_"), [(5e-6, True), (2e-5, False)])
def test_two_parameters_are_open_where_their_correlation_leaves_next_to_nothing(apart: float, open_: bool) -> None:
    """The lesser eigenvalue of ``[[1, r], [r, 1]]`` is 1 - r."""
    gram = np.array([[1.0, 1 - apart], [1 - apart, 1.0]])
    variances, onto_determined = determined(gram, STANDARD)
    assert bool(np.isinf(variances).all()) is open_
    kept = onto_determined @ [1.0, -1.0]
    assert bool(np.abs(kept).max() < 0.5) is open_


@pytest.mark.parametrize(("part", "open_"), [(5e-4, False), (2e-3, True)])
def test_a_parameter_of_which_next_to_nothing_is_open_is_known(part: float, open_: bool) -> None:
    """A third that takes a part in what two alike leave open."""
    silent = np.array([1.0, -1.0, np.sqrt(part)])
    J = np.random.default_rng(0).normal(size=(5000, 3))
    J -= np.outer(J @ silent, silent) / (silent @ silent)  # the first two are then of half the power
    assert np.isinf(determined(J.T @ J, STANDARD)[0]).tolist() == [True, True, open_]
