"""The loop of the population searches, and the moves that plug into it, on a bowl whose minimum is known."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from calib.search.differential import RandOne, Schedule, TwoStrategies, make_trial
from calib.search.genetic import Generation, Heredity, SwarmWithHeredity, Tournament
from calib.search.population import Move, Population, search
from calib.search.swarm import Swarm

AIM = np.array([0.3, -0.4, 0.1, 0.0])
HEREDITY = Heredity((0.9, 0.6), (0.1, 0.001), 0.02, 1e4)


@dataclass
class Bowl:
    """|x - AIM|^2 within +-1; counts what it is asked."""

    lower: np.ndarray = field(default_factory=lambda: -np.ones(4))
    upper: np.ndarray = field(default_factory=lambda: np.ones(4))
    asked: int = 0

    def costs(self, individuals: np.ndarray) -> np.ndarray:
        assert (np.abs(individuals) <= 1.0).all()
        self.asked += len(individuals)
        return np.asarray(((individuals - AIM) ** 2).sum(axis=1))


def moves(generations: int) -> dict[str, Move]:
    swarm = Swarm((0.95, 0.4), 2.0, 2.0, 0.2, generations)
    return {
        "swarm": swarm,
        "generation": Generation(HEREDITY),
        "both": SwarmWithHeredity(Swarm((0.95, 0.4), 2.0, 2.0, 0.2, generations), HEREDITY),
        "tournament": Tournament(0.9, 0.02, 0.1, generations),
        "rand one": RandOne(0.85, 0.9),
        "two strategies": TwoStrategies(Schedule((0.6, 0.3), (0.8, 0.4), (1.0, 0.1), generations)),
    }


@pytest.mark.parametrize("name", list(moves(1)))
def test_every_move_goes_downhill_within_the_bounds(name: str) -> None:
    bowl = Bowl()
    found = search(bowl, moves(150)[name], 40, 150, np.random.default_rng(0))
    assert len(found.costs) == 150
    assert not found.settled
    assert found.costs[-1] < found.costs[0] / (3 if name == "generation" else 20)
    assert float(bowl.costs(found.best[None])[0]) == pytest.approx(found.costs[-1], rel=1e-12)


@pytest.mark.parametrize("name", ["swarm", "both", "tournament", "rand one", "two strategies"])
def test_the_best_is_kept_by_all_but_the_plain_generation(name: str) -> None:
    costs = search(Bowl(), moves(60)[name], 20, 60, np.random.default_rng(1)).costs
    assert (np.diff(costs) <= 0).all()


def test_same_seed_same_search() -> None:
    for name in moves(1):
        one, other = (search(Bowl(), moves(20)[name], 20, 20, np.random.default_rng(3)) for _ in range(2))
        np.testing.assert_array_equal(one.best, other.best)


def test_the_loop_stops_where_the_population_has_settled() -> None:
    def run(tolerance: float | None) -> tuple[int, bool]:
        found = search(Bowl(), RandOne(0.5, 0.9), 20, 3000, np.random.default_rng(0), tolerance)
        return len(found.costs), found.settled

    early, late, never = run(3.0), run(1e-3), run(None)
    assert early[0] < late[0] < 3000
    assert early[1]
    assert late[1]
    assert never == (3000, False)


def test_a_population_that_settles_in_the_last_generation_has_settled() -> None:
    def run(generations: int) -> tuple[int, bool]:
        found = search(Bowl(), RandOne(0.5, 0.9), 20, generations, np.random.default_rng(0), 1e-3)
        return len(found.costs), found.settled

    needed, _ = run(3000)
    assert run(needed) == (needed, True)
    assert run(needed - 1) == (needed - 1, False)


def test_settled_is_a_matter_of_the_roots_spread() -> None:
    x, cost = np.zeros((2, 1)), np.array([4.0, 4.0 + 4.0 * 0.01**2])
    population = Population(x, cost, x, cost)
    assert population.settled(0.0101)
    assert not population.settled(0.0099)


def test_each_individual_s_evaluations() -> None:
    """A swarm is weighed once a generation and at the start; with heredity its worse half once more."""
    for name, times in (("swarm", 11), ("rand one", 11), ("both", 16)):
        bowl = Bowl()
        search(bowl, moves(10)[name], 20, 10, np.random.default_rng(0))
        assert bowl.asked == 20 * times


def test_a_worse_trial_is_refused_and_an_equal_one_taken() -> None:
    x = np.zeros((3, 2))
    population = Population(x, np.array([1.0, 1.0, 1.0]), x.copy(), np.ones(3))
    population.improve(np.ones((3, 2)), np.array([0.5, 1.0, 1.5]))
    np.testing.assert_array_equal(population.x[:, 0], [1.0, 1.0, 0.0])
    np.testing.assert_array_equal(population.cost, [0.5, 1.0, 1.0])


def test_schedule_runs_from_start_to_end() -> None:
    schedule = Schedule((0.6, 0.3), (0.8, 0.4), (1.0, 0.1), 100)
    np.testing.assert_allclose(schedule.at(0), (0.6, 0.8, 1.0), rtol=0.02)
    last = schedule.at(99)
    np.testing.assert_allclose(last[:2], (0.3, 0.4), rtol=1e-9)
    assert last[2] == pytest.approx(0.109)
    fade = np.exp(1.0 - 100.0 / 51.0)
    np.testing.assert_allclose(schedule.at(50), (0.3 * 2.0**fade, 0.4 + 0.4 * fade, 0.55), rtol=1e-12)


def test_a_trial_is_the_textbook_s() -> None:
    """Target-to-best with every entry crossed: v - x_m is F (best - x_m) plus F times two differences of others."""
    x = np.diag(2.0 ** np.arange(7))[:, :7]
    trial, low, high = np.empty(7), np.full(7, -1e9), np.full(7, 1e9)
    make_trial(x, 2, 5, False, 0.5, 1.0, low, high, np.random.default_rng(0), trial)
    weights = np.linalg.solve(x.T, trial)
    assert weights[2] == pytest.approx(0.5)
    others = np.delete(weights, 2)
    others[4] -= 0.5
    assert sorted(np.round(others[others != 0.0], 9)) in ([-0.5, -0.5, 0.5, 0.5], [-0.5, 0.5])
    make_trial(x, 2, 5, True, 0.5, 1.0, low, high, np.random.default_rng(0), trial)
    assert sorted(np.linalg.solve(x.T, trial)[np.abs(np.linalg.solve(x.T, trial)) > 1e-12]) == [-0.5, 0.5, 1.0]


@pytest.mark.parametrize(("generation", "inertia"), [(0, 0.9 - 0.05), (9, 0.4)])
def test_inertia_falls_evenly(generation: int, inertia: float) -> None:
    swarm, bowl = Swarm((0.9, 0.4), 0.0, 0.0, 0.2, 10), Bowl()
    population = Population.spread(bowl, 5, np.random.default_rng(0))
    swarm.velocity = np.full((5, 4), 1e-6)
    swarm.advance(population, bowl, generation, np.random.default_rng(0))
    np.testing.assert_allclose(swarm.velocity, inertia * 1e-6)


@pytest.mark.parametrize(("generation", "width"), [(0, 0.1), (8, 0.02)])
def test_mutations_narrow_evenly(generation: int, width: float) -> None:
    """Without crossover, from one place in the middle: normal deviates of that part of the range."""
    bowl, x = Bowl(), np.zeros((2000, 4))
    population = Population(x, bowl.costs(x), x, bowl.costs(x))
    Tournament(0.0, 1.0, 0.1, 10).advance(population, bowl, generation, np.random.default_rng(0))
    assert population.x[1:].std() == pytest.approx(width * 2.0, rel=0.05)
    np.testing.assert_array_equal(population.x[0], 0.0)


def test_only_the_worse_half_inherits() -> None:
    """A swarm that stands still leaves the better half where it was."""
    move, bowl, rng = (
        SwarmWithHeredity(Swarm((0.9, 0.4), 0.0, 0.0, 0.0, 10), HEREDITY),
        Bowl(),
        np.random.default_rng(0),
    )
    population = Population.spread(bowl, 40, rng)
    before, order = population.x.copy(), np.argsort(population.cost)
    move.setup(population, bowl, rng)
    move.advance(population, bowl, 0, rng)
    moved = (population.x != before).any(axis=1)
    assert not moved[order[:20]].any()
    assert moved[order[20:]].sum() > 10
