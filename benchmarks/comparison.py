"""The comparison that is measured, and the physics that its trials share."""

from __future__ import annotations

from benchmarks.measure import Row, cpu_s
from sim.scenario import Scenario, load
from sim.simulation import plan, true_motion
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design
from validation.comparison.trial import run_trial

MOST_PHYSICS = 0.10
TRIALS, PROCESSES = 200, 2
"""The comparison that the share is of."""
TWELVE = (
    *("sphere", "ellipsoid", "vector_least_squares", "ellipsoid_segmented", "twostep", "ml_newton"),
    *("pso", "ga", "psoga", "kalman", "ukf", "vector_lm"),
)


def spiral() -> Scenario:
    """Twenty minutes of an AUV's circles at 10 Hz."""
    return load("auv-spiral", ["phases.0.duration_s=1200"])


def short_spiral() -> Scenario:
    """The same motion for a minute, with which a test runs the benchmark."""
    return load("auv-spiral", ["phases.0.duration_s=60"])


def rows(small: bool = False) -> list[Row]:
    """Return the row of the physics."""
    return [_physics(Design.of(short_spiral(), select_calibrators(TWELVE[:2]), seed=1) if small else whole_design())]


def whole_design() -> Design:
    """The comparison of twelve calibrators on `spiral`."""
    return Design.of(spiral(), select_calibrators(TWELVE), seed=1)


def _physics(design: Design) -> Row:
    flown_s = cpu_s(lambda: list(true_motion(plan(design.points[0].scenario, 0, 1))))
    run_trial(design, 0, 0)
    trial_s = cpu_s(lambda: run_trial(design, 0, 1))
    share = PROCESSES * flown_s / (TRIALS * trial_s)
    note = f"{TRIALS} trials, {PROCESSES} processes: motion {flown_s:.2f} s once in each, trial {trial_s:.2f} s"
    return Row("comparison: physics / trials", share, MOST_PHYSICS, False, note)
