"""Orders of legs: as short as the shortest of all, where those can be tried."""

from __future__ import annotations

from itertools import pairwise, permutations

import numpy as np
import pytest

from validation.planning.order import START, shortest


@pytest.mark.parametrize("seed", range(6))
def test_near_the_shortest_of_all(seed: int) -> None:
    places = np.random.default_rng(seed).uniform(size=(7, 2))

    def cost(a: int, b: int) -> float:
        return float(np.linalg.norm(places[b] - (np.zeros(2) if a == START else places[a])))

    def length(order: tuple[int, ...]) -> float:
        return sum(cost(a, b) for a, b in pairwise((START, *order)))

    found = shortest(len(places), cost)
    assert sorted(found) == list(range(7))
    assert length(tuple(found)) <= 1.1 * min(length(order) for order in permutations(range(7)))


def test_one_place() -> None:
    assert shortest(1, lambda a, b: 1.0) == [0]
