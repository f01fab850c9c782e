"""The trials, and what one of them gives."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from benchmarks.diagnosis.motion import flown, jittered, motions, turned
from benchmarks.diagnosis.outside import OUTSIDE, disturbed
from benchmarks.diagnosis.truth import BASE, DIRECT, FLICKER, HIDDEN, PAIRS, UNSTATED, Tables, felt_by, hidden, stated
from benchmarks.diagnosis.wide import rests
from benchmarks.diagnosis.wide.courses import DRAWN
from benchmarks.diagnosis.wide.making import Made, hidden_in, null, vehicle_for
from benchmarks.diagnosis.wide.noises import COLOURS as WIDE_COLOURS
from benchmarks.diagnosis.wide.table import FAMILIES, FAULTS
from benchmarks.diagnosis.wide.table import PAIRS as WIDE_PAIRS
from diagnosis.policy import STANDARD, Policy
from diagnosis.result import Diagnosis, parameters
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.arrays import Array
from sim import effects as effect_table
from sim.chain import Chain
from sim.scenario import ModelSpec
from sim.state import State
from validation.signals.amplitude import rms

STRENGTHS = (0.1, 0.3, 1.0)
NULLS, COLOURED = 15, 10
"""Null runs of each motion for one seed of the others: 300 and 200 for ten seeds."""
FACTORS = (-1.0, 0.8)
"""Size of an effect in the model over its true size: a sign, a fifth too small."""
COLOURS = ("attitude", "flicker", "jitter", "all")
WIDE_NULLS, WIDE_COLOURED = 10, 7
"""Null runs of each wide motion for one seed."""
ANY = "any"
"""A motion that is drawn with the truth."""
WIDE, REST = "wide-", "rest-"
"""How kinds of trials begin whose truth is of a wide family, and whose rest was measured."""


@dataclass(frozen=True)
class Trial:
    """One recording to diagnose: kind of test, motion, what is hidden at what strengths, seed."""

    kind: str
    motion: str
    hidden: tuple[str, ...]
    strengths: tuple[float, ...]
    seed: int

    @property
    def key(self) -> str:
        """What tells it from every other."""
        return "/".join(
            [self.kind, self.motion, "+".join(self.hidden), "+".join(map(str, self.strengths)), f"{self.seed}"]
        )


def trials(first_seed: int, seeds: int) -> Iterator[Trial]:
    """Every trial of the bench, a seed at a time."""
    for seed in range(first_seed, first_seed + seeds):
        yield from _wide(seed)
        yield from _measured_rests(seed)
        for motion in motions():
            for k in range(NULLS):
                yield Trial("null", motion, (), (), seed * NULLS + k)
            for k in range(COLOURED):
                number = seed * COLOURED + k
                yield Trial("coloured", motion, (COLOURS[number % len(COLOURS)],), (), number)
            for effect in HIDDEN:
                for strength in STRENGTHS:
                    yield Trial("single", motion, (effect,), (strength,), seed)
                yield Trial("left-out", motion, (effect,), (1.0,), seed)
                yield from _stated_wrongly(motion, effect, seed)
            for effect in DIRECT:
                yield Trial("direct", motion, (effect,), (1.0,), seed)
            for name in OUTSIDE:
                yield Trial("outside", motion, (name,), (1.0,), seed)
            for pair in PAIRS:
                yield Trial("two", motion, pair, (1.0, 1.0), seed)
                yield Trial("two", motion, pair[:: 1 - 2 * (seed % 2)], (3.0, 1.0), seed)


def _stated_wrongly(motion: str, effect: str, seed: int) -> Iterator[Trial]:
    """An effect that the model states with a wrong size."""
    for factor in FACTORS if effect not in UNSTATED else ():
        yield Trial("stated", motion, (effect,), (factor,), seed)


def _wide(seed: int) -> Iterator[Trial]:
    """Truths of wide families: every form at every strength, every fault, pairs, and nulls."""
    for motion in DRAWN:
        for k in range(WIDE_NULLS):
            yield Trial(f"{WIDE}null", motion, (), (), seed * WIDE_NULLS + k)
        for k in range(WIDE_COLOURED):
            number = seed * WIDE_COLOURED + k
            yield Trial(f"{WIDE}coloured", motion, (WIDE_COLOURS[number % len(WIDE_COLOURS)],), (), number)
    for name in FAMILIES:
        for strength in STRENGTHS:
            yield Trial(f"{WIDE}single", ANY, (name,), (strength,), seed)
        yield Trial(f"{WIDE}left-out", ANY, (name,), (1.0,), seed)
    for name in FAULTS:
        yield Trial(f"{WIDE}direct", ANY, (name,), (1.0,), seed)
    for pair in WIDE_PAIRS:
        yield Trial(f"{WIDE}two", ANY, pair, (1.0, 1.0), seed)


def _measured_rests(seed: int) -> Iterator[Trial]:
    """Measured rests, where the logs are there: with a channel shifted in time, and as the rest of a simulation."""
    for name in rests.shifted_names(seed):
        yield Trial(f"{REST}shifted", name, (), (), seed)
    for name in rests.rest_names():
        yield Trial(f"{REST}random", name, (), (), seed)


def run(trial: Trial, policy: Policy = STANDARD) -> dict[str, Any]:
    """Make the recording, diagnose it, and tell what came out beside what was hidden."""
    if trial.kind.startswith((WIDE, REST)):
        return _run_wide(trial, policy)
    recording, truth, field = made(trial)
    without = frozenset(trial.hidden if trial.kind == "left-out" else ())
    model = ModelSpec.model_validate({"effects": BASE | _stated(trial), "field": {"enu_nT": field.tolist()}})
    begun = time.perf_counter()
    found = diagnose(recording, model, without=without, policy=policy)
    return _row(trial, found, time.perf_counter() - begun) | {"parameters": _against(found, truth)}


def _run_wide(trial: Trial, policy: Policy) -> dict[str, Any]:
    """The row of a truth of a wide family or of a measured rest."""
    made = _made_wide(trial)
    begun = time.perf_counter()
    without = frozenset(trial.hidden if trial.kind.endswith("left-out") else ())
    found = diagnose(made.recording, made.model, fitted_base=made.fitted_base, without=without, policy=policy)
    return _row(trial, found, time.perf_counter() - begun) | {"parameters": {}, "colour": made.colour}


def _made_wide(trial: Trial) -> Made:
    kind, seed = trial.kind, trial.seed
    if kind.startswith(REST):
        return rests.shifted(trial.motion, seed) if kind == f"{REST}shifted" else rests.beside(trial.motion, seed)
    if kind == f"{WIDE}null":
        return null(trial.motion, None, seed // WIDE_NULLS, seed)
    if kind == f"{WIDE}coloured":
        return null(trial.motion, trial.hidden[0], seed // WIDE_COLOURED, seed)
    return hidden_in(vehicle_for(trial.hidden, seed), trial.hidden, trial.strengths, seed)


def _row(trial: Trial, found: Diagnosis, seconds: float) -> dict[str, Any]:
    return {
        **asdict(trial), "key": trial.key, "verdict": found.verdict, "seconds": seconds,
        "names": [(one.name, list(one.alternatives), one.kind) for one in found.named],
        "explained": found.gap.explained, "before_sigma": found.gap.before_sigma,
        "resimulated_nT": found.resimulated_nT, "after_nT": rms(found.after_nT[found.problem.usable > 0]),
        "where": [channel for channel, _, _ in found.where],
    }  # fmt: skip


def made(trial: Trial) -> tuple[Recording, Tables, Array]:
    """The trial's recording, the tables of what is hidden, and the field (east, north, up)."""
    recording, state, field = flown(trial.motion)
    tables: Tables = {}
    if trial.kind not in ("null", "coloured", "outside"):
        for name, strength in zip(trial.hidden, trial.strengths, strict=True):
            if trial.kind == "stated":
                tables |= stated(name, strength, trial.seed, state)[0]
                continue
            tables |= hidden(name, strength, trial.seed, state)
    if "flicker" in trial.hidden or "all" in trial.hidden:
        tables |= FLICKER
    mag_nT = measured(tables, state, trial.seed)
    recording = replace(recording, mag_nT=mag_nT)
    if trial.kind == "coloured":
        recording = _coloured(recording, trial)
    if trial.kind == "outside":
        recording = disturbed(trial.hidden[0], trial.strengths[0], trial.seed, recording, state, mag_nT)
    return recording, tables, field


def _stated(trial: Trial) -> Tables:
    """Tables of the effect that the model states wrongly."""
    if trial.kind != "stated":
        return {}
    _, state, _ = flown(trial.motion)
    return stated(trial.hidden[0], trial.strengths[0], trial.seed, state)[1]


def measured(tables: Tables, state: State, seed: int) -> Array:
    """The chain with the base and what is hidden; joined tables give the base's a second entry."""
    everything = {**BASE}
    for name, table in tables.items():
        mine = table if isinstance(table, list) else [table]
        everything[name] = [BASE[name], *mine] if name in BASE else table
    felt = state
    for name in tables:
        felt = felt_by(name, felt)
    return Chain(effect_table.build(everything, None, "truth"), seed).apply(felt)[0]


def _coloured(recording: Recording, trial: Trial) -> Recording:
    colour = trial.hidden[0]
    if colour in ("jitter", "all"):
        recording = replace(recording, mag_nT=jittered(recording, recording.mag_nT, trial.seed))
    return turned(recording, trial.seed) if colour in ("attitude", "all") else recording


def _against(found: Diagnosis, truth: Tables) -> dict[str, Any]:
    """Parameters with 95 % intervals of named effects: value, low, high, true; of several sources the main one."""
    out: dict[str, Any] = {}
    for one in found.named:
        tables = truth.get(one.name, {})
        table = tables[0] if isinstance(tables, list) else tables
        for key, p in parameters(one).items():
            if key in table and (p["low"] is not None or key in ("time_s", "frequency_hz")):
                values = [np.ravel(p[k]).tolist() if p[k] is not None else None for k in ("value", "low", "high")]
                out[f"{one.name}.{key}"] = [*values, np.ravel(table[key]).tolist()]
    return out
