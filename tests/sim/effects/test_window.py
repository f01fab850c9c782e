"""An effect that acts in a part of the run: its label is that of the whole run inside, and zero outside."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.chain import Chain
from sim.effects import EFFECTS, as_tables, build

SWITCHED = [cls for cls in EFFECTS if not cls.traits.whole_run]
every = pytest.mark.parametrize("cls", SWITCHED, ids=lambda cls: cls.name)


@every
def test_the_label_is_the_whole_runs_inside_and_zero_outside(cls, states, active):
    state = states(1500)
    low, high = float(state.time_s[400]), float(state.time_s[900])
    whole, part = (
        Chain(build({cls.name: {**active[cls.name], **window}}, None, ""), seed=3).apply(state)[1][cls.name]
        for window in ({}, {"active_s": [low, high]})
    )
    expected = np.where(((state.time_s >= low) & (state.time_s < high))[:, None], whole, 0.0)
    np.testing.assert_allclose(part, expected, rtol=0, atol=1e-9)


def test_labels_add_up_and_blocks_change_nothing(states, cut, active):
    state = states(1500)
    window = {"active_s": [float(state.time_s[300]), float(state.time_s[1100])]}
    effects = build({cls.name: {**active[cls.name], **window} for cls in SWITCHED}, None, "")
    mag_nT, labels = Chain(effects, seed=3).apply(state)
    assert np.abs(state.field_nT + sum(labels.values()) - mag_nT).max() < 1e-9
    chain = Chain(effects, seed=3)
    parts = [chain.apply(cut(state, a, b))[0] for a, b in pairwise([0, 299, 300, 700, 1200, 1500])]
    np.testing.assert_allclose(np.concatenate(parts), mag_nT, rtol=0, atol=1e-9)


def test_a_basis_has_the_window_and_tables_keep_it(states, active):
    state = states(700)
    window = (float(state.time_s[100]), float(state.time_s[200]))
    for cls in (one for one in SWITCHED if one.linear):
        (effect,) = build({cls.name: {**active[cls.name], "active_s": list(window)}}, None, "")
        other = {p.name: getattr(effect, p.name) for p in cls.parameters() if p.name not in cls.linear}
        basis = effect.basis(state, state.field_nT, active_s=window, **other)
        assert basis[100:200].any()
        assert not basis[200:].any()
        tables, order = as_tables([effect])
        assert build(tables, order) == (effect,)
        assert effect.active_s == window


@pytest.mark.parametrize(
    ("window", "message"),
    [
        ([9, 3], "active_s must end after it begins, found [9.0, 3.0]"),
        ([1], "active_s: expected two numbers, found [1]"),
        ([-1, 3], "active_s: -1 is outside 0 to"),
    ],
)
def test_a_wrong_window_is_told_in_one_line(window, message):
    with pytest.raises(InputError) as caught:
        build({"hard_iron": {"offset_nT": [1, 2, 3], "active_s": window}}, None, "a.toml")
    assert message in str(caught.value)


def test_what_lasts_has_no_window(active):
    for cls in (one for one in EFFECTS if one.traits.whole_run):
        with pytest.raises(InputError, match="a course of the whole run"):
            cls(**active[cls.name], active_s=(1.0, 2.0))
