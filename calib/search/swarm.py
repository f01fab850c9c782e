"""Particle swarm: individuals accelerated towards their own best position and the leader's."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from calib.numerics.kernels import fast_kernel
from calib.search.population import Move, Population, Space
from scenarios.arrays import Array


@fast_kernel
def fly(
    x: Array, v: Array, own: Array, leader: Array, inertia: float, c1: float, c2: float,
    fastest: Array, lower: Array, upper: Array, drawn: Array,
) -> None:  # fmt: skip
    """One move of all particles, in place: x, v, own best (k, d); leader, fastest, lower, upper (d,).

    drawn (k, d, 2) : r1 and r2; an array, since a generator as argument costs as much as the move
    """
    for k in range(x.shape[0]):
        for j in range(x.shape[1]):
            speed = inertia * v[k, j] + c1 * drawn[k, j, 0] * (own[k, j] - x[k, j])
            speed += c2 * drawn[k, j, 1] * (leader[j] - x[k, j])
            speed = min(max(speed, -fastest[j]), fastest[j])
            place = x[k, j] + speed
            if place < lower[j] or place > upper[j]:
                place = min(max(place, lower[j]), upper[j])
                speed = 0.0
            x[k, j] = place
            v[k, j] = speed


@dataclass(eq=False)
class Swarm(Move):
    """v <- w v + c1 r1 (best - x) + c2 r2 (leader - x),  x <- x + v,  w falling evenly over the generations.

    Velocities begin even up to `most_speed` of the range, and keep to it; who would leave the bounds stops at the wall.
    """

    memory: ClassVar[bool] = True
    inertia: tuple[float, float]
    c1: float
    c2: float
    most_speed: float
    generations: int
    velocity: Array = field(default_factory=lambda: np.empty((0, 0)))

    def setup(self, population: Population, space: Space, rng: np.random.Generator) -> None:
        """Draw the velocities."""
        self.velocity = self.fastest(space) * rng.uniform(-1.0, 1.0, population.x.shape)

    def fastest(self, space: Space) -> Array:
        """Largest speed (d,) a generation."""
        return self.most_speed * (space.upper - space.lower)

    def advance(self, population: Population, space: Space, generation: int, rng: np.random.Generator) -> None:
        """[Zhang2018] eq. 19 to 21."""
        most, least = self.inertia
        inertia = most - (most - least) * (generation + 1) / self.generations
        leader = population.best[population.leader].copy()
        fly(
            population.x, self.velocity, population.best, leader, inertia, self.c1, self.c2,
            self.fastest(space), space.lower, space.upper, rng.random((*population.x.shape, 2)),
        )  # fmt: skip
        population.cost = space.costs(population.x)
