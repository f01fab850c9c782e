"""True motion of a vehicle through a scenario's phases, block by block."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.paths.base import PhaseBase, Start
from sim.engine import ReferenceTrack, StateLog, Stop, advance, log_of
from sim.plant import plant_of
from sim.rotation import matrix_from_q
from sim.scenario import Scenario
from sim.vehicles import vehicle_for
from sim.vehicles.base import STEP_S, Kinematics, Vehicle

BLOCK_STEPS = 20_000
"""Physics steps a block: large enough to amortise numpy, small enough to bound the memory."""
KNOWN = 1
"""Initial count of warnings: the engine prints only the first warning of a kind, and writes it to a file."""


@dataclass(frozen=True)
class Motion:
    """True motion at the n sample times of a block; all of one phase.

    time_s (n,); kinematics of the body frame; R_wb (n, 3, 3); current_A (n, m); channels of the vehicle, each (n,);
    reference (n, 18) of the guidance; phase: index in the scenario; phase_time_s (n,) since the start of the phase;
    finer: the motion at every step of the engine, for effects of the field between samples.
    """

    time_s: Array
    kinematics: Kinematics
    R_wb: Array
    current_A: Array
    channels: dict[str, Array]
    reference: Array
    phase: int
    phase_time_s: Array
    finer: Motion | None = None


@dataclass
class Loop:
    """A vehicle in the engine: model, data, and the state kept from block to block.

    every: steps from sample to sample; logged: steps from row to row of the log.
    """

    vehicle: Vehicle
    every: int
    logged: int
    rng: np.random.Generator
    model: Any = field(init=False)
    data: Any = field(init=False)
    steps: int = 0

    def __post_init__(self) -> None:
        self.model = self.vehicle.model()
        # Without this the engine would start again from the initial pose where the state is no longer finite.
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        self.data = mujoco.MjData(self.model)
        self.vehicle.place(self.model, self.data)
        self.data.warning.number[:] = KNOWN
        self.plant = plant_of(self.model, self.data, self.vehicle.body, self.vehicle.added_mass(self.model))
        self.memory = np.zeros(self.vehicle.memory_size)
        self.flow_memory: dict[str, Any] = {}

    def start(self) -> Start:
        """The state at the start of the next phase."""
        state = (self.data.qpos, self.data.qvel, self.data.ctrl, np.zeros(self.model.nv))
        now = self.vehicle.kinematics(self.model, StateLog(*(part[None] for part in state)))
        forward = matrix_from_q(now.q)[0, :, 0]
        x, y, z = now.pos_enu_m[0]
        return Start((x, y, z), math.atan2(forward[1], forward[0]), math.hypot(*now.velocity_m_s[0, :2]))

    def run(self, reference: Array, gains: Array, stop: Stop) -> tuple[StateLog, int]:
        """Advance over the reference rows; return the filled rows of the log and the number of steps."""
        log = log_of(self.model, -(-len(reference) // self.logged))
        flow = self.vehicle.flow(len(reference), self.rng, self.flow_memory)
        course = ReferenceTrack(reference, flow, gains, self.memory, self.logged, stop, self.every)
        done = advance(self.vehicle.control, self.plant, course, log)
        self.steps += done
        return log.first(-(-done // self.logged)), done

    @property
    def lost(self) -> bool:
        """Whether the state is not finite, or the engine has reported a diverged state."""
        return not np.isfinite(self.data.qpos).all() or bool(np.any(self.data.warning.number > KNOWN))


def drive(scenario: Scenario, rng: np.random.Generator, finer: bool = False) -> Iterator[Motion]:
    """True motion of a scenario's vehicle through the phases, at the sensors' sample times; finer: also at every step.

    Raises InputError where the vehicle does not reach the end of an unpowered phase, or the state is not finite.
    """
    every = round(1.0 / (scenario.sampling.rate_hz * STEP_S))
    loop = Loop(vehicle_for(scenario.vehicle), every, 1 if finer else every, rng)
    for index, phase in enumerate(scenario.phases):
        yield from _phase(loop, phase, index)
    if not loop.steps:
        do = "lengthen them, or raise the rate"
        raise InputError("the phases are shorter than a sample", where="sampling.rate_hz", do=do)


def _phase(loop: Loop, phase: PhaseBase, index: int) -> Iterator[Motion]:
    start = loop.start()
    gains = loop.vehicle.gains(loop.model, phase)
    stop = _stop(phase, start)
    # whole sample intervals, so that the sample grid runs on through all phases
    total = round(phase.duration_s / (STEP_S * loop.every)) * loop.every
    block = BLOCK_STEPS // loop.every * loop.every
    first = 0
    while first < total:
        t_s: Array = STEP_S * np.arange(first, min(first + block, total), dtype=np.float64)
        reference = np.ascontiguousarray(phase.reference(start, t_s))
        begin = loop.steps
        log, done = loop.run(reference, gains, stop)
        if loop.lost:
            what = f"the simulated vehicle left its envelope before {STEP_S * loop.steps:g} s"
            do = "ask for a gentler motion, wind or current"
            raise InputError(what, where=f"phases.{index} ({phase.kind})", do=do)
        if done:
            yield _motion(loop, log, reference, begin, index, t_s)
        first += done
        if done < len(t_s):
            return
    if stop.sign:
        depth = f"{phase.end_depth_m:g} m"
        raise InputError(
            f"the vehicle did not reach {depth} in max_duration_s = {phase.duration_s:g} s",
            where=f"phases.{index} ({phase.kind})",
            do="raise max_duration_s or the net weight",
        )


def _stop(phase: PhaseBase, start: Start) -> Stop:
    """End of an unpowered phase; powered phases end by time alone."""
    if phase.end_depth_m is None:
        return Stop()
    z_m = -phase.end_depth_m
    return Stop(z_m, 1.0 if z_m > start.pos_enu_m[2] else -1.0)


def _motion(loop: Loop, log: StateLog, reference: Array, begin: int, phase: int, phase_time_s: Array) -> Motion:
    """Motion of a block from the log; reference and phase_time_s have a row for every step."""

    def rows(every: int, finer: Motion | None = None) -> Motion:
        some = StateLog(*(part[:: every // loop.logged] for part in log))
        n = len(some.qpos)
        time_s: Array = STEP_S * (begin + every * np.arange(n, dtype=np.float64))
        kinematics = loop.vehicle.kinematics(loop.model, some)
        R_wb = matrix_from_q(kinematics.q)
        currents_A, channels = loop.vehicle.currents_A(some.ctrl), loop.vehicle.channels(some)
        followed, since_s = reference[::every][:n], phase_time_s[::every][:n]
        return Motion(time_s, kinematics, R_wb, currents_A, channels, followed, phase, since_s, finer)

    return rows(loop.every, None if loop.logged == loop.every else rows(loop.logged))
