"""The model that is written where none was given, held against another recording of the same instrument."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.next_leg.legs import legs_of
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known, Level, ReferenceCorrection
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import lines_of_diff, patch_model, written_model
from diagnosis.repair.refinement import refine
from diagnosis.result import EvidenceKind, NamedEffect
from scenarios.nesting import parsed_toml
from scenarios.toml import as_dict
from sim.chain import apply_deterministic
from sim.effects import Effects, as_tables
from sim.effects.base import Effect
from sim.effects.dynamics import Latency
from sim.effects.earth import RegionalField
from sim.effects.electronics import Saturation
from sim.effects.iron import HardIron, HardIronDrift
from sim.effects.noise import WhiteNoise
from sim.effects.offsets import OffsetRandomWalk
from sim.effects.parameters import ACTIVE_WINDOW
from sim.scenario import Model, ModelSpec, Scenario, load, load_model
from tests.diagnosis.repair.test_repair import DRIVEN
from tests.diagnosis.synthetic import FIELD_ENU_NT, STRENGTH_NT, problem, recording, without_attitude

N = 3000
OFFSET_NT = [1200.0, 800.0, -2000.0]
IRON = {
    "soft_iron": {"matrix": [[0.3, 0.1, 0.0], [0.1, -0.2, 0.0], [0.0, 0.1, 0.2]]},
    "hard_iron": {"offset_nT": OFFSET_NT},
}
GAIN = (200.0, -100.0, 400.0)
FIRST, SECOND = (0.0, 100.0), (0.0, 300.0)
MADE = [
    DRIVEN(**{DRIVEN.linear[0]: GAIN}),
    DRIVEN(**{DRIVEN.linear[0]: GAIN, ACTIVE_WINDOW.name: FIRST}),
    HardIronDrift(rate_nT_h=(3000.0, -6000.0, 4000.0)),
    RegionalField(error_enu_nT=(300.0, -200.0, 100.0)),
    Latency(delay_s=0.1),
]


def _hidden(effect: Effect) -> dict[str, dict[str, object]]:
    values = {p.name: getattr(effect, p.name) for p in effect.parameters()}
    window = {} if effect.active_s is None else {ACTIVE_WINDOW.name: effect.active_s}
    return {effect.name: {name: value for name, value in values.items() if value is not None} | window}


def _posed(effect: Effect) -> LinearProblem:
    return replace(problem(recording(N, hidden=IRON | _hidden(effect))), iron_known=False)


@pytest.mark.parametrize("effect", MADE, ids=lambda one: f"{one.name} {one.active_s or ''}")
def test_a_model_without_one_given_predicts_another_recording(effect: Effect) -> None:
    """The iron is fitted beside the effect, which stands where the simulator has it."""
    posed = _posed(effect)
    (fine,), _ = refine(posed, [effect], np.ones(N, bool))
    chain = patch_model(ModelSpec(), [NamedEffect(fine, (), EvidenceKind.HELD_OUT, 100.0, 1.0)], posed).chain()
    other = problem(recording(2 * N, seed=1, hidden=IRON | _hidden(effect)))
    left_nT = other.recording.mag_nT - apply_deterministic(chain, other.state)[0]
    assert np.sqrt((left_nT**2).mean()) == pytest.approx(2.0, rel=0.05)


def test_without_attitude_the_iron_is_fitted_beside_the_effect() -> None:
    """Whose mean is no hard iron."""
    effect = DRIVEN(**{DRIVEN.linear[0]: GAIN})
    given = recording(N, hidden={"hard_iron": {"offset_nT": OFFSET_NT}} | _hidden(effect))
    posed = replace(problem(without_attitude(given)), iron_known=False)
    chain = patch_model(ModelSpec(), [NamedEffect(effect, (), EvidenceKind.HELD_OUT, 100.0, 1.0)], posed).chain()
    offset_nT = next(one for one in chain if one.name == "hard_iron").coefficients()
    assert offset_nT == pytest.approx(OFFSET_NT, abs=10.0)


SPREAD = {"uniform": [-100.0, 100.0]}
WALK = OffsetRandomWalk((2.0,) * 3)
IN_PART = HardIron((5.0, 3.0, 1.0), active_s=(1.0, 9.0))


def _patched(new: Effect, given: tuple[Effect, ...], model: Model | None = None, instead: bool = False) -> Model:
    done = (ReferenceCorrection("", "", np.array([1e3, 2e4, -4e4])),) if instead else ()
    posed = replace(problem(recording(300), given), corrections=done)
    return patch_model(model or ModelSpec(), [NamedEffect(new, (), EvidenceKind.HELD_OUT, 100.0, 1.0)], posed)


@pytest.mark.parametrize(
    ("new", "given", "made"),
    [
        (HardIron((5.0, 3.0, 1.0)), HardIron((100.0, 0.0, 0.0)), [HardIron((105.0, 3.0, 1.0))]),
        (IN_PART, HardIron((100.0, 0.0, 0.0)), [HardIron((100.0, 0.0, 0.0)), IN_PART]),
        (
            OffsetRandomWalk((1.0,) * 3),
            OffsetRandomWalk((2.0,) * 3),
            [OffsetRandomWalk((2.0,) * 3), OffsetRandomWalk((1.0,) * 3)],
        ),
        (WALK, WALK, [WALK, WALK]),
        (Saturation(1e6), Saturation(1e6), [Saturation(1e6), Saturation(1e6)]),
    ],
)
def test_two_of_a_name_are_one_where_they_only_add(new: Effect, given: Effect, made: list[Effect]) -> None:
    noise = WhiteNoise((1.0, 1.0, 1.0))
    assert [*_patched(new, (given, noise)).chain()] == [*made, noise]


def test_a_model_without_noise_gets_that_of_the_recording() -> None:
    (noise,) = (one for one in _patched(IN_PART, ()).chain() if isinstance(one, WhiteNoise))
    assert noise.std_nT == pytest.approx([2.0] * 3, rel=0.2)


def test_a_written_model_has_the_field_that_holds_and_a_motion_that_shows_the_effect() -> None:
    flown = load("auv-spiral")
    dated = ModelSpec.model_validate({"field": {"enu_nT": [1.0, 2e4, 3.0]}})
    for model, instead, east_nT in ((None, False, 1000.0), (dated, False, 1.0), (dated, True, 1e3), (flown, True, 1e3)):
        field = _patched(IN_PART, (), model, instead).field
        assert field is not None
        assert field.enu_nT is not None
        assert field.enu_nT[0] == east_nT
    assert _patched(IN_PART, (), flown).field == flown.field
    for effect, vehicle in ((IN_PART, "turntable"), (DRIVEN(**{DRIVEN.linear[0]: GAIN}), "auv")):
        assert {leg.scenario.vehicle.kind for leg in legs_of(_patched(effect, ()))} == {vehicle}


def test_a_file_of_a_log_without_a_vehicle_has_none_and_is_a_model_again(tmp_path: Path) -> None:
    """The delay of the attitude is kept, the vehicle of a stand-in is not."""
    file = tmp_path / "model.toml"
    late = replace(problem(recording(300)), attitude_delay_s=0.25)
    named = [NamedEffect(DRIVEN(**{DRIVEN.linear[0]: GAIN}), (), EvidenceKind.HELD_OUT, 100.0, 1.0)]
    made = patch_model(ModelSpec(), named, late)
    file.write_text(written_model(made))
    read = load_model(file)
    assert not {"vehicle", "phases"} & {*parsed_toml(file.read_text(), "", "")}
    assert (read.chain(), read.field, read.navigation.attitude_delay_s) == (made.chain(), made.field, 0.25)
    assert written_model(patch_model(load("quad-comb"), (), late)).count('kind = "quadrotor"') == 1


def test_without_a_heading_the_noise_is_that_of_the_strength() -> None:
    """The dip, an angle times the field, has also the noise of roll and pitch."""
    given = recording(300)
    level = Level.of(problem(given).state.R_wb, FIELD_ENU_NT, STANDARD)
    posed = pose(without_attitude(given), Known(FIELD_ENU_NT, STRENGTH_NT, level=level))
    named = [NamedEffect(IN_PART, (), EvidenceKind.HELD_OUT, 100.0, 1.0)]
    (noise,) = (
        one
        for one in patch_model(ModelSpec(), named, replace(posed, sigma_nT=np.array([2.0, 9.0]))).chain()
        if isinstance(one, WhiteNoise)
    )
    assert noise.std_nT == (2.0, 2.0, 2.0)


@pytest.mark.parametrize(
    ("of_all", "own"),
    [
        ({"kind": "rm3100"}, {}),
        (None, {"kind": "rm3100"}),
        (None, {"effects": {"scale": {"error": [0.1, 0.0, 0.0]}}}),
    ],
)
def test_what_a_scenario_says_of_its_sensors_is_in_the_written_chain_and_nowhere_else(of_all, own) -> None:  # type: ignore[no-untyped-def]
    """Their kinds, effects of their own, and what varies from run to run: this is one instrument."""
    table = as_dict(load("auv-spiral")) | {"sensors": [own, own], "vary": {"effects.hard_iron.offset_nT": SPREAD}}
    table |= {} if of_all is None else {"sensor": of_all}
    written = _patched(IN_PART, (WhiteNoise((1.0, 1.0, 1.0)),), Scenario.model_validate(table))
    read = Scenario.model_validate(as_dict(written))
    assert [one.name for k in (0, 1) for one in read.chain(k)] == ["hard_iron", "white_noise"] * 2
    assert not read.vary


def test_the_diff_has_field_and_effects_alone_and_short_numbers() -> None:
    tables, order = as_tables((HardIron(offset_nT=(5200.019526273762, -3097.3137692795945, 7404.954905968272)),))
    model = load("quad-comb").model_copy(update={"effects": Effects(tables), "effect_order": order})
    lines = lines_of_diff((), model)
    assert "+offset_nT = [5200, -3097.3, 7405]" in lines
    assert not any("vehicle" in line or "sampling" in line for line in lines)
    assert all(line[0] in "+-@ " for line in lines)


def test_equal_models_have_no_diff() -> None:
    tables, order = as_tables((HardIron(offset_nT=(10.0, 20.0, 30.0)),))
    model = load("quad-comb").model_copy(update={"effects": Effects(tables), "effect_order": order})
    assert lines_of_diff((HardIron(offset_nT=(10.0, 20.0, 30.0)),), model) == ()
