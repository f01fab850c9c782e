"""Effects that act in a fifth of the run: is the interval found, and the iron beside it? And always: is none found?

    python -m benchmarks.diagnosis.partly --tuning --seeds 1 -o out/partly-bench

A trial lands in trials.jsonl as it ends; the same command goes on where it was stopped.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # a trial a core; before numpy is imported
    os.environ.setdefault(_name, "1")

import argparse  # noqa: E402
import json  # noqa: E402
import time  # noqa: E402
from collections.abc import Iterator, Sequence  # noqa: E402
from dataclasses import asdict, dataclass, replace  # noqa: E402
from functools import partial  # noqa: E402
from operator import attrgetter  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

import numpy as np  # noqa: E402

from benchmarks.diagnosis.motion import flown, jittered, motions, turned  # noqa: E402
from benchmarks.diagnosis.resumed import resumed  # noqa: E402
from benchmarks.diagnosis.truth import BASE, DIRECT, FLICKER, HIDDEN, NOISE_NT, POWER, felt_by  # noqa: E402
from diagnosis.policy import STANDARD, Policy, changed  # noqa: E402
from diagnosis.result import Diagnosis  # noqa: E402
from diagnosis.workflow import diagnose  # noqa: E402
from recordings import Recording  # noqa: E402
from scenarios.arrays import Array  # noqa: E402
from sim import effects as effect_table  # noqa: E402
from sim.chain import Chain, apply_deterministic  # noqa: E402
from sim.effects.base import Effect  # noqa: E402
from sim.effects.iron import HardIron, SoftIron  # noqa: E402
from sim.scenario import ModelSpec  # noqa: E402
from sim.state import State  # noqa: E402

SHARE = 0.2
"""Of the run, in which an effect acts."""
STRENGTHS = (1.0, 3.0)
"""Rms in that part after the base is refitted to the run, over the noise of a sample."""
PARTLY = ("motor_current", "current_ripple", "eddy_current", "temperature_offset", "hard_iron", "nonlinearity")
"""A motor on one leg, a ripple switched on, a plate mounted, a sensor swapped, a magnet brought near."""
ALWAYS = (
    "motor_current", "current_ripple", "eddy_current", "temperature_offset", "nonlinearity", "hysteresis",
    "temperature_scale", "latency", "hard_iron_drift", "offset_jump", "local_dipole", "diurnal_drift",
)  # fmt: skip
COLOURS = ("attitude", "flicker", "jitter")
SCORED, TUNED = 2000, 0
NORMAL_95 = 1.96
Row = dict[str, Any]
Window = tuple[float, float]


@dataclass(frozen=True)
class Trial:
    """kind: "part", "always" or "null"; what is hidden, its strength, the seed."""

    kind: str
    motion: str
    hidden: str
    strength: float
    seed: int

    @property
    def key(self) -> str:
        """What tells it from every other."""
        return "/".join(map(str, asdict(self).values()))


def trials(first_seed: int, seeds: int) -> Iterator[Trial]:
    """Every trial, a seed at a time: 24 in a part, 48 always, 8 without."""
    for seed in range(first_seed, first_seed + seeds):
        for motion in motions():
            yield from (Trial("part", motion, name, strength, seed) for name in PARTLY for strength in STRENGTHS)
            yield from (Trial("always", motion, name, strength, seed) for name in ALWAYS for strength in STRENGTHS)
            yield from (Trial("null", motion, colour, 0.0, seed) for colour in ("white", *COLOURS))


def run(trial: Trial, policy: Policy = STANDARD) -> Row:
    """Make the recording, diagnose it against its iron and without it, and tell what came out."""
    recording, quiet, window, field = made(trial)
    model = ModelSpec.model_validate({"effects": BASE, "field": {"enu_nT": field.tolist()}})
    begun = time.perf_counter()
    found = diagnose(recording, model, policy=policy)
    row = {
        **asdict(trial), "key": trial.key, "window": window, "verdict": found.verdict, "sentence": found.sentence,
        "seconds": time.perf_counter() - begun, "explained": found.gap.explained,
        "names": [(one.name, list(one.alternatives), one.kind, one.effect.active_s) for one in found.named],
    }  # fmt: skip
    if trial.kind == "part":
        bare = ModelSpec.model_validate({"field": {"enu_nT": field.tolist()}})
        loud, clean = (diagnose(one, bare, fitted_base=True, policy=policy) for one in (recording, quiet))
        row["iron"] = iron_off(loud, clean)
    return row


def made(trial: Trial) -> tuple[Recording, Recording, Window | None, Array]:
    """The recording, the same without what is hidden, the window, and the field (east, north, up)."""
    recording, state, field = flown(trial.motion)
    window, tables = None, dict[str, Any]()
    felt = state
    if trial.kind == "part":
        begin = float(np.random.default_rng([trial.seed, 23]).uniform(0.0, 1 - SHARE))
        window = (begin * float(state.time_s[-1]), (begin + SHARE) * float(state.time_s[-1]))
    if trial.kind != "null":
        felt = felt_by(trial.hidden, state)
        draw = HIDDEN.get(trial.hidden) or DIRECT[trial.hidden]
        table = draw(np.random.default_rng([trial.seed, 7]), state)
        tables = {trial.hidden: _windowed(_scaled(trial, table, window, felt), window)}
    if trial.hidden == "flicker":
        tables = tables | FLICKER
    loud, clean = (Chain(_chain(some), trial.seed).apply(felt)[0] for some in (tables, {}))
    return _coloured(replace(recording, mag_nT=loud), trial), replace(recording, mag_nT=clean), window, field


def _coloured(recording: Recording, trial: Trial) -> Recording:
    if trial.hidden == "jitter":
        return replace(recording, mag_nT=jittered(recording, recording.mag_nT, trial.seed))
    return turned(recording, trial.seed) if trial.hidden == "attitude" else recording


def _chain(tables: dict[str, Any], *, noise: bool = True) -> tuple[Effect, ...]:
    """The base with what is hidden."""
    everything = {name: table for name, table in BASE.items() if noise or name != "white_noise"}
    for name, table in tables.items():
        mine = table if isinstance(table, list) else [table]
        everything[name] = [BASE[name], *mine] if name in BASE else table
    return effect_table.build(everything, None, "truth")


def _windowed(table: Any, window: Window | None) -> Any:
    if window is None:
        return table
    return [_windowed(one, window) for one in table] if isinstance(table, list) else {**table, "active_s": [*window]}


def _scaled(trial: Trial, table: Any, window: Window | None, state: State) -> Any:
    """The table at the trial's strength in the window, by secant steps."""
    low, high = window or (-np.inf, np.inf)
    inside = (state.time_s >= low) & (state.time_s < high)
    factor, base = 1.0, apply_deterministic(_chain({}, noise=False), state)[0]
    design = np.column_stack([base / 5e4, np.ones(len(base))])
    for _ in range(4):
        tables = {trial.hidden: _windowed(_times(trial.hidden, table, factor), window)}
        added = apply_deterministic(_chain(tables, noise=False), state)[0] - base
        left = (added - design @ np.linalg.lstsq(design, added, rcond=None)[0])[inside]
        factor *= trial.strength * NOISE_NT / max(float(np.sqrt((left**2).mean())), 1e-12)
    return _times(trial.hidden, table, factor)


def _times(name: str, table: Any, factor: float) -> Any:
    if isinstance(table, list):
        return [_times(name, one, factor) for one in table]
    powers = dict.fromkeys(effect_table.BY_NAME[name].linear, 1.0) | POWER
    scaled = {key: (np.array(table[key]) * factor ** powers[key]).tolist() for key in table if key in powers}
    return {**table, **scaled}


def iron_off(found: Diagnosis, clean: Diagnosis) -> float:
    """Largest difference of the written hard and soft iron to the clean run's, in half widths of its 95 % intervals."""
    design = np.column_stack([clean.problem.state.field_nT, np.ones(len(clean.problem.state))])
    std = np.sqrt(np.diag(np.linalg.inv(design.T @ design)))[:, None] * clean.problem.sigma_nT
    return float((np.abs(_iron(found) - _iron(clean)) / (NORMAL_95 * std)).max())


def _iron(found: Diagnosis) -> Array:
    """Matrix and offset (4, 3) that the new model gives all through the run."""
    always = [effect for effect in found.model.chain() if effect.active_s is None]
    matrix = sum((np.array(one.matrix).T for one in always if isinstance(one, SoftIron)), np.zeros((3, 3)))
    offset = sum((np.array(one.offset_nT) for one in always if isinstance(one, HardIron)), np.zeros(3))
    return np.vstack([matrix, offset])


def f1(found: Window | None, true: Window) -> float:
    """F1 of the time in a window; a name without one is of the whole run."""
    if found is None:
        return 0.0
    both = max(0.0, min(found[1], true[1]) - max(found[0], true[0]))
    return 2 * both / (found[1] - found[0] + true[1] - true[0])


def figures(rows: Sequence[Row]) -> dict[str, Any]:
    """What the bar asks: intervals of effects in a part of the run, and none of the others."""
    part, always, null = ([row for row in rows if row["kind"] == kind] for kind in ("part", "always", "null"))
    return {
        "part": _part_figures(part) if part else {"runs": 0},
        "always": {"runs": len(always), "with_interval": sum(_has_window(row) for row in always)},
        "null": {"runs": len(null), "with_interval": sum(_has_window(row) for row in null)},
    }


def _part_figures(rows: Sequence[Row]) -> dict[str, Any]:
    scores = [_score(row) for row in rows]
    return {
        "runs": len(rows),
        "named": float(np.mean([_hit(row) for row in rows])),
        "f1_at_least_0.9": float(np.mean([score >= 0.9 for score in scores])),
        "f1_least": min(scores),
        "iron_within": float(np.mean([row["iron"] <= 1.0 for row in rows])),
        "extra_names": float(np.mean([max(0, len(row["names"]) - 1) for row in rows])),
    }


def _hit(row: Row) -> bool:
    return any(row["hidden"] in (name, *others) for name, others, _, _ in row["names"])


def _score(row: Row) -> float:
    """The best F1 of the effects that are named."""
    return max((f1(window, row["window"]) for _, _, _, window in row["names"]), default=0.0)


def _has_window(row: Row) -> bool:
    return any(window is not None for _, _, _, window in row["names"])


def main() -> None:
    """Run the trials that are not in the log yet, and report."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.diagnosis.partly")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--tuning", action="store_true", help="the tuning seeds instead of the scoring ones")
    parser.add_argument("--only", default="part,always,null", help="kinds of trials")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a number of the policy")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/partly-bench"))
    given = parser.parse_args()
    out = given.out.joinpath(*sorted(given.set))
    first = TUNED if given.tuning else SCORED
    wanted = [one for one in trials(first, given.seeds) if one.kind in given.only.split(",")]
    run_it = partial(run, policy=changed(STANDARD, given.set))
    rows = resumed(wanted, out, run_it, attrgetter("key"), given.jobs)
    print(json.dumps(figures(rows), indent=1))


if __name__ == "__main__":
    main()
