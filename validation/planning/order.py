"""Order of legs with the least turning time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from scenarios.arrays import Array

Cost = Callable[[int, int], float]
START = -1
"""First argument of the cost for the way from the start."""


def shortest(count: int, cost: Cost) -> list[int]:
    """Return a short order of places from the start: nearest neighbour, then 2-opt.

    cost(a, b) : cost from a to b, a = START for the way from the start
    """
    costs = np.array([[cost(a, b) if a != b else np.inf for b in range(count)] for a in range(START, count)])
    order = _nearest(costs, count)
    while (better := _turned_round(order, costs)) is not None:
        order = better
    return order


def _nearest(costs: Array, count: int) -> list[int]:
    order, left, here = [], set(range(count)), START
    while left:
        here = min(left, key=lambda place: (costs[here + 1, place], place))
        left.remove(here)
        order.append(here)
    return order


def _turned_round(order: list[int], costs: Array) -> list[int] | None:
    """Return the first shorter order with a reversed stretch, None without any."""
    now = _length(order, costs)
    for first in range(len(order) - 1):
        for last in range(first + 2, len(order) + 1):
            tried = order[:first] + order[first:last][::-1] + order[last:]
            if _length(tried, costs) < now - 1e-9:
                return tried
    return None


def _length(order: list[int], costs: Array) -> float:
    places = np.array(order)
    return float(costs[0, places[0]] + costs[places[:-1] + 1, places[1:]].sum())
