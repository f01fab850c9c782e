"""A course that only rises in every recording of a lot is no name alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.effects.iron import HardIronDrift
from sim.state import TEMPERATURE
from tests.validation.diagnosis.synthetic import problem, recording
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.result import How, Named
from validation.together.common import Common, of_one_course
from validation.together.reach import There

N = 2000
DRIFT = Named(HardIronDrift(rate_nT_h=(900.0, 200.0, 400.0)), (), How.HELD_OUT, 100.0, 1.0)
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
