"""The magnetometer: the field passes through the effects one after the other, each leaving its label."""

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
"""Name of an effect -> its contribution (n, 3) in nT."""


@dataclass
class ChainLink:
    """An effect at its place in a chain, with its own random numbers and its memory of the run so far."""

    effect: Effect
    rng: np.random.Generator
    memory: dict[str, Any] = field(default_factory=dict)

    def step(self, state: State, signal_nT: Array) -> tuple[Array, Array]:
        """The signal that leaves, and the contribution (label), both (n, 3)."""
        if isinstance(self.effect, Replacement):
            out = self.effect.replaced(state, signal_nT, self.rng, self.memory)
            return out, out - signal_nT
        label = self.effect.contribution(state, signal_nT, self.rng, self.memory)
        return signal_nT + label, label


class Chain:
    """One magnetometer's effects through one run, block by block.

    ``mag = (((field + label_1) + label_2) + ...)`` in the order of the effects, so mag = field + sum of labels to
    the rounding of a float64 (below 1e-9 nT); electronics effects set the value itself, see `Replacement`.

    Parameters
    ----------
    effects : in the order in which they act, see `sim.effects.build`.
    seed, run, sensor : each effect draws from a stream of its own, by sensor, name and instance, so that adding an
        effect or a sensor leaves the others' noise as it is.
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
        """Measured field mag_nT (n, 3) of the run's next block, and name -> (n, 3) contributions in nT.

        Several effects of one name share a label, their sum. finer : the same block with a whole number of rows a
        sample; the effects up to the last that follows the field between samples are then computed on it.
        """
        first = 0 if finer is None else continuous_part([link.effect for link in self.links])
        signal, labels = np.array(state.field_nT, dtype=np.float64), Labels()
        if finer is not None and first:
            every = round(state.interval_s / finer.interval_s)
            course, fine = _through(self.links[:first], finer, np.array(finer.field_nT, dtype=np.float64), Labels())
            signal, labels = course[::every].copy(), {name: label[::every].copy() for name, label in fine.items()}
        return _through(self.links[first:], state, signal, labels)


def _through(links: Sequence[ChainLink], state: State, signal: Array, labels: Labels) -> tuple[Array, Labels]:
    """The signal (n, 3) behind some links, and the labels with theirs."""
    for link in links:
        signal, label = link.step(state, signal)
        name = link.effect.name
        labels[name] = labels[name] + label if name in labels else label
    return signal, labels


def continuous_part(effects: Sequence[Effect]) -> int:
    """How many effects of a chain meet a continuous field: up to the last that follows it between samples.

    None beyond the first that draws random numbers: noise is one of samples.
    """
    drawn = next((i for i, effect in enumerate(effects) if effect.stochastic), len(effects))
    return max((i + 1 for i, effect in enumerate(effects[:drawn]) if effect.continuous), default=0)


def apply_deterministic(effects: Sequence[Effect], state: State) -> tuple[Array, Labels]:
    """`Chain.apply` of a whole run with the effects that draw no random numbers: a model's prediction."""
    return Chain([effect for effect in effects if not effect.stochastic], seed=0).apply(state)
