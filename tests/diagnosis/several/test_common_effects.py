"""What a lot makes of one course in every recording, and of iron that differs in each."""

from __future__ import annotations

import itertools
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import EvidenceKind, NamedEffect, Transfer
from diagnosis.several.coefficients import CoefficientEstimate, agreement
from diagnosis.several.common_effects import (
    common_effect,
    common_iron_changes,
    common_value_effects,
    parameters_of,
)
from diagnosis.several.pooled_effect import PooledEffect, Presence
from diagnosis.workflow import examine
from recordings.channels import TEMPERATURE
from sim.effects import EFFECTS
from sim.effects.currents import MotorCurrent
from sim.effects.iron import HardIron, HardIronDrift, SoftIron
from sim.effects.noise import WhiteNoise
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import COSTLY, FIELD_ENU_NT, problem, recording

N = 2000
DRIFT = HardIronDrift(rate_nT_h=(900.0, 200.0, 400.0))
MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [2.0] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)
UP = np.linspace(0.0, 1.0, N)


def flown(temperature_degC: np.ndarray) -> LinearProblem:
    return problem(replace(recording(N), temperature_degC=temperature_degC))


RISES, COMES_BACK = flown(15 + 5 * np.sqrt(UP)), flown(15 + 5 * np.sin(7 * UP))


@pytest.mark.parametrize(("offsets_nT", "names"), [((2.0, 2.6), ["hard_iron"]), ((2.0, -2.0), [])])
def test_iron_that_differs_to_either_side_is_no_name(offsets_nT, names) -> None:
    """As the mean of a slow wander does."""
    hidden = [{"hard_iron": {"offset_nT": [by, 0.0, 0.0]}} for by in offsets_nT]
    problems = [pose_model(recording(N, seed=i, hidden=one), MODEL, None, None) for i, one in enumerate(hidden)]
    each = [examine(one, MODEL, COSTLY).selection.iron for one in problems]
    assert [[one.name for one in found] for found in each] == [["hard_iron"], ["hard_iron"]]
    assert [one.name for one in common_iron_changes(each, problems)] == names


OWN = CoefficientEstimate(np.eye(3), np.array([900.0, 200.0, 400.0]))
"""A recording's own coefficients: those of the drift."""


def shown(transfer: Transfer | None, *asked: bool, alternatives: tuple[str, ...] = ()) -> PooledEffect:
    """The drift in the recordings that were asked, with 60 nats over an inflation of two in each."""
    parts = [CoefficientEstimate(OWN.N / 2, OWN.g / 2)] * 2
    in_recording: Any = SimpleNamespace(
        parts=parts,
        held_out_gain=60.0,
        inflation=2.0,
        strength=0.5,
        baseline=SimpleNamespace(rows=SimpleNamespace(policy=STANDARD)),
    )
    here = {i: in_recording for i, there in enumerate(asked) if there}
    agree = agreement([OWN] * len(here), 0.0)
    return PooledEffect(Candidate(HardIronDrift), here, 0.0, transfer, [90.0], agree, alternatives)


@pytest.mark.parametrize(
    ("problems", "asked", "rivals"),
    [
        ((RISES, RISES), (True, True), (TEMPERATURE,)),
        ((RISES, COMES_BACK), (True, True), ()),
        ((RISES, COMES_BACK), (True, False), (TEMPERATURE,)),
    ],
)
def test_a_channel_is_a_rival_where_it_goes_the_same_way_in_all_that_have_the_effect(problems, asked, rivals) -> None:
    assert common_effect(shown(Transfer.SOME, *asked), problems).named.rivals == rivals


def test_an_effect_of_a_lot_says_what_each_recording_does() -> None:
    """Nats over their inflation; nothing of a recording that has not been asked."""
    one = common_effect(shown(Transfer.SOME, True, True, False), (RISES, RISES, COMES_BACK))
    assert [None if each is None else each.nats for each in one.each] == [30.0, 30.0, None]
    assert one.named.effect == DRIFT
    assert one.presence == (Presence.PRESENT, Presence.PRESENT, Presence.NOT_RECORDED)
    ratio = pytest.approx((1.0, 2**0.5 * 1e-3), rel=0.1)
    assert one.ratios == (ratio, ratio, None)


def test_what_one_recording_names_is_a_single_run_s_however_its_coefficients_agree() -> None:
    one = common_effect(shown(None, False, True), (COMES_BACK, RISES))
    assert (one.name, one.transfer) == ("hard_iron_drift", Transfer.SINGLE_RUN)
    assert (one.named.strength, one.named.nats) == (0.5, 90.0)
    assert one.presence == (Presence.NOT_RECORDED, Presence.PRESENT)
    assert one.agreement is not None
    assert (one.agreement.chi2, one.agreement.degrees, one.agreement.p) == (pytest.approx(0.0), 0, 1.0)
    some = common_effect(shown(Transfer.SOME, False, True, alternatives=("scale",)), (COMES_BACK, RISES))
    assert (some.named.alternatives, some.named.strength) == (("scale",), 0.5)


def _iron(x_nT: float, *, V: float = 1.0, alternatives: tuple[str, ...] = ()) -> Any:
    """A hard iron of so much, known to 0.1 nT if what is left is white."""
    c, covariance = np.array([x_nT, 0.0, 0.0]), 0.01 * np.eye(3)
    evidence = SimpleNamespace(
        candidate=Candidate(HardIron), width=3, covariance=covariance, V=V, coefficients=c, nats=x_nT,
        strength=1.0,
    )  # fmt: skip
    return SimpleNamespace(name="hard_iron", evidence=evidence, alternatives=alternatives)


@pytest.mark.parametrize(
    ("several", "transfer"),
    [
        ([[_iron(20.0)], [_iron(20.6)]], Transfer.TRANSFERRED),
        ([[_iron(20.0)], [_iron(26.0)]], Transfer.NOT_TRANSFERRED),
        ([[_iron(20.0, V=1e3)], [_iron(26.0, V=1e3)]], Transfer.TRANSFERRED),
        ([[_iron(20.0)], [_iron(20.6)], []], Transfer.SOME),
        ([[_iron(20.0)], []], None),
    ],
)
def test_iron_is_the_same_within_its_error_beside_what_is_left(several, transfer) -> None:
    """In two recordings at least; 0.6 nT are an error of form, 6 nT are not unless a wander makes them."""
    found = common_iron_changes(several, [RISES] * len(several))
    assert [one.transfer for one in found] == ([] if transfer is None else [transfer])
    changes = list(itertools.chain.from_iterable(several))
    assert all(one.named.nats == sum(iron.evidence.nats for iron in changes) for one in found)
    assert all(one.named.strength == 1.0 for one in found)
    sizes = [[np.linalg.norm(own.effect.offset_nT) for own in one.each if own] for one in found]  # type: ignore[attr-defined]
    assert sizes == [pytest.approx([iron.evidence.coefficients[0] for iron in changes])] * len(found)


def test_iron_is_mistaken_for_what_it_is_in_every_recording() -> None:
    first, second = _iron(20.0, alternatives=("sensor_offset", "scale")), _iron(20.0, alternatives=("sensor_offset",))
    (one,) = common_iron_changes([[first], [second]], [RISES, RISES])
    assert one.named.alternatives == ("sensor_offset",)


@pytest.mark.parametrize(
    ("stds_nT", "transfer"),
    [
        ((1.4, 1.0, 1.2), Transfer.TRANSFERRED),
        ((1.6, 1.0, 1.2), Transfer.NOT_TRANSFERRED),
        ((1.0, None, 1.2, 1.4), Transfer.SOME),
        ((1.2, 1.0), Transfer.TRANSFERRED),
        ((1.0, None), None),
    ],
)
def test_noise_is_the_same_where_its_sizes_are_alike(stds_nT, transfer) -> None:
    """Within half; it is told by the middle one of two recordings at least."""
    several = [
        [] if std is None else [NamedEffect(WhiteNoise(std_nT=(std,) * 3), (), EvidenceKind.SPECTRUM, None, 1.0)]
        for std in stds_nT
    ]
    found = common_value_effects(several, STANDARD)
    assert [one.transfer for one in found] == ([] if transfer is None else [transfer])
    assert all(one.named.effect == WhiteNoise(std_nT=(1.2,) * 3) for one in found)
    assert all((one.agreement, one.ratios) == (None, ()) for one in found)


SLOW = next(effect for effect in EFFECTS if effect.traits.spectrum is not None)


@pytest.mark.parametrize(("sizes", "count"), [((1.2, 1.0), 1), ((1.6, 1.0), 0), ((1.2, None, 1.0), 0)])
def test_slow_noise_of_another_size_comes_from_outside_the_sensor(sizes, count) -> None:
    """As a pump's field does, which looks like a wander of another size in each recording, or not in all."""
    level = SLOW.with_role("level")
    made = [None if size is None else SLOW(**SLOW.example | {level: (size,) * 3}) for size in sizes]
    several = [[] if one is None else [NamedEffect(one, (), EvidenceKind.SPECTRUM, 50.0, 1.0)] for one in made]
    assert len(common_value_effects(several, STANDARD)) == count


@pytest.mark.parametrize(("more", "count"), [(-0.5, 0), (0.5, 1)])
def test_iron_is_told_where_each_foretells_the_other_beyond_a_thousandth(more: float, count: int) -> None:
    """Over all names: ``x^2`` hundred nats of two, each known to a tenth of a nT."""
    x_nT = float(np.sqrt((np.log(len(EFFECTS) / 0.001) + more) / 100))
    assert len(common_iron_changes([[_iron(x_nT)], [_iron(x_nT)]], [RISES, RISES])) == count


COVARIANCE = np.array([[0.04, 0.01, 0.0], [0.01, 0.09, 0.0], [0.0, 0.0, 0.16]])


def test_the_errors_of_a_linear_effect_are_those_of_its_coefficients() -> None:
    c = np.array([3.0, -2.0, 4.0])
    effect, spread = parameters_of(Candidate(MotorCurrent), c, COVARIANCE, problem(n=300))
    assert isinstance(effect, MotorCurrent)
    assert effect.gain_nT_A == pytest.approx(tuple(c))
    assert spread["gain_nT_A"] == pytest.approx([0.2, 0.3, 0.4], rel=1e-6)
    certain = parameters_of(Candidate(MotorCurrent), c, np.diag([0.04, 0.0, 0.16]), problem(n=300))[1]
    assert certain["gain_nT_A"] == pytest.approx([0.2, 0.0, 0.4], rel=1e-6)


def test_errors_go_with_the_slopes_of_many_parameters() -> None:
    """Against the spread of parameters of drawn coefficients."""
    rng = np.random.default_rng(2)
    candidate, here = Candidate(SoftIron), problem(n=300)
    k = candidate.columns(here).shape[2]
    c, root = rng.normal(0.0, 0.05, k), rng.normal(0.0, 0.002, (k, k))
    _, spread = parameters_of(candidate, c, root @ root.T, here)
    drawn = [candidate.to_effect(c + root @ rng.normal(size=k)) for _ in range(2000)]
    for name, std in spread.items():
        seen = np.std([np.asarray(getattr(one, name)) for one in drawn], axis=0)
        np.testing.assert_allclose(std, seen, rtol=0.1, atol=1e-9)


LISTED = [one for one in EFFECTS if one.name in ("latency", "bandwidth")]


@pytest.mark.parametrize("kind", LISTED, ids=lambda kind: kind.name)
def test_a_listed_value_is_moved_by_the_power_that_its_column_goes_with(kind) -> None:  # type: ignore[no-untyped-def]
    """A column of twice the listed value, as far as its size is a power of it, has the coefficient of that size."""
    here = problem(n=600)
    name = next(p.name for p in kind.parameters() if p.name in dict(Candidate.of(kind(**kind.example)).nonlinear))
    value = float(kind.example[name])
    candidate = Candidate(kind, ((name, value),))
    sizes = [np.linalg.norm(candidate.at({name: by * value}).columns(here)) for by in (1.0, 1.05)]
    effect, spread = parameters_of(candidate, np.array([sizes[1] / sizes[0]]), np.array([[0.01]]), here)
    assert getattr(effect, name) == pytest.approx(1.05 * value, rel=5e-3)
    power = np.log(sizes[1] / sizes[0]) / np.log(1.05)
    assert float(spread[name]) == pytest.approx(abs(1.05 * value * 0.1 / (sizes[1] / sizes[0] * power)), rel=0.05)
    vanishing, _ = parameters_of(candidate, np.array([-1.0]), np.array([[0.01]]), here)
    low, high = next((p.low, p.high) for p in kind.parameters() if p.name == name)
    assert low <= getattr(vanishing, name) <= high
