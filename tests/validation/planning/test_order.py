"""Orders of legs: as short as the shortest of all, where those can be tried."""

from __future__ import annotations

from itertools import pairwise, permutations

import numpy as np
import pytest

from scenarios.arrays import Array
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


@pytest.mark.parametrize("seed", range(12))
def test_no_stretch_can_be_turned_round_for_a_shorter_way(seed: int) -> None:
    """One way costs more than the other, as turns do that begin at another heading."""
    rng = np.random.default_rng(seed)
    costs = rng.uniform(1.0, 2.0, (10, 9))

    def length(order: list[int]) -> float:
        return float(sum(costs[b + 1, a] for b, a in pairwise((START, *order))))

    found = shortest(9, lambda a, b: float(costs[a + 1, b]))
    assert length(found) <= length(nearest_first(costs)) + 1e-9
    turned = [found[:i] + found[i:j][::-1] + found[j:] for i in range(9) for j in range(i + 2, 10)]
    assert length(found) <= min(map(length, turned)) + 1e-9


def nearest_first(costs: Array) -> list[int]:
    """Always on to the nearest of the places that are left; costs (n + 1, n), the start's first."""
    order: list[int] = []
    while len(order) < costs.shape[1]:
        row = np.array(costs[order[-1] + 1 if order else 0])
        row[order] = np.inf
        order.append(int(np.argmin(row)))
    return order


def test_two_places_are_begun_with_the_nearer_way() -> None:
    """The nearer place first, unless the way from there costs more: 1 + 9 against 3 + 2."""
    ways = {(START, 0): 1.0, (START, 1): 3.0, (0, 1): 9.0, (1, 0): 2.0}
    assert shortest(2, lambda a, b: ways[a, b]) == [1, 0]
    assert shortest(2, lambda a, b: {**ways, (0, 1): 3.0}[a, b]) == [0, 1]
