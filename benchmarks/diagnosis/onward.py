"""The advised leg: does it, flown in the simulator, leave the true one of two look-alikes alone?

    python -m benchmarks.diagnosis.onward --tuning --seeds 1 -o out/onward-bench
    python -m benchmarks.diagnosis.onward --tuning --drawn 300 -o out/onward-drawn

Motions that tell little (a level spiral, a yawing quadrotor) make classes; where an answer has two effects and a leg
is advised, that leg is flown with the same truth, and its recording is diagnosed anew. Drawn trials are many: a few
minutes of a motion that is drawn anew, with an effect of a drawn size that has look-alikes there. A trial lands in
trials.jsonl as it ends; the same command goes on where it was stopped.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # a trial a core; before numpy is imported
    os.environ.setdefault(_name, "1")

import argparse  # noqa: E402
from collections.abc import Callable, Iterator, Sequence  # noqa: E402
from dataclasses import dataclass, replace  # noqa: E402
from operator import attrgetter  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

import numpy as np  # noqa: E402

from benchmarks.diagnosis.motion import QUIET  # noqa: E402
from benchmarks.diagnosis.resumed import resumed  # noqa: E402
from benchmarks.diagnosis.truth import BASE, times  # noqa: E402
from diagnosis.next_leg.advice import advised, are_equivalent  # noqa: E402
from diagnosis.next_leg.legs import measured_along  # noqa: E402
from diagnosis.problem.formulation import pose  # noqa: E402
from diagnosis.problem.known import Known  # noqa: E402
from diagnosis.result import Diagnosis  # noqa: E402
from diagnosis.workflow import diagnose  # noqa: E402
from recordings import Recording  # noqa: E402
from sim import effects as effect_table  # noqa: E402
from sim.chain import Chain  # noqa: E402
from sim.effects import Effects  # noqa: E402
from sim.scenario import Scenario, load  # noqa: E402
from sim.simulation import plan  # noqa: E402

SCORED, TUNED = 2000, 0
"""First seed of the scoring set, and of the tuning set."""
MOTIONS = ("auv-spiral", "auv-comb", "quad-spiral")
"""Of the catalogue, level for the most part."""
Row = dict[str, Any]
Draw = Callable[[np.random.Generator], dict[str, Any]]


def _vector(rng: np.random.Generator, size: float) -> list[float]:
    return list(size * rng.normal(size=3))


def _window(rng: np.random.Generator) -> list[float]:
    """A minute and a half, somewhere in the first six minutes."""
    begin = float(rng.uniform(60.0, 270.0))
    return [begin, begin + 90.0]


def _body(rng: np.random.Generator) -> dict[str, Any]:
    """A body some way beside where the vehicle begins, and below."""
    angle, way_m = rng.uniform(0.0, 2 * np.pi), rng.uniform(40.0, 70.0)
    place = [way_m * np.cos(angle), way_m * np.sin(angle), -rng.uniform(20.0, 40.0)]
    return {"position_enu_m": place, "moment_A_m2": _vector(rng, 5e3)}


def _gradient(rng: np.random.Generator) -> dict[str, Any]:
    g = rng.normal(size=(3, 3))
    g = g + g.T
    return {"gradient_nT_m": (0.1 * (g - np.eye(3) * np.trace(g) / 3)).tolist()}


HIDDEN: dict[str, Draw] = {
    "eddy_current": lambda rng: {"matrix_s": (0.002 * (np.eye(3) + 0.2 * rng.normal(size=(3, 3)))).tolist()},
    "latency": lambda rng: {"delay_s": float(rng.uniform(0.005, 0.03))},
    "temperature_offset": lambda rng: {"slope_nT_K": _vector(rng, 2.0)},
    "hard_iron_drift": lambda rng: {"rate_nT_h": _vector(rng, 60.0)},
    "attitude_misalignment": lambda rng: {"angles_deg": _vector(rng, 0.2)},
    "motor_current": lambda rng: {"gain_nT_A": _vector(rng, 5.0)},
    "nonlinearity": lambda rng: {"second_order": _vector(rng, 3e-4)},
    "regional_field": lambda rng: {"error_enu_nT": _vector(rng, 100.0)},
    "hard_iron": lambda rng: {"offset_nT": _vector(rng, 10.0)},
    "soft_iron": lambda rng: {"matrix": (2e-4 * rng.normal(size=(3, 3))).tolist()},
    "misalignment": lambda rng: {"angles_deg": _vector(rng, 0.03)},
    "local_dipole": _body,
    "field_gradient": _gradient,
    "temperature_offset in a part": lambda rng: {"slope_nT_K": _vector(rng, 0.5), "active_s": _window(rng)},
    "motor_current in a part": lambda rng: {"gain_nT_A": _vector(rng, 3.0), "active_s": _window(rng)},
    "hard_iron in a part": lambda rng: {"offset_nT": _vector(rng, 5.0), "active_s": _window(rng)},
}
"""Physical sizes, whatever the motion shows of them, by the effect's name and when it acts."""


def _turning(rng: np.random.Generator, slowest: float, fastest: float) -> str:
    """A rate of turn to either side."""
    return f"turn_rate_deg_s={rng.choice((-1, 1)) * rng.uniform(slowest, fastest):.2f}"


def _circles(rng: np.random.Generator) -> tuple[str, list[str]]:
    level = ["phases.0.vertical_speed_m_s=0", "phases.0.duration_s=400", "sampling.rate_hz=5"]
    return "auv-spiral", [f"phases.0.radius_m={rng.uniform(15, 40):.1f}", f"phases.0.{_turning(rng, 1, 3)}", *level]


def _quick_circles(rng: np.random.Generator) -> tuple[str, list[str]]:
    level = ["phases.0.vertical_speed_m_s=0", "phases.0.duration_s=200", "sampling.rate_hz=10"]
    return "quad-spiral", [f"phases.0.radius_m={rng.uniform(15, 30):.1f}", f"phases.0.{_turning(rng, 6, 12)}", *level]


def _yaw(rng: np.random.Generator) -> tuple[str, list[str]]:
    level = [f"phases.1.tilt_amplitude_deg={rng.uniform(0, 3):.1f}", "phases.1.duration_s=150", "sampling.rate_hz=10"]
    return "quad-calibration", [f"phases.1.{_turning(rng, 6, 30)}", *level]


def _lines(rng: np.random.Generator) -> tuple[str, list[str]]:
    length = f"phases.0.line_length_m={rng.uniform(40, 80):.1f}"
    return "auv-comb", [length, f"phases.0.lines={rng.integers(2, 5)}", "sampling.rate_hz=5"]


DRAWN: dict[str, Callable[[np.random.Generator], tuple[str, list[str]]]] = {
    "circles": _circles,
    "quick-circles": _quick_circles,
    "yaw": _yaw,
    "lines": _lines,
}
"""Short motions at few samples a second: (rng) -> a scenario of the catalogue, and what is changed of it."""
ALIKE = (
    *(("circles", name) for name in ("eddy_current", "nonlinearity", "temperature_offset", "field_gradient")),
    *(("circles", name) for name in ("local_dipole", "regional_field")),
    *(("quick-circles", name) for name in ("hard_iron", "hard_iron_drift", "eddy_current", "field_gradient")),
    *(("yaw", name) for name in ("motor_current", "hard_iron", "eddy_current", "nonlinearity")),
    *(("lines", name) for name in ("hard_iron_drift", "temperature_offset", "nonlinearity")),
)
"""Motions with what has look-alikes on them that another motion tells from it."""
CONSTANT = {"hard_iron", "sensor_offset"}
"""One constant under two names."""
SIZES = (0.3, 2.0)
"""Least and greatest factor on the size of what is hidden in a drawn trial."""


@dataclass(frozen=True)
class Trial:
    """A scenario of the catalogue or a drawn motion, what is hidden, the seed, a factor on its size."""

    motion: str
    hidden: str
    seed: int
    size: float = 1.0

    @property
    def key(self) -> str:
        """What tells it from every other."""
        return f"{self.motion}/{self.hidden}/{self.seed}"

    @property
    def model(self) -> Scenario:
        """The motion with an instrument that has the base's errors."""
        drawing, rng = DRAWN.get(self.motion), np.random.default_rng([self.seed, 6])
        name, changes = drawing(rng) if drawing else (self.motion, [])
        bare: dict[str, Any] = {"vary": {}, "effect_order": None, "effects": Effects(BASE), "sensor": None}
        return load(name, [*QUIET, *changes]).model_copy(update=bare)

    @property
    def table(self) -> dict[str, Any]:
        """The parameters of what is hidden."""
        made = HIDDEN[self.hidden](np.random.default_rng([self.seed, 5]))
        return dict(times(self.effect, made, self.size))

    @property
    def effect(self) -> str:
        """The name of what is hidden."""
        return self.hidden.split()[0]


def trials(first: int, seeds: int) -> Iterator[Trial]:
    """Every effect on every motion, a seed at a time."""
    for seed in range(first, first + seeds):
        for motion in MOTIONS:
            for hidden in HIDDEN:
                yield Trial(motion, hidden, seed)


def drawn(first: int, many: int) -> Iterator[Trial]:
    """A drawn motion with a drawn effect for every seed."""
    for seed in range(first, first + many):
        rng = np.random.default_rng([seed, 8])
        size = float(np.exp(rng.uniform(*np.log(SIZES))))
        yield Trial(*ALIKE[rng.integers(len(ALIKE))], seed, size)


def run(trial: Trial) -> Row:
    """Diagnose, fly what is advised, diagnose again."""
    model, table = trial.model, trial.table
    found = advised(diagnose(_flown(model, trial.effect, table, trial.seed), model))
    row = {"key": trial.key, "hidden": trial.effect, "verdict": found.verdict, "names": _names(found)}
    if found.next_flight is None:
        return row
    at_work = {key: value for key, value in table.items() if key != "active_s"}
    again = diagnose(_flown(found.next_flight.scenario, trial.effect, at_work, trial.seed + 1), model)
    both = {
        "name": found.next_flight.name,
        "other": found.next_flight.other,
        "nats": found.next_flight.nats,
        "leg": found.next_flight.leg,
    }
    return row | both | {"after": again.verdict, "then": _names(again)}


def _flown(scenario: Scenario, name: str, table: dict[str, Any], seed: int) -> Recording:
    """The recording of a flight of an instrument with the base's errors and a hidden one."""
    recording = measured_along(scenario)
    state = pose(recording, Known(plan(scenario, 0, 0).field_enu_nT, 5e4)).state
    truth = {name: [BASE[name], table] if name in BASE else table}
    effects = effect_table.build({**BASE, **truth}, None, "truth")
    return replace(recording, mag_nT=Chain(effects, seed).apply(state)[0])


def _names(found: Diagnosis) -> list[list[str]]:
    return [[one.name, *one.alternatives] for one in found.named]


def asked(row: Row) -> bool:
    """Whether a leg was advised for the name that the truth is or looks like."""
    return bool(row.get("leg")) and any(row["hidden"] in names for names in row["names"] if names[0] == row["name"])


def _count(names: Sequence[str]) -> int:
    """How many causes a class lists: two names that no data tell apart are one."""
    return sum(not any(_is_one(one, other) for other in names[:i]) for i, one in enumerate(names))


def _is_one(one: str, other: str) -> bool:
    return are_equivalent(one, other) or {one, other} == CONSTANT


def split(row: Row) -> bool:
    """Whether the leg left the truth, and neither of the two that it tells apart but the truth."""
    listed = {name for names in row["then"] for name in names}
    return row["hidden"] in listed and not {row["name"], row["other"]} - {row["hidden"]} & listed


def report(rows: Sequence[Row]) -> str:
    """What was advised, and how often it told the two apart; of all classes, and of those of two."""
    every = [row for row in rows if asked(row)]
    two = [row for row in every if any(_count(names) == 2 for names in row["names"] if names[0] == row["name"])]
    lines = [f"{len(rows)} trials, {len(every)} with a leg for a class that holds the truth, {len(two)} of two"]
    lines.append(
        f"told apart by the leg: {sum(map(split, every))} of {len(every)}, {sum(map(split, two))} of {len(two)}"
    )
    lines += [
        f"missed: {row['key']}: {row['leg']}, {row['nats']:.0f} nats: {row['then']}" for row in every if not split(row)
    ]
    return "\n".join(lines)


def main() -> None:
    """Run the trials that are not in the log yet, and report."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.diagnosis.onward")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--drawn", type=int, help="so many drawn trials instead")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--tuning", action="store_true", help="the tuning seeds instead of the scoring ones")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/onward-bench"))
    given = parser.parse_args()
    first = TUNED if given.tuning else SCORED
    wanted = list(drawn(first, given.drawn) if given.drawn else trials(first, given.seeds))
    print(report(resumed(wanted, given.out, run, attrgetter("key"), given.jobs)))


if __name__ == "__main__":
    main()
