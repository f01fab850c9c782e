"""What of the iron is said to differ beside the effects that were found."""

from __future__ import annotations

import numpy as np

from tests.validation.diagnosis.synthetic import STRENGTH_NT, problem
from validation.diagnosis.decision.iron import iron_changes
from validation.diagnosis.decision.selection import select


def test_a_far_origin_of_a_gradient_is_no_change_of_the_iron() -> None:
    """An origin whose constant is 40 nT along the field: with the iron fitted that is a scale."""
    G = np.array([[0.4, -0.2, 0.1], [-0.2, 0.3, 0.5], [0.1, 0.5, -0.7]])
    along = problem().state.field_enu_nT / STRENGTH_NT
    origin = np.linalg.solve(G, 40.0 * along)
    found = select(problem(hidden={"field_gradient": {"gradient_nT_m": G.tolist(), "origin_enu_m": origin.tolist()}}))
    assert [one.name for one in found.found] == ["field_gradient"]
    assert iron_changes(found) == ()


def test_a_scale_that_differs_is_a_change_of_the_iron() -> None:
    found = select(problem(hidden={"scale": {"error": [1e-3, -1e-3, 5e-4]}}))
    assert found.found == ()
    assert [one.name for one in iron_changes(found)] == ["scale"]
