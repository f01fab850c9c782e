"""The closed loop against the bare step limit: `mujoco.rollout` with the same model and step, open loop."""

from __future__ import annotations

import mujoco
import numpy as np
from mujoco import rollout

from benchmarks.measure import Call, Row, paired_ratio
from scenarios.load import load
from scenarios.spec import Scenario
from sim.motion import drive
from sim.vehicles import vehicle_for
from sim.vehicles.base import STEP_S

LEAST_RATIO = 0.85
CASES = ("auv-spiral", "auv-comb", "quad-spiral", "quad-comb")


def rows() -> list[Row]:
    """A row a vehicle and path."""
    return [_row(name) for name in CASES]


def _row(name: str) -> Row:
    scenario = load(name)
    steps = _steps(scenario)
    ratio, bare, loop = paired_ratio(
        bare_steps(scenario, steps), lambda: sum(len(m.time_s) for m in drive_all(scenario))
    )
    note = f"{steps} steps: bare {1e6 * bare / steps:.2f} us, loop {1e6 * loop / steps:.2f} us a step"
    return Row(f"closed loop / bare step limit, {name}", ratio, LEAST_RATIO, True, note)


def drive_all(scenario: Scenario) -> list[object]:
    """The whole motion."""
    return list(drive(scenario, np.random.default_rng(0)))  # type: ignore[return-value]


def _steps(scenario: Scenario) -> int:
    return sum(round(phase.duration_s / STEP_S) for phase in scenario.phases)


def bare_steps(scenario: Scenario, steps: int) -> Call:
    """The same number of steps of the same model from the same start, without control, log or added mass."""
    vehicle = vehicle_for(scenario.vehicle)
    model = vehicle.model()
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    whole = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros(mujoco.mj_stateSize(model, whole))
    mujoco.mj_getState(model, data, state, whole)
    control = np.broadcast_to(data.ctrl, (steps, model.nu)).copy()
    return lambda: rollout.rollout(model, data, state, control)
