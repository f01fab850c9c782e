"""The closed loop against the bare step limit: `mujoco.rollout` with the same model and step, open loop."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import mujoco
import numpy as np
from mujoco import rollout

from benchmarks.measure import Call, Row, paired_ratio
from scenarios.arrays import Array
from sim.engine import Stop
from sim.motion import Loop, Motion, drive
from sim.scenario import Scenario, load
from sim.vehicles import vehicle_for
from sim.vehicles.base import STEP_S

LEAST_RATIO = 0.95
CASES = ("auv-spiral", "auv-comb", "quad-spiral", "quad-comb")
SMALL = ("auv-spiral", ("phases.0.duration_s=60",))
"""A motion of a few seconds, with which a test runs the benchmark."""


def rows(small: bool = False) -> list[Row]:
    """Return a row for each vehicle and path."""
    return [_row(*SMALL)] if small else [_row(name) for name in CASES]


def _row(name: str, changes: tuple[str, ...] = ()) -> Row:
    scenario = load(name, changes)
    control = commands(scenario)
    ratio, bare, loop = paired_ratio(bare_steps(scenario, control), lambda: deque(motion(scenario), maxlen=0))
    note = (
        f"{len(control)} steps: bare {1e6 * bare / len(control):.2f} us, loop {1e6 * loop / len(control):.2f} us a step"
    )
    return Row(f"closed loop / bare step limit, {name}", ratio, LEAST_RATIO, True, note)


def motion(scenario: Scenario) -> Iterator[Motion]:
    """The whole motion, as the simulator makes it."""
    return drive(scenario, np.random.default_rng(0))


def commands(scenario: Scenario) -> Array:
    """Actuator commands (n, nu) of every step of the scenario's closed loop, so that the bare steps move likewise."""
    loop = Loop(vehicle_for(scenario.vehicle), 1, 1, np.random.default_rng(0))
    rows = []
    for phase in scenario.phases:
        t_s = STEP_S * np.arange(round(phase.duration_s / STEP_S), dtype=np.float64)
        reference = np.ascontiguousarray(phase.reference(loop.start(), t_s))
        rows.append(loop.run(reference, loop.vehicle.gains(loop.model, phase), Stop())[0].ctrl)
    return np.concatenate(rows)


def bare_steps(scenario: Scenario, control: Array) -> Call:
    """Open-loop steps of the same model from the same start under the same commands: no control, log or added mass."""
    vehicle = vehicle_for(scenario.vehicle)
    model = vehicle.model()
    data = mujoco.MjData(model)
    vehicle.place(model, data)
    model.opt.wind[:] = vehicle.flow(1, np.random.default_rng(0), {})[0]
    whole = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros(mujoco.mj_stateSize(model, whole))
    mujoco.mj_getState(model, data, state, whole)
    return lambda: rollout.rollout(model, data, state, control)
