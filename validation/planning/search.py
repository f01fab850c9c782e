"""Search for the best manoeuvre for a time, or the shortest for a target."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from scenarios.paths import PhaseBase
from validation.bound.limit import optimal
from validation.planning.allocation import LegInformation, whole
from validation.planning.manoeuvre import Leg
from validation.planning.order import START, shortest
from validation.planning.refinement import refined
from validation.planning.task import PlanningTask

FEW = (4, 6, 9, 12, 16, 20, 24, 32)
"""Tried numbers of legs: sixteen are usually as good as the optimum, fewer leave more time for holds."""
FEWER = (1, 2, 4, 6, 9, 12, 20)
"""Tried numbers of legs after a recording."""
NARROWER = (1.0, 0.6, 0.35)
"""Shares of the tilts within which routes are searched: for short times narrow tilts may be better."""
REFINED = 3
"""Routes to refine: the best for several numbers of legs."""
ENOUGH = 1.1
"""Ratio to the error of the optimal design below which a route is not refined."""
NEAR = 1.2
"""Ratio to the tilts' limit below which no other variant of the manoeuvre is tried."""
SAME_DEG = 0.5
"""Angle between consecutive attitudes below which they are one leg."""
KEPT = 0.6
"""Share of the candidates kept at each thinning."""
RARE = 1e-6
"""Weight over the largest below which a candidate is dropped."""
SHORT = 0.5
"""Seconds below which a hold is dropped; a person's hold and a push are always longer."""
THINNED = 1.002
"""Factor by which the error may grow through dropped holds."""
CLOSE_S = 1.0
"""Accuracy of the shortest time in s."""


@dataclass(frozen=True, eq=False)
class Route:
    """Ordered legs with information, and the duration of a flight with least amounts."""

    task: PlanningTask
    angles_deg: Array
    legs: LegInformation
    moving_s: float

    def best(self, time_s: float) -> LegSelection:
        """Return the best amounts for a total time."""
        amounts, square = self.legs.best(time_s - self.moving_s)
        if self.task.manoeuvre.whole and np.isfinite(square):
            amounts = whole(amounts, (time_s - self.moving_s) / self.legs.unit_s)
            square = self.legs.mean_square(amounts)
        legs = [Leg.at(angles, float(amount)) for angles, amount in zip(self.angles_deg, amounts, strict=True)]
        return LegSelection(self.task, tuple(legs), time_s, float(np.sqrt(square)))


@dataclass(frozen=True, eq=False)
class LegSelection:
    """Selected legs, the time available, and the predicted error of the goal."""

    task: PlanningTask
    legs: tuple[Leg, ...]
    time_s: float
    error: float

    @property
    def filled(self) -> LegSelection:
        """Return the selection stretched to fill the time, if better."""
        task = self.task.flown_by(self.task.manoeuvre.filling(self.legs, self.time_s))
        error = task.error_with(task.phase_information(task.manoeuvre.phase(self.legs)))
        return LegSelection(task, self.legs, self.time_s, error) if error < self.error else self

    @property
    def phase(self) -> PhaseBase:
        """Return the phase with the legs."""
        return self.task.manoeuvre.phase(self.legs)

    @property
    def information(self) -> Array:
        """Return the information (k, k) of the flight alone."""
        return self.task.phase_information(self.phase)


class RouteSearch:
    """Routes through few attitudes of the optimal design, each usable for any time.

    Routes without legs of negligible time are added during the search.
    """

    def __init__(self, task: PlanningTask, time_s: float, counts: Sequence[int] | None = None) -> None:
        """Collect routes; time_s : flight time, compared with information from before the flight.

        counts : tried numbers of legs, FEW without one, after a recording FEWER.
        """
        self.task = task
        narrower = NARROWER if task.step_deg is None and task.before is None else NARROWER[:1]
        rows = [_within(task, time_s, share) for share in narrower]
        self.routes = [route for angles, leg_rows in rows for route in _routes(task, angles, leg_rows, counts)]
        self.least_in_a_second = np.sqrt(time_s) * _design_error(task, rows[0][1])

    def improve(self, time_s: float) -> None:
        """Add refined versions of the best routes for a time, unless a route is near the optimum."""
        found = sorted((route.best(time_s) for route in self.routes), key=lambda one: one.error)
        if self.task.step_deg is not None or not ENOUGH * self.least(time_s) < found[0].error < np.inf:
            return
        best = {len(one.legs): one for one in reversed(found)}
        for one in sorted(best.values(), key=lambda one: one.error)[:REFINED]:
            legs, error = refined(self.task, one.legs, time_s)
            if error < np.inf:
                self.routes.append(_route(self.task, np.array([leg.angles_deg for leg in legs])))

    def least(self, time_s: float) -> float:
        """Return the error of the optimal design for a time, without turns between its attitudes."""
        return float(self.least_in_a_second / np.sqrt(time_s))

    def best(self, time_s: float) -> LegSelection:
        """Return the best of all routes for a time."""
        best = min((route.best(time_s) for route in self.routes), key=lambda one: one.error)
        return self._thinned(best) if np.isfinite(best.error) else best

    def shortest(self, target: float, most_s: float, close_s: float = CLOSE_S) -> LegSelection:
        """Return the shortest selection that meets the target, by bisection; the best within most_s if none does.

        close_s : accuracy of the time.
        """
        best, low, high = self.best(most_s), 0.0, most_s
        while best.error <= target and high - low > close_s:
            middle = (low + high) / 2
            tried = self.best(middle)
            if tried.error <= target:
                best, high = tried, middle
            else:
                low = middle
        return best

    def _thinned(self, choice: LegSelection) -> LegSelection:
        """Return the selection without legs of negligible time, one after another, as long as the error stays."""
        most, kept = THINNED * choice.error, choice
        while (fewer := _without_one(kept, most)) is not None:
            kept = fewer
        if len(kept.legs) < len(choice.legs):
            self.routes.append(_route(kept.task, np.array([leg.angles_deg for leg in kept.legs])))
        return kept


def selections(task: PlanningTask, time_s: float) -> Iterator[tuple[LegSelection, float]]:
    """Yield the improved best selection of each variant of the manoeuvre, with the error of the optimal design.

    The same search serves a plan from the start and the next leg after a recording.
    """
    for way in task.manoeuvre.ways:
        search = RouteSearch(task.flown_by(way), time_s)
        search.improve(time_s)
        found = search.best(time_s)
        yield (found.filled if np.isfinite(found.error) else found), search.least(time_s)


def design_error(task: PlanningTask, time_s: float) -> float:
    """Return the error of the optimal design within the tilts for a time: no leg of that time is better."""
    return _design_error(task, _within(task, time_s, 1.0)[1])


def _design_error(task: PlanningTask, rows: Array) -> float:
    return float(np.sqrt(optimal(rows, task.wanted, task.before)[0]))


def _without_one(choice: LegSelection, most: float) -> LegSelection | None:
    """Return the selection without its shortest negligible leg that can be spared, None if each one is needed."""
    brief = [k for k, leg in enumerate(choice.legs) if leg.amount < SHORT]
    for k in sorted(brief, key=lambda k: choice.legs[k].amount) if len(choice.legs) > 1 else ():
        kept = np.array([leg.angles_deg for leg in (*choice.legs[:k], *choice.legs[k + 1 :])])
        tried = _route(choice.task, kept).best(choice.time_s)
        if tried.error <= most:
            return tried
    return None


def few(rows: Array, wanted: Array, counts: Sequence[int], before: Array | None = None) -> list[Array]:
    """Return indices of the candidates left after thinning of the optimal design, for descending counts."""
    places, found = np.arange(len(rows)), []
    weights = optimal(rows, wanted, before)[2]
    for count in sorted(counts, reverse=True):
        while np.sum(weights > RARE * weights.max()) > count:
            keep = np.argsort(-weights)[: max(count, int(KEPT * np.sum(weights > RARE * weights.max())))]
            places = places[np.sort(keep)]
            weights = optimal(rows[places], wanted, before)[2]
        found.append(places[weights > RARE * weights.max()])
    return found


def _within(task: PlanningTask, time_s: float, share: float) -> tuple[Array, Array]:
    """Return angles (m, 3) within a share of the tilts, and rows (m, r, k) of a leg for the whole time."""
    angles = task.angles_deg * np.array([1.0, share, share])
    attitudes = Rotation.from_euler("ZYX", angles, degrees=True)
    halves = [task.rows(one) for one in task.manoeuvre.halves(attitudes)]
    return angles, np.concatenate(halves, axis=1) * np.sqrt(time_s / task.interval_s / len(halves))


def _routes(task: PlanningTask, angles: Array, rows: Array, counts: Sequence[int] | None = None) -> list[Route]:
    """Return routes through few attitudes of the optimal design."""
    usual = FEW if task.before is None else FEWER
    chosen = few(rows, task.wanted, usual if counts is None else counts, task.before)
    return [_route(task, _shortest_way(task, np.round(angles[places], 1))) for places in chosen]


def _shortest_way(task: PlanningTask, angles: Array) -> Array:
    """Return angles (m, 3) in the order of least turning."""
    manoeuvre = task.manoeuvre
    before = (manoeuvre.yaw_deg, 0.0, 0.0)
    order = shortest(len(angles), lambda a, b: manoeuvre.move_s(before if a == START else angles[a], angles[b]))
    return np.asarray(angles[order])


def _route(task: PlanningTask, angles: Array) -> Route:
    """Return the route through angles (m, 3), in this order."""
    manoeuvre, angles = task.manoeuvre, merged(angles)
    units = [manoeuvre.unit(Leg.at(one, 1.0)) for one in angles]
    each = np.array([task.information(*unit) for unit in units])
    phase = manoeuvre.phase([Leg.at(one, manoeuvre.least) for one in angles])
    unit_s = units[0][2] - units[0][1]
    fixed = task.information(phase, 0.0, phase.duration_s) - manoeuvre.least * each.sum(axis=0)
    fixed = fixed if task.before is None else fixed + task.before
    moving_s = phase.duration_s - manoeuvre.least * unit_s * len(angles)
    return Route(task, angles, LegInformation(fixed, each, task.wanted, manoeuvre.least, unit_s), moving_s)


def merged(angles: Array) -> Array:
    """Return angles (m, 3) without consecutive repetitions of an attitude, which would only cost a turn."""
    attitudes = Rotation.from_euler("ZYX", angles, degrees=True)
    apart = (attitudes[1:] * attitudes[:-1].inv()).magnitude() if len(angles) > 1 else np.zeros(0)
    return np.asarray(angles[np.concatenate(([True], np.degrees(apart) >= SAME_DEG))])
