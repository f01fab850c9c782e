"""The curve of a channel that `unknown` gives: does it explain the gap on another recording of the vehicle?

    python -m benchmarks.diagnosis.curves --first 100 --seeds 1 -o out/curves

A payload whose current is logged disturbs by a form and a lag that no effect has, beside two channels that drive
nothing. One flight is diagnosed; on another flight, with another course of the current, its curves are held against
the gap without its noise, coefficients as they are. Tuning seeds, 24 trials each; the same command goes on where it was
stopped.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lfilter

from benchmarks.diagnosis.resumed import resumed
from benchmarks.diagnosis.three import FLIGHTS, flown_as
from benchmarks.diagnosis.truth import BASE, beyond_base
from diagnosis.problem.formulation import pose_model
from diagnosis.repair.refinement import chain_residual
from diagnosis.result import EvidenceKind
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.arrays import Array
from sim import effects as effect_table
from sim.chain import Chain
from sim.effects.base import Effect
from sim.scenario import ModelSpec
from sim.state import State
from validation.signals.amplitude import rms

FORMS: dict[str, Callable[[Array], Array]] = {
    "saturating": lambda u: np.tanh(2.5 * u),
    "root": lambda u: np.sign(u) * np.sqrt(np.abs(u)),
    "dead-zone": lambda u: np.sign(u) * np.maximum(np.abs(u) - 0.4, 0.0),
    "one-way": lambda u: np.sqrt(np.maximum(u + 1.0, 0.0)),
}
"""Disturbance by current, which lies between -1 and 1."""
STRENGTHS = (0.3, 1.0, 3.0)
"""Rms in the first flight over the noise."""
LAGS_S = (0.0, 0.3, 1.0, 5.0)
COURSES = ("levels", "tones")
PAYLOAD = "payload_A"
IDLE = ("valve_open", "tank_level")
"""Channels that drive nothing."""
BAR = 0.9
"""Share of the gap on the other recording."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Payload:
    """What disturbs: on a vehicle, by a form, at a strength; lag, course and direction are drawn by the seed."""

    vehicle: str
    form: str
    strength: float
    seed: int

    @property
    def key(self) -> str:
        """What tells it from every other."""
        return f"{self.vehicle}/{self.form}/{self.strength:g}/{self.seed}"

    @property
    def _rng(self) -> np.random.Generator:
        numbers = [sorted(FLIGHTS).index(self.vehicle), [*FORMS].index(self.form), STRENGTHS.index(self.strength)]
        return np.random.default_rng([self.seed, 31, *numbers])

    @property
    def drawn(self) -> tuple[float, str, Array]:
        """Its lag in s, the course of its current, and the direction (3,) of its field."""
        rng = self._rng
        return float(rng.choice(LAGS_S)), str(rng.choice(COURSES)), rng.normal(size=3)


def payloads(first_seed: int, seeds: int) -> Iterator[Payload]:
    """Every form on every vehicle at every strength."""
    for seed in range(first_seed, first_seed + seeds):
        for vehicle in sorted(FLIGHTS):
            yield from (Payload(vehicle, form, strength, seed) for form in FORMS for strength in STRENGTHS)


def current(course: str, time_s: Array, rng: np.random.Generator) -> Array:
    """A course (n,) between -1 and 1: levels of some 20 s each, or three tones of 5 to 60 s."""
    if course == "levels":
        switches = np.cumsum(rng.exponential(20.0, 2000))
        return np.asarray(rng.uniform(-1, 1, 2001)[np.searchsorted(switches, time_s)])
    tones = sum(np.sin(2 * np.pi * time_s / period + rng.uniform(0, 6)) for period in rng.uniform(5, 60, 3))
    return np.asarray(tones / np.abs(tones).max())


def late(values: Array, lag_s: float, interval_s: float) -> Array:
    """Values (n,) through one lag, settled at the first."""
    if not lag_s:
        return values
    p = np.exp(-interval_s / lag_s)
    return np.asarray(lfilter([1 - p], [1, -p], values, zi=[p * values[0]])[0])


def flight(payload: Payload, i: int, *, noise: bool = True) -> tuple[Recording, Array]:
    """One flight with the payload and idle channels, and the field (east, north, up)."""
    recording, state, field = flown_as(payload.vehicle, i)
    logged, added = _disturbance(payload, i, state)
    first_state = flown_as(payload.vehicle, 0)[1]
    first = _disturbance(payload, 0, first_state)[1]
    size = payload.strength / beyond_base(first_state.field_nT + first, first_state.field_nT)
    tables = BASE if noise else {name: table for name, table in BASE.items() if name != "white_noise"}
    mag_nT = Chain(effect_table.build(tables, None, "truth"), 1000 * payload.seed + i).apply(state)[0] + size * added
    return replace(recording, mag_nT=mag_nT, channels={**recording.channels, **logged}), field


def _disturbance(payload: Payload, i: int, state: State) -> tuple[dict[str, Array], Array]:
    """The channels of a flight, and what the payload adds (n, 3) before it has its size."""
    lag_s, course, direction = payload.drawn
    rng = np.random.default_rng([payload.seed, i, 32])
    driven = current(course, state.time_s, rng)
    idle = {name: current(one, state.time_s, rng) for name, one in zip(IDLE, COURSES, strict=True)}
    felt = late(FORMS[payload.form](driven), lag_s, state.interval_s)
    return {PAYLOAD: driven, **idle}, felt[:, None] * direction


def run_payload(payload: Payload) -> Row:
    """Diagnose the first flight, and hold its curves against the second."""
    (recording, field), (other, _) = flight(payload, 0), flight(payload, 1, noise=False)
    model = ModelSpec.model_validate({"effects": BASE, "field": {"enu_nT": field.tolist()}})
    begun = time.process_time()
    found = diagnose(recording, model)
    lag_s, course, _ = payload.drawn
    curves = [one.effect for one in found.named if one.kind is EvidenceKind.CURVE]
    return {
        **asdict(payload), "key": payload.key, "lag_s": lag_s, "course": course, "cpu_s": time.process_time() - begun,
        "verdict": found.verdict, "names": [one.name for one in found.named],
        "channels": [cause for one in curves for cause in one.required_inputs], "explained": found.gap.explained,
        "elsewhere": explained(other, model, curves) if curves else None,
    }  # fmt: skip


def explained(quiet: Recording, model: ModelSpec, effects: Sequence[Effect]) -> float:
    """Share of the gap of a recording without noise that effects explain as they are, the iron refitted each time."""
    problem = pose_model(quiet, model, None, None)
    everywhere = np.ones(len(quiet), dtype=bool)
    left = (chain_residual(problem, some, everywhere) for some in ((), effects))
    before, after = (rms(one * problem.sigma_nT) for one in left)
    return 1 - (after / before) ** 2


def figures(rows: Sequence[Row]) -> Row:
    """How many payloads are followed by their own channel, and what their curves explain elsewhere."""
    followed = [row for row in rows if row["channels"] and set(row["channels"]) == {PAYLOAD}]
    elsewhere = [row["elsewhere"] for row in followed]
    return {
        "payloads": len(rows),
        "followed": len(followed),
        "by another channel too": sum(bool(set(row["channels"]) - {PAYLOAD}) for row in rows),
        "at least 0.9 elsewhere": sum(share >= BAR for share in elsewhere),
        "elsewhere": np.quantile(elsewhere, [0.0, 0.1, 0.5]).tolist() if elsewhere else None,
        "not followed": {row["key"]: [row["verdict"], row["names"]] for row in rows if row not in followed},
    }


def main() -> None:
    """Run the payloads that are not in the log yet, and print their figures."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.diagnosis.curves")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("-o", "--out", type=Path, default=Path("out/curves"))
    given = parser.parse_args()
    wanted = list(payloads(given.first, given.seeds))
    print(json.dumps(figures(resumed(wanted, given.out, run_payload, attrgetter("key"))), indent=1))


if __name__ == "__main__":
    main()
