"""Whole gate runs by the thousand: unchanged calibrators never fail, sabotaged ones always do.

Runs are drawn from a pool of real trials, in which sound and sabotaged calibrators fit the same recordings; every gate
looks at its trials after each of them, as `magbench gate` does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

import calib
from benchmarks.measure import Row
from calib import Calibration, Reference
from recordings import Recording
from scenarios.arrays import Array
from sim.scenario import load
from validation.calibrating.calibrator_entry import CalibratorEntry, TimedCalibration, time_fit
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design
from validation.comparison.engine import Engine, ProcessEngine, SerialEngine, run_trials
from validation.comparison.trial_table import TrialTable
from validation.gates.gate_file import FALSE_FAIL_RATE, Gate
from validation.gates.gate_plan import GatePlan, plan_gate
from validation.gates.power import verdict_probabilities
from validation.gates.sequential import Decision, decide
from validation.signals.amplitude import rms

SCENARIO, CUT, SOUND = "tumble", "phases.0.duration_s=40", "vector_least_squares"
SCORES = ("offset_error_nT", "holdout_sphere_component_rms_nT", "holdout_sphere_norm_rms_nT", "heading_rms_deg")
LIMIT = 1.5
"""Limits of the gates, as multiples of the sound calibrator's medians."""
POOL, PILOT, RUNS = 2000, 20, 1000
SMALL = 5, 3
"""Trials and runs with which a test runs the benchmark."""
CLEAR_TRIALS = 120
FAR_NT = 1e8
JOBS = 2


def transposed(found: Calibration, std_nT: float) -> Calibration:
    """Rows for columns: a mistake of conventions."""
    return replace(found, matrix=found.matrix.T)


def offset_off(found: Calibration, std_nT: float) -> Calibration:
    """The offset three standard deviations of an axis off."""
    return replace(found, offset_nT=found.offset_nT + 3.0 * std_nT * np.array([1.0, 0.0, 0.0]))


def scale_off(found: Calibration, std_nT: float) -> Calibration:
    """All axes half a percent too long."""
    return replace(found, matrix=1.005 * found.matrix)


def best_in_sample(found: Calibration, std_nT: float) -> Calibration:
    """The degenerate minimum of the norm's residual: an offset far away, and a matrix that shrinks all to one point."""
    strength_nT = 50_000.0
    return replace(found, offset_nT=np.array([-FAR_NT, 0.0, 0.0]), matrix=np.eye(3) * strength_nT / FAR_NT)


def axis_ignored(found: Calibration, std_nT: float) -> Calibration:
    """The z axis passes through as it was measured."""
    matrix, offset_nT = found.matrix.copy(), found.offset_nT.copy()
    matrix[2], matrix[:, 2], offset_nT[2] = (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 0.0
    return replace(found, matrix=matrix, offset_nT=offset_nT)


SABOTAGE: dict[str, Callable[[Calibration, float], Calibration]] = {
    change.__name__: change for change in (transposed, offset_off, scale_off, best_in_sample, axis_ignored)
}
"""Each gets the sound answer, and the standard deviation of its offset's error along an axis, nT."""


@dataclass(frozen=True)
class Sabotaged:
    """The sound calibrator with one of SABOTAGE done to its answer."""

    change: str
    std_nT: float

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> TimedCalibration:
        """What the sound one gives, spoilt."""
        return time_fit(lambda: SABOTAGE[self.change](calib.get(SOUND).fit(recording, reference, rng), self.std_nT))


def pool(trials: int, engine: Engine) -> dict[str, dict[str, Array]]:
    """Scores (trials,) of the sound and of every sabotaged calibrator in the same trials: by calibrator and column."""
    scenario, sound = load(SCENARIO, [CUT]), select_calibrators((SOUND,))
    first = _table(Design.of(scenario, sound), PILOT, engine)
    std_nT = rms(first.values("offset_error_nT", SOUND)) / 3.0**0.5
    spoilt = [CalibratorEntry(name, Sabotaged(name, std_nT), attitude_free=False) for name in SABOTAGE]
    table = _table(Design.of(scenario, [*sound, *spoilt]), trials, engine)
    return {name: {score: table.values(score, name) for score in SCORES} for name in (SOUND, *SABOTAGE)}


def _table(design: Design, trials: int, engine: Engine) -> TrialTable:
    return TrialTable.of(design, run_trials(design, range(trials), engine))


def plans(limits: dict[str, float]) -> list[GatePlan]:
    """A gate for each score, as a file of them would be planned."""
    common = {"scenario": SCENARIO, "calibrator": SOUND}
    gates = [Gate(name=score, score=score, limit=limit, **common) for score, limit in limits.items()]
    return [plan_gate(gate, FALSE_FAIL_RATE / len(gates), f"gate.{k}") for k, gate in enumerate(gates)]


def gate_run(scores: dict[str, Array], gates: Sequence[GatePlan], rng: np.random.Generator) -> list[Decision]:
    """One whole run of all gates on trials drawn from the pool: every gate on the same ones, in the same order."""
    drawn = rng.integers(len(next(iter(scores.values()))), size=max(plan.max_trials for plan in gates))
    return [decide(plan.test, scores[plan.gate.score][drawn[: plan.max_trials]] > plan.gate.factor) for plan in gates]


@dataclass(frozen=True)
class Counted:
    """Of many whole runs of gates: the part with a failure, and the most trials that a decided gate took."""

    failed: float
    most_trials: int


def counted(scores: dict[str, Array], gates: Sequence[GatePlan], runs: int, seed: int) -> Counted:
    """Runs of all gates on one calibrator's scores; a run fails when one of its gates does, after so many trials.

    The most trials are those to the first failure of runs that fail, and to the last verdict of those that pass.
    """
    rng = np.random.default_rng(seed)
    failures, most = 0, 0
    for _ in range(runs):
        decisions = gate_run(scores, gates, rng)
        failing = [one.trials for one in decisions if one.verdict == "fail"]
        failures += bool(failing)
        most = max(most, min(failing) if failing else max(one.trials for one in decisions))
    return Counted(failures / runs, most)


def medians(scores: dict[str, Array]) -> dict[str, float]:
    """The middle of each score."""
    return {name: float(np.median(values)) for name, values in scores.items()}


def rows(small: bool = False) -> list[Row]:
    """Return the rows of the whole benchmark, or of a few trials in this process."""
    return measured(*SMALL, SerialEngine()) if small else measured(POOL, RUNS, ProcessEngine(JOBS))


def measured(trials: int, runs: int, engine: Engine) -> list[Row]:
    """Return false failures well within and at the limit, the proof at the limit, and every sabotage."""
    found = pool(trials, engine)
    typical = medians(found[SOUND])
    gates = plans({name: LIMIT * value for name, value in typical.items()})
    sound = counted(found[SOUND], gates, runs, seed=0)
    edge = counted(found[SOUND], plans(typical), runs, seed=1)
    proof = [verdict_probabilities(plan.test, plan.test.allowed, plan.max_trials)[0][-1] for plan in gates]
    note = f"{runs} runs of {len(gates)} gates, drawn from {trials} trials"
    answer = [
        Row("gates: runs of a sound calibrator that fail", sound.failed, FALSE_FAIL_RATE, False, note),
        Row("gates: trials until a sound one passes", sound.most_trials, CLEAR_TRIALS, False, "the longest of them"),
        Row("gates: runs with the median at the limit that fail", edge.failed, FALSE_FAIL_RATE, False, note),
        Row("gates: the same, exactly", float(sum(proof)), FALSE_FAIL_RATE, False, "sum of exact probabilities"),
    ]
    for k, name in enumerate(SABOTAGE, start=2):
        spoilt = counted(found[name], gates, runs, seed=k)
        took = f"within {spoilt.most_trials} trials"
        answer.append(Row(f"gates: runs with sabotage that fail, {name}", spoilt.failed, 1.0, True, took))
    return answer


if __name__ == "__main__":
    for row in rows():
        print(row.text(60))
