"""Windows: the best of all, against plain least squares; an effect that acts in a part of the run is named with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.windowed_candidates import Span, Timeline, _gains, _is_one_sided
from diagnosis.library.candidates import iron_candidates, propose_candidates
from diagnosis.policy import STANDARD
from diagnosis.several.transfer import confirmed
from diagnosis.workflow import diagnose
from sim.effects import EFFECTS
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import (
    COSTLY,
    FIELD_ENU_NT,
    NOISE_NT,
    STRENGTH_NT,
    problem,
    recording,
    without_attitude,
)

WINDOW = (152.0, 228.0)
DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
GAIN = {DRIVEN.linear[0]: [2.0, -1.0, 1.5]}
SWITCHED = {DRIVEN.name: {**GAIN, "active_s": list(WINDOW)}}
MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [NOISE_NT] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)


def test_the_best_window_gains_what_least_squares_says() -> None:
    posed = problem(hidden=SWITCHED)
    rows = BinnedRows.of(posed.state.time_s, posed.usable, posed.base, posed.target, posed.policy)
    columns = propose_candidates(posed)[DRIVEN.name][0].columns(posed)
    span = Timeline.of(rows, np.zeros((len(columns), 3, 0))).best(rows.bin(columns))
    assert np.abs(np.subtract(span[:2], WINDOW)).max() < 0.15
    time_s = posed.state.time_s
    accepted_columns = ((time_s >= span.from_s) & (time_s < span.to_s))[:, None, None]
    base = np.kron(posed.base, np.eye(3))
    for part, gain in ((columns * accepted_columns, span.gain), (columns, span.whole_gain)):
        left = [
            (y - X @ np.linalg.lstsq(X, y, rcond=None)[0])
            for y in [posed.target.ravel()]
            for X in (base, np.column_stack([base, part.reshape(-1, 3)]))
        ]
        assert gain == pytest.approx(((left[0] ** 2).sum() - (left[1] ** 2).sum()) / 2, rel=1e-4)


@pytest.mark.parametrize("attitude", [True, False])
def test_an_effect_in_a_fifth_of_the_run_is_named_with_its_window(attitude: bool) -> None:
    given = recording(hidden=SWITCHED)
    given = given if attitude else without_attitude(given)
    found = diagnose(given, MODEL, strength_nT=STRENGTH_NT, fitted_base=not attitude, without=COSTLY)
    (one,) = found.named
    assert (found.verdict, one.name) == ("named", DRIVEN.name)
    assert one.effect.active_s is not None
    assert np.abs(np.subtract(one.effect.active_s, WINDOW)).max() < 1.0
    assert "from {:.4g} s to {:.4g} s".format(*one.effect.active_s) in found.sentence
    told = found.as_dict()["effects"][0]
    assert told["interval_s"] == list(one.effect.active_s)
    assert "active_s" in found.model.effects.written[DRIVEN.name]
    if attitude:
        error = np.abs(np.subtract(getattr(one.effect, DRIVEN.linear[0]), GAIN[DRIVEN.linear[0]]))
        assert (error < 4 * one.spread[DRIVEN.linear[0]]).all()
        assert confirmed(found, recording(hidden=SWITCHED, seed=3), MODEL, None, None).named[0].transfer == "single-run"


def test_a_magnet_brought_near_is_hard_iron_in_a_window_and_the_iron_beside_it_is_the_clean_runs() -> None:
    magnet = {"hard_iron": {"offset_nT": [6.0, -4.0, 4.0], "active_s": list(WINDOW)}}
    loud, clean = (diagnose(recording(hidden=one), MODEL, fitted_base=True, without=COSTLY) for one in (magnet, {}))
    assert [one.name for one in loud.named] == ["hard_iron"]
    assert clean.verdict == "none"
    state = clean.problem.state
    design = np.column_stack([state.field_nT, np.ones(len(state))])
    std = np.sqrt(np.diag(np.linalg.inv(design.T @ design)))[3] * NOISE_NT
    always = [
        next(e for e in found.model.chain() if e.name == "hard_iron" and e.active_s is None) for found in (loud, clean)
    ]
    off = np.subtract(*(one.offset_nT for one in always))  # type: ignore[attr-defined]
    assert np.abs(off).max() < 1.96 * std


def test_what_acts_always_gets_no_window() -> None:
    found = diagnose(recording(hidden={DRIVEN.name: GAIN}), MODEL, without=COSTLY)
    assert [(one.name, one.effect.active_s) for one in found.named] == [(DRIVEN.name, None)]
    assert found.as_dict()["effects"][0]["interval_s"] is None


def test_a_recording_of_some_samples_has_every_column_cut() -> None:
    given = recording(400)
    given = replace(given, phase=np.array(["a", "b"] * 200), array_mag_nT=np.stack([given.mag_nT, 2 * given.mag_nT]))
    some = np.arange(400) % 3 == 0
    part = given.taken(some)
    assert len(part) == part.array_mag_nT.shape[1] == len(part.phase) == some.sum()  # type: ignore[union-attr,arg-type]
    assert (part.mag_nT == given.mag_nT[some]).all()
    assert all((part.channels[name] == values[some]).all() for name, values in given.channels.items())


def test_a_column_that_is_zero_in_a_window_gains_nothing_there() -> None:
    """Sums of a window are differences of cumulated ones: what is zero there comes out as their rounding."""
    products = np.array([[3.0, 2.0, 0.0], [1e-9, 0.0, 0.0]])
    whole = np.array([[3.0, 2.0, 0.0], [5.0, 0.0, 1e6]])
    both = _gains(np.stack([products, whole]), 0)
    assert both[0] == pytest.approx(3.0**2 / 2.0 / 2, rel=1e-4)
    assert both[1] == pytest.approx((3.0**2 / 2.0 + 5.0**2 / 1e6) / 2, rel=1e-4)


@pytest.mark.parametrize(
    ("from_s", "to_s", "one_sided"),
    [(0.0, 150.0, True), (0.1, 150.0, True), (150.0, 399.0, True), (40.0, 150.0, False), (0.1, 399.9, True)],
)
def test_a_window_with_no_room_for_another_beside_it_is_as_a_jump_is(
    from_s: float, to_s: float, one_sided: bool
) -> None:
    """One sample of 400 s at a run's beginning tells no window from what is so until a moment."""
    time_s = np.arange(4000) / 10.0
    assert _is_one_sided(Span(from_s, to_s, 50.0, 0.0), time_s, STANDARD) is one_sided


def test_a_short_window_is_found_by_its_own_times() -> None:
    """The first search takes longer ones than 3 s of 400 s; the ends then move as far as they gain."""
    posed = problem(hidden={"hard_iron": {"offset_nT": [30.0, -20.0, 25.0], "active_s": [201.0, 204.0]}})
    rows = BinnedRows.of(posed.state.time_s, posed.usable, posed.base, posed.target, posed.policy)
    span = Timeline.of(rows, np.zeros((len(rows.target), 3, 0))).best(iron_candidates()["hard_iron"][0].columns(posed))
    assert (span.from_s, span.to_s) == pytest.approx((201.0, 204.0), abs=0.2)


def test_coefficients_in_common_are_one_column_of_all_outputs() -> None:
    base = np.random.default_rng(0).normal(size=(400, 2, 3))
    rows = BinnedRows.of(np.arange(400.0), np.ones(400), base, base @ np.array([2.0, -1.0, 0.5]), STANDARD)
    timeline = Timeline.of(rows, np.zeros((400, 2, 0)))
    assert timeline.Q.shape == (800, 3)
    assert np.abs(timeline.residual).max() < 1e-9
