"""Three recordings at once: what transfers, what differs in one of them, and what must not be named.

python -m benchmarks.diagnosis.three --seeds 1 --only differs,null -o out/three
python -m benchmarks.diagnosis.three --short 300 -o out/three-short

Tuning seeds, from 0 on; trials land one by one in a file, and the same command goes on where it was stopped. Short ones
are many: a few minutes of each flight at 10 Hz, drawn for the trial, for the share of wrong names.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.diagnosis.motion import QUIET, SCENARIOS, along, jittered, turned
from benchmarks.diagnosis.outside import OUTSIDE, disturbed
from benchmarks.diagnosis.resumed import resumed
from benchmarks.diagnosis.truth import BASE, EQUIVALENT, FLICKER, HIDDEN, Tables, felt_by, hidden, times
from diagnosis.evidence.localise import TIME
from diagnosis.library.candidates import select_samples
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.formulation import pose_model
from diagnosis.result import Transfer
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.workflow import diagnose_together
from recordings import Recording
from scenarios.arrays import Array
from sim import effects as effect_table
from sim.chain import Chain
from sim.effects import BY_NAME
from sim.scenario import ModelSpec, load
from sim.state import State

FlownLeg = tuple[Recording, State, Array]
"""A motion without errors as it is recorded, the true state along it, and the field (east, north, up)."""
FLIGHTS = {
    "auv": (
        (),
        ("phases.0.turn_rate_deg_s=1.3", "phases.0.roll_period_s=27", "phases.0.pitch_period_s=41", "seed=2"),
        ("phases.0.turn_rate_deg_s=0.8", "phases.0.roll_period_s=37", "phases.0.pitch_amplitude_deg=20", "seed=3"),
    ),
    "quadrotor": (
        (),
        ("phases.1.turn_rate_deg_s=18", "phases.1.tilt_period_s=5", "seed=5"),
        ("phases.1.turn_rate_deg_s=12", "phases.1.tilt_amplitude_deg=17", "seed=6"),
    ),
}
"""What is changed of a vehicle's scenario from flight to flight."""
MORE = 1.3
"""Ratio of the coefficient in the last recording to that in the others, where it differs."""
STRENGTHS = {"same": (0.1, 0.3, 1.0), "differs": (1.0,), "alone": (1.0,), "left-out": (1.0,)}
"""By kind of trial, rms in the first recording over the noise."""
NULLS, COLOURS = 5, ("attitude", "flicker", "jitter", "all")
"""Nulls of each vehicle for one seed of the others, and the colours that come round in further ones."""
WANDERS = ("attitude", "all")
"""Colours with an attitude that wanders."""
TRANSFERS = tuple(name for name in HIDDEN if not BY_NAME[name].traits.one_run)
"""Effects that another recording can show."""
SHORT_S, SHORT_HZ = (90.0, 200.0), 10.0
"""Least and greatest length of a recording of a short trial, and its rate."""
SHORT_TRANSFERS = tuple(name for name in TRANSFERS if BY_NAME[name].traits.max_rate_nT_s is None)
"""Those that minutes show: nature's slow change is a constant error of the field there."""
SHORT_KINDS = ("null", "coloured", "same", "alone", "outside")
"""Kinds that come round in the short trials."""


@dataclass(frozen=True)
class Three:
    """Three recordings of a vehicle: kind of test, what is hidden, at what strength, seed; short: a part of each."""

    kind: str
    vehicle: str
    hidden: str
    strength: float
    seed: int
    short: bool = False

    @property
    def key(self) -> str:
        """What tells it from every other."""
        length = "short" if self.short else "three"
        return f"{length}/{self.kind}/{self.vehicle}/{self.hidden}/{self.strength:g}/{self.seed}"

    def flown(self, i: int) -> FlownLeg:
        """The motion of one of its recordings, without errors."""
        whole = flown_as(self.vehicle, i)
        return _cut(*whole, np.random.default_rng([self.seed, i, 17])) if self.short else whole


def threes(first_seed: int, seeds: int) -> Iterator[Three]:
    """Every trial, a seed at a time."""
    for seed in range(first_seed, first_seed + seeds):
        for vehicle in FLIGHTS:
            for k in range(NULLS):
                yield Three("null", vehicle, "", 0.0, seed * NULLS + k)
            for k, colour in enumerate(COLOURS):
                yield Three("coloured", vehicle, colour, 0.0, seed * len(COLOURS) + k)
            for kind, strengths in STRENGTHS.items():
                for name in TRANSFERS:
                    for strength in strengths:
                        yield Three(kind, vehicle, name, strength, seed)
            for name in OUTSIDE:
                yield Three("outside", vehicle, name, 1.0, seed)


def shorts(many: int) -> Iterator[Three]:
    """Short trials of every kind in turn, what is hidden and how strong drawn for each."""
    for seed in range(many):
        rng = np.random.default_rng([seed, 18])
        kind, vehicle = SHORT_KINDS[seed % len(SHORT_KINDS)], str(rng.choice(sorted(FLIGHTS)))
        hidden = {"null": ("",), "coloured": COLOURS, "outside": tuple(OUTSIDE)}.get(kind, SHORT_TRANSFERS)
        strength = 0.0 if kind in ("null", "coloured") else float(rng.choice(STRENGTHS["same"]))
        yield Three(kind, vehicle, str(rng.choice(hidden)), strength, seed, short=True)


def run_three(trial: Three, policy: Policy = STANDARD) -> dict[str, Any]:
    """Make the recordings, diagnose them together, and tell what came out."""
    made = [flight(trial, i) for i in range(len(FLIGHTS[trial.vehicle]))]
    model = ModelSpec.model_validate({"effects": BASE, "field": {"enu_nT": made[0][1].tolist()}})
    begun = time.perf_counter()
    problems = [pose_model(recording, model, None, None, policy=policy) for recording, _ in made]
    without = frozenset([trial.hidden] if trial.kind == "left-out" else [])
    found = diagnose_together(["first", "second", "third"], problems, model, without=without)
    return {
        **asdict(trial), "key": trial.key, "verdict": found.verdict, "seconds": time.perf_counter() - begun,
        "explained": found.gap.explained, "names": _names(found), "alone": [one.name for one in found.single],
        "own": [(one.verdict, [named.name for named in one.named]) for one in found.each],
    }  # fmt: skip


def _names(found: PooledDiagnosis) -> list[Any]:
    return [
        (
            *(one.name, list(one.named.alternatives), one.named.kind, one.transfer),
            *(None if one.agreement is None else one.agreement.p, one.named.nats, one.named.rivals),
        )
        for one in found.common
    ]


def _cut(recording: Recording, state: State, field: Array, rng: np.random.Generator) -> FlownLeg:
    """A part of a flight at fewer samples a second."""
    every = max(1, round(1 / (SHORT_HZ * state.interval_s)))
    length = min(round(rng.uniform(*SHORT_S) / state.interval_s), len(recording))
    begin = int(rng.integers(len(recording) - length + 1))
    some = slice(begin, begin + length, every)
    return recording.taken(some), replace(select_samples(state, some), interval_s=every * state.interval_s), field


@lru_cache(maxsize=8)
def flown_as(vehicle: str, i: int) -> FlownLeg:
    """One flight of a vehicle without errors, as `motion.along` gives it."""
    name = next(one for one in SCENARIOS if load(one).vehicle.kind == vehicle)
    bare: dict[str, Any] = {"effects": {}, "effect_order": None, "vary": {}}
    return along(load(name, [*QUIET, *FLIGHTS[vehicle][i]]).model_copy(update=bare))


def flight(trial: Three, i: int) -> tuple[Recording, Array]:
    """One of the recordings, and the field (east, north, up)."""
    recording, state, field = trial.flown(i)
    seed = trial.seed * len(FLIGHTS[trial.vehicle]) + i
    tables = _tables(trial, i)
    felt = state
    for name in tables:
        felt = felt_by(name, felt)
    everything = BASE | {name: _beside_base(name, table) for name, table in tables.items()}
    mag_nT = Chain(effect_table.build(everything, None, "truth"), seed).apply(felt)[0]
    recording = replace(recording, mag_nT=mag_nT)
    if trial.kind == "outside":
        recording = disturbed(trial.hidden, trial.strength, trial.seed, recording, state, mag_nT)
    if trial.hidden in ("jitter", "all"):
        recording = replace(recording, mag_nT=jittered(recording, recording.mag_nT, seed))
    return (turned(recording, seed) if trial.hidden in WANDERS else recording), field


def _beside_base(name: str, table: Any) -> Any:
    several = table if isinstance(table, list) else [table]
    return [BASE[name], *several] if name in BASE else table


def _tables(trial: Three, i: int) -> Tables:
    """What is hidden in one recording: of the size that it has in the first, or as the kind says."""
    if trial.kind == "coloured" and trial.hidden in ("flicker", "all"):
        return dict(FLICKER)
    if trial.hidden not in HIDDEN or (trial.kind == "alone" and i < len(FLIGHTS[trial.vehicle]) - 1):
        return {}
    found = hidden(trial.hidden, trial.strength, trial.seed, trial.flown(0)[1])
    more = trial.kind == "differs" and i == len(FLIGHTS[trial.vehicle]) - 1
    return {name: times(name, table, MORE) for name, table in found.items()} if more else found


Row = dict[str, Any]


def figures_of_three(rows: Sequence[Row]) -> dict[str, Any]:
    """Shares of the trials of every kind, and of the wrong names in all."""
    out: dict[str, Any] = {}
    for kind in dict.fromkeys((row["kind"], row["strength"]) for row in rows):
        some = [row for row in rows if (row["kind"], row["strength"]) == kind]
        out[f"three, {kind[0]}" + (f", {kind[1]:g} sigma" if kind[1] else "")] = {
            "runs": len(some),
            "wrong_name": float(np.mean([is_wrong(row) for row in some])),
            **{str(transfer): float(np.mean([_reaches(row, transfer) for row in some])) for transfer in Transfer},
        }
    return out


def is_wrong(row: Row) -> bool:
    """Whether a name stands without what is hidden or a declared equivalent of it among its class."""
    right = rightly_named(row["kind"], row["hidden"])
    return any(not right & {name, *others, *drives} for name, others, *_, drives in row["names"])


def rightly_named(kind: str, hidden: str) -> set[str]:
    """Names that are right: none of what one alone shows; of what is left out of the library what equals it.

    Beside a course that only rises, what drives it is as right as its name.

    Noise in a coloured null, and an error of an attitude that wanders; the iron that the mean of a disturbance from
    outside the library is.
    """
    equal = EQUIVALENT.get(hidden, set())
    if kind == "coloured":
        noise = {effect.name for effect in BY_NAME.values() if effect.stochastic}
        return noise | ({"attitude_misalignment"} if hidden in WANDERS else set())
    drives = set(BY_NAME[hidden].needs or (TIME,)) if hidden in BY_NAME else set()
    return {"null": set(), "alone": set(), "left-out": equal | drives}.get(kind, {hidden, "hard_iron"} | equal | drives)


def _reaches(row: Row, transfer: Transfer) -> bool:
    right = {row["hidden"]} | EQUIVALENT.get(row["hidden"], set())
    return any(right & {name, *others} and how == transfer for name, others, _, how, *_ in row["names"])


def main() -> None:
    """Run the trials that are not in the log yet, and print their figures."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.diagnosis.three")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--only", help="kinds of trials, e.g. differs,null")
    parser.add_argument("--short", type=int, help="so many trials of short recordings instead")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/three"))
    given = parser.parse_args()
    every = shorts(given.short) if given.short else threes(0, given.seeds)
    wanted = [one for one in every if not given.only or one.kind in given.only.split(",")]
    print(json.dumps(figures_of_three(resumed(wanted, given.out, run_three, attrgetter("key"))), indent=1))


if __name__ == "__main__":
    main()
