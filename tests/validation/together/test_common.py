"""What a lot makes of one course in every recording, and of iron that differs in each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.effects.iron import HardIronDrift
from sim.scenario import ModelSpec
from sim.state import TEMPERATURE
from tests.validation.diagnosis.synthetic import FIELD_ENU_NT, problem, recording
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.problem.pose import posed
from validation.diagnosis.result import How, Named, Reach
from validation.diagnosis.workflow import examined
from validation.together.coefficients import Estimate
from validation.together.common import Common, _ratios, _reach, changes_of_iron, of_one_course
from validation.together.reach import There

N = 2000
DRIFT = Named(HardIronDrift(rate_nT_h=(900.0, 200.0, 400.0)), (), How.HELD_OUT, 100.0, 1.0)
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
        ((RISES, RISES), (There.PRESENT, There.PRESENT), (TEMPERATURE,)),
        ((RISES, COMES_BACK), (There.PRESENT, There.PRESENT), ()),
        ((RISES, COMES_BACK), (There.PRESENT, There.ABSENT), (TEMPERATURE,)),
    ],
)
def test_a_channel_is_a_rival_where_it_goes_the_same_way_in_all_that_have_the_effect(problems, there, rivals) -> None:
    one = Common(DRIFT, (DRIFT, DRIFT), there, None, 0, None)
    assert of_one_course(one, problems).rivals == rivals


@pytest.mark.parametrize(("offsets_nT", "names"), [((2.0, 2.6), ["hard_iron"]), ((2.0, -2.0), [])])
def test_iron_that_differs_to_either_side_is_no_name(offsets_nT, names) -> None:
    """As the mean of a slow wander does."""
    hidden = [{"hard_iron": {"offset_nT": [by, 0.0, 0.0]}} for by in offsets_nT]
    problems = [posed(recording(N, seed=i, hidden=one), MODEL, None, None) for i, one in enumerate(hidden)]
    each = [examined(one, MODEL).belief.iron for one in problems]
    assert [[one.name for one in found] for found in each] == [["hard_iron"], ["hard_iron"]]
    assert [one.name for one in changes_of_iron(each, problems)] == names


@pytest.mark.parametrize(("along", "ratio"), [((13.0, 0.0), 1.3), ((5.0, 12.0), None), ((-10.0, 0.0), None)])
def test_a_size_is_held_against_the_others_where_its_course_is_theirs(along, ratio) -> None:
    first, second = (Estimate(np.diag([10.0, 10.0]), np.array(g)) for g in ((10.0, 0.0), along))
    found = _ratios([first, second])[1]
    assert (None if found is None else round(found[0], 9)) == ratio


@pytest.mark.parametrize(
    ("same", "each", "found"),
    [
        (True, ["a", "b"], Reach.TRANSFERRED),
        (True, ["a", None], Reach.SOME),
        (False, ["a", "b"], Reach.NOT_TRANSFERRED),
    ],
)
def test_what_some_show_reaches_as_far_as_it_is_the_same(same, each, found) -> None:
    assert _reach(same, each) is found
