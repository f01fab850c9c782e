"""The magnetometer as a chain of effects: the field passes through them in order, and each leaves a label."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from scenarios.arrays import Array
from scenarios.seeds import stream
from sim.effects.base import Effect, Replacement
from sim.state import State

Labels = dict[str, Array]
"""Name of an effect -> contribution (n, 3) in nT."""


@dataclass
class ChainLink:
    """An effect in a chain, with the random generator and the memory of one run."""

    effect: Effect
    rng: np.random.Generator
    memory: dict[str, Any] = field(default_factory=dict)

    def step(self, state: State, signal_nT: Array) -> tuple[Array, Array]:
        """Return the output signal and the contribution (label), both (n, 3) in nT."""
        if isinstance(self.effect, Replacement):
            out = self.effect.replaced(state, signal_nT, self.rng, self.memory)
            return out, out - signal_nT
        label = self.effect.contribution(state, signal_nT, self.rng, self.memory)
        return signal_nT + label, label


class Chain:
    """The effects of one magnetometer through one run, block by block.

    ``mag = ((field + label_1) + label_2) + ...``, so mag = field + sum of labels to the rounding of a float64 (below
    1e-9 nT). Effects of the electronics set the value, see `Replacement`.

    Parameters
    ----------
    effects : in the order of the chain, see `sim.effects.build`.
    seed, run, sensor : an effect draws from a stream of random numbers by sensor, name and instance, so an added
        effect or sensor leaves the noise of the rest unchanged.
    """

    def __init__(self, effects: Sequence[Effect], seed: int, run: int = 0, sensor: int = 0) -> None:
        seen: dict[str, int] = {}
        self.links: list[ChainLink] = []
        for effect in effects:
            instance = seen.get(effect.name, 0)
            seen[effect.name] = instance + 1
            rng = stream(seed, run, sensor, effect.name, instance, bits=np.random.PCG64)
            self.links.append(ChainLink(effect, rng))

    def apply(self, state: State, finer: State | None = None) -> tuple[Array, Labels]:
        """Measured field mag_nT (n, 3) of the next block, and the contributions name -> (n, 3) in nT.

        Several effects of one name share a label, their sum. finer : the block on a finer grid, a whole number of rows
        a sample; effects up to the last `continuous` effect are then computed on the finer grid.
        """
        first = 0 if finer is None else continuous_part([link.effect for link in self.links])
        signal, labels = np.array(state.field_nT, dtype=np.float64), Labels()
        if finer is not None and first:
            every = round(state.interval_s / finer.interval_s)
            course, fine = _through(self.links[:first], finer, np.array(finer.field_nT, dtype=np.float64), Labels())
            signal, labels = course[::every].copy(), {name: label[::every].copy() for name, label in fine.items()}
        return _through(self.links[first:], state, signal, labels)


def _through(links: Sequence[ChainLink], state: State, signal: Array, labels: Labels) -> tuple[Array, Labels]:
    """The signal (n, 3) behind the links, and the labels with their contributions added."""
    for link in links:
        signal, label = link.step(state, signal)
        name = link.effect.name
        labels[name] = labels[name] + label if name in labels else label
    return signal, labels


def continuous_part(effects: Sequence[Effect]) -> int:
    """Number of effects computed on the finer grid: up to the last `continuous` one, none after random numbers.

    Noise is defined at the samples, so the finer grid ends before the first stochastic effect.
    """
    drawn = next((i for i, effect in enumerate(effects) if effect.stochastic), len(effects))
    return max((i + 1 for i, effect in enumerate(effects[:drawn]) if effect.continuous), default=0)


def apply_deterministic(effects: Sequence[Effect], state: State) -> tuple[Array, Labels]:
    """`Chain.apply` of a whole run, stochastic effects left out: the prediction of a model."""
    return Chain([effect for effect in effects if not effect.stochastic], seed=0).apply(state)
