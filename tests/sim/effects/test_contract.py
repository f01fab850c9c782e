"""What every effect must hold to; a line in EFFECTS brings an effect all of these tests."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, fields, replace
from itertools import pairwise

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.chain import Chain
from sim.effects import BY_NAME, EFFECTS, build
from sim.effects.noise import WhiteNoise
from sim.effects.tables import table

every = pytest.mark.parametrize("cls", EFFECTS, ids=lambda cls: cls.name)


def run(effect, state):
    return effect.apply(state, state.field_nT, np.random.default_rng(5), {})


def test_names_are_told_apart():
    assert len(BY_NAME) == len(EFFECTS)


def test_stages_follow_the_path_of_the_signal():
    order = ("field", "vehicle", "sensor", "electronics")
    places = [order.index(cls.stage) for cls in EFFECTS]
    assert places == sorted(places)


@every
def test_a_default_effect_contributes_nothing(cls, states):
    assert not run(cls(), states(300)).any()


@every
def test_an_active_effect_contributes(cls, states, active):
    state = replace(states(2000), attitude="navigation")
    label = run(cls(**active[cls.name]), state)
    assert label.shape == (2000, 3)
    assert label.dtype == np.float64
    assert np.isfinite(label).all()
    assert np.abs(label).max() > 1e-3


@every
def test_cutting_a_run_into_blocks_changes_nothing(cls, states, cut, active):
    state = states(1500)
    effects = build({cls.name: active[cls.name]}, None, "")
    whole, labels = Chain(effects, seed=3).apply(state)
    rng = np.random.default_rng(11)
    for _ in range(4):
        edges = [0, *np.sort(rng.choice(np.arange(1, 1500), 7, replace=False)), 1500]
        edges.insert(1, 1)
        chain = Chain(effects, seed=3)
        parts = [chain.apply(cut(state, a, b)) for a, b in pairwise(edges) if b > a]
        np.testing.assert_allclose(np.concatenate([p[0] for p in parts]), whole, rtol=0, atol=1e-9)
        label = np.concatenate([p[1][cls.name] for p in parts])
        np.testing.assert_allclose(label, labels[cls.name], rtol=0, atol=1e-9)


@every
def test_the_same_seed_gives_the_same_bytes_and_another_seed_other_noise(cls, states, active):
    state = states(800)
    effects = build({cls.name: active[cls.name]}, None, "")
    first, again, other = (Chain(effects, seed=seed).apply(state)[0] for seed in (3, 3, 4))
    assert first.tobytes() == again.tobytes()
    assert (first.tobytes() != other.tobytes()) == cls.stochastic


@every
def test_inputs_are_left_alone(cls, states, active):
    state = states(500)
    signal = state.field_nT + 1.0

    def parts():
        return {f.name: getattr(state, f.name) for f in fields(state) if f.name != "channels"} | state.channels

    before = {name: np.copy(value) for name, value in parts().items()}
    kept = signal.copy()
    cls(**active[cls.name]).apply(state, signal, np.random.default_rng(0), {})
    assert (signal == kept).all()
    for name, value in parts().items():
        assert np.array_equal(value, before[name])


@every
def test_basis_times_coefficients_is_the_contribution(cls, states, active):
    state = states(700)
    effect = cls(**active[cls.name])
    other = {p.name: getattr(effect, p.name) for p in cls.parameters() if p.name not in cls.linear}
    basis = cls.basis(state, state.field_nT, **other)
    assert basis.shape == (700, 3, len(effect.coefficients()))
    assert (basis.shape[2] > 0) == bool(cls.linear)
    if cls.linear:
        label = run(effect, state)
        np.testing.assert_allclose(basis @ effect.coefficients(), label, rtol=0, atol=1e-9 * np.abs(label).max())
        again = cls.combine(effect.coefficients(), **other)
        np.testing.assert_allclose(again.coefficients(), effect.coefficients(), rtol=1e-12)


@every
def test_parameters_say_unit_bounds_and_meaning(cls):
    for p in cls.parameters():
        assert p.doc
        assert p.worded or p.low < p.high
        assert getattr(cls(**{p.name: p.default}), p.name) == p.default
        for unit in ("nT", "deg", "_hz", "_s"):
            assert not p.name.endswith(unit) or p.unit


@every
def test_docstring_states_the_effect_and_its_formula(cls):
    assert cls.__doc__ is not None
    assert cls.__doc__.split("``")[0].strip()
    assert cls.__doc__.count("``") >= 2


@every
def test_table_and_build_are_inverse(cls, active):
    (effect,) = build({cls.name: active[cls.name]}, None, "")
    (again,) = build({cls.name: table(effect)}, None, "")
    assert again == effect
    assert hash(again) == hash(effect)


@every
def test_an_effect_is_frozen(cls):
    effect = cls()
    with pytest.raises(FrozenInstanceError):
        setattr(effect, cls.parameters()[0].name, 0)


@every
def test_values_out_of_bounds_are_refused(cls):
    for p in cls.parameters():
        out = np.broadcast_to(p.high * 1.01 + 1.0, p.shape).tolist()
        wrong = "nonsense" if p.options else out
        with pytest.raises(InputError, match=p.name):
            build({cls.name: {p.name: wrong}}, None, "file.toml")
        if not p.worded:
            with pytest.raises(InputError, match="finite"):
                build({cls.name: {p.name: np.full(p.shape, np.nan).tolist()}}, None, "file.toml")


AFTER_NOISE = EFFECTS[EFFECTS.index(WhiteNoise) + 1 :]


@pytest.mark.parametrize("cls", AFTER_NOISE, ids=lambda cls: cls.name)
def test_only_an_effect_with_memory_lets_neighbouring_samples_share_their_noise(cls, states, active):
    state, effect = states(4000), cls(**active[cls.name])
    noise = np.random.default_rng(2).normal(scale=200.0, size=state.field_nT.shape)
    quiet, loud = (
        signal + effect.apply(state, signal, np.random.default_rng(5), {})
        for signal in (state.field_nT, state.field_nT + noise)
    )
    left = loud - quiet
    together = np.median(left[1:] * left[:-1]) / np.median(left**2)  # medians: some rows may be held or clipped
    assert (together > 0.1) == cls.traits.correlates_noise


@every
def test_a_fuller_form_has_a_name_and_comes_after_what_the_effect_always_has(cls):
    forms = [p.form for p in cls.parameters() if p.role == "linear"]
    assert forms == sorted(forms, key=bool)
    for form, several in cls.forms.items():
        assert any(p.role in ("linear", "listed", "sweep") for p in several), form
        plain = cls(**{k: v for k, v in cls.example.items() if k not in {p.name for p in several}})
        assert form not in plain.forms_in_use
