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
    CommonEffect,
    _ratios,
    _transfer_of,
    common_fitted_effect,
    common_iron_changes,
    common_value_effects,
    single_effect,
    with_common_rivals,
)
from diagnosis.several.transfer import Presence
from diagnosis.workflow import examine
from recordings.channels import TEMPERATURE
from sim.effects import EFFECTS
from sim.effects.iron import HardIron, HardIronDrift
from sim.effects.noise import WhiteNoise
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, problem, recording

N = 2000
DRIFT = NamedEffect(HardIronDrift(rate_nT_h=(900.0, 200.0, 400.0)), (), EvidenceKind.HELD_OUT, 100.0, 1.0)
MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [2.0] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)
UP = np.linspace(0.0, 1.0, N)


def flown(temperature_degC: np.ndarray) -> LinearProblem:
    return problem(replace(recording(N), temperature_degC=temperature_degC))


RISES, COMES_BACK = flown(15 + 5 * np.sqrt(UP)), flown(15 + 5 * np.sin(7 * UP))


@pytest.mark.parametrize(
    ("problems", "there", "rivals"),
    [
        ((RISES, RISES), (Presence.PRESENT, Presence.PRESENT), (TEMPERATURE,)),
        ((RISES, COMES_BACK), (Presence.PRESENT, Presence.PRESENT), ()),
        ((RISES, COMES_BACK), (Presence.PRESENT, Presence.ABSENT), (TEMPERATURE,)),
    ],
)
def test_a_channel_is_a_rival_where_it_goes_the_same_way_in_all_that_have_the_effect(problems, there, rivals) -> None:
    one = CommonEffect(DRIFT, (DRIFT, DRIFT), there, None, 0, None)
    assert with_common_rivals(one, problems).rivals == rivals


@pytest.mark.parametrize(("offsets_nT", "names"), [((2.0, 2.6), ["hard_iron"]), ((2.0, -2.0), [])])
def test_iron_that_differs_to_either_side_is_no_name(offsets_nT, names) -> None:
    """As the mean of a slow wander does."""
    hidden = [{"hard_iron": {"offset_nT": [by, 0.0, 0.0]}} for by in offsets_nT]
    problems = [pose_model(recording(N, seed=i, hidden=one), MODEL, None, None) for i, one in enumerate(hidden)]
    each = [examine(one, MODEL).conclusion.iron for one in problems]
    assert [[one.name for one in found] for found in each] == [["hard_iron"], ["hard_iron"]]
    assert [one.name for one in common_iron_changes(each, problems)] == names


@pytest.mark.parametrize(
    ("along", "ratio"),
    [((13.0, 0.0), 1.3), ((7.5, 6.6), 0.75), ((6.5, 7.6), None), ((5.0, 12.0), None), ((-10.0, 0.0), None)],
)
def test_a_size_is_held_against_the_others_where_its_course_is_theirs(along, ratio) -> None:
    first, second = (CoefficientEstimate(np.diag([10.0, 10.0]), np.array(g)) for g in ((10.0, 0.0), along))
    """More than half of what it explains goes along the others' coefficients."""
    assert _ratios([None, first, None]) == (None, None, None)
    assert len(_ratios([first, None, second])) == 3
    found = _ratios([first, second])[1]
    assert (None if found is None else round(found[0], 9)) == ratio


@pytest.mark.parametrize(
    ("same", "each", "found"),
    [
        (True, ["a", "b"], Transfer.TRANSFERRED),
        (True, ["a", None], Transfer.SOME),
        (False, ["a", "b"], Transfer.NOT_TRANSFERRED),
    ],
)
def test_what_some_show_reaches_as_far_as_it_is_the_same(same, each, found) -> None:
    assert _transfer_of(same, each) is found


def test_an_effect_of_a_lot_says_what_each_recording_does_and_which_channels_go_with_it() -> None:
    """Nats over their inflation; nothing of a recording that has not been asked, or says nothing of it."""
    own = CoefficientEstimate(np.eye(3), np.array([900.0, 200.0, 400.0]))
    in_recording = SimpleNamespace(held_out_gain=60.0, inflation=2.0, strength=0.5)
    pooled = SimpleNamespace(
        candidate=Candidate(HardIronDrift),
        in_recordings=(in_recording, in_recording, None, in_recording),
        estimates=(own, own, own, None),
    )
    there = (Presence.PRESENT, Presence.PRESENT, Presence.NOT_RECORDED, Presence.UNDECIDED)
    finding = SimpleNamespace(
        pooled=pooled, agreement=agreement([own, own], 0.0), nats=90.0, transfer=Transfer.SOME, presence=there
    )
    chosen: Any = SimpleNamespace(finding=finding, alternatives=(), strength=0.5)
    one = common_fitted_effect(chosen, (RISES, RISES, COMES_BACK, COMES_BACK))
    assert [None if each is None else each.nats for each in one.each] == [30.0, 30.0, None, None]
    assert one.named.rivals == (TEMPERATURE,)


def _iron(x_nT: float, *, V: float = 1.0, alternatives: tuple[str, ...] = ()) -> Any:
    """A hard iron of so much, known to 0.1 nT if what is left is white."""
    fit = SimpleNamespace(covariance=0.01 * np.eye(5))
    evidence = SimpleNamespace(
        candidate=Candidate(HardIron), width=3, fit=fit, V=V, coefficients=np.array([x_nT, 0.0, 0.0]), nats=x_nT,
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
    assert all((one.chi2, one.degrees, one.p, one.ratios) == (None, 0, None, ()) for one in found)


def test_what_one_recording_names_is_a_single_run_s_however_its_coefficients_agree() -> None:
    own = CoefficientEstimate(np.eye(3), np.array([900.0, 200.0, 400.0]))
    in_recording = SimpleNamespace(held_out_gain=60.0, inflation=2.0, strength=0.5)
    pooled = SimpleNamespace(
        candidate=Candidate(HardIronDrift), in_recordings=(None, in_recording), estimates=(None, own)
    )
    there = (Presence.NOT_RECORDED, Presence.PRESENT)
    finding: Any = SimpleNamespace(
        pooled=pooled, agreement=agreement([own], 0.0), nats=90.0, transfer=None, presence=there
    )
    one = single_effect(finding, (COMES_BACK, RISES))
    assert (one.name, one.transfer, one.several) == ("hard_iron_drift", Transfer.SINGLE_RUN, False)
    assert (one.named.strength, one.named.nats, one.presence) == (0.0, 90.0, there)
    assert (one.chi2, one.degrees, one.p) == (0.0, 0, 1.0)
    assert one.named.effect == DRIFT.effect
    shown = common_fitted_effect(
        SimpleNamespace(
            finding=SimpleNamespace(**vars(finding) | {"transfer": Transfer.SOME}),
            alternatives=("scale",),
            strength=0.5,
        ),  # type: ignore[arg-type]
        (COMES_BACK, RISES),
    )
    assert shown.several
    assert (shown.named.alternatives, shown.named.strength) == (("scale",), 0.5)


@pytest.mark.parametrize(("more", "count"), [(-0.5, 0), (0.5, 1)])
def test_iron_is_told_where_each_foretells_the_other_beyond_a_thousandth(more: float, count: int) -> None:
    """Over all names: ``x^2`` hundred nats of two, each known to a tenth of a nT."""
    x_nT = float(np.sqrt((np.log(len(EFFECTS) / 0.001) + more) / 100))
    assert len(common_iron_changes([[_iron(x_nT)], [_iron(x_nT)]], [RISES, RISES])) == count
