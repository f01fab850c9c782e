"""The indices that differential evolution draws."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from calib.search.differential import another


@pytest.mark.parametrize("taken", list(permutations(range(4)))[::5])
def test_another_individual_is_none_of_those_taken(taken: tuple[int, int, int, int]) -> None:
    rng = np.random.default_rng(0)
    assert {another(6, taken, rng) for _ in range(200)} == {4, 5}
