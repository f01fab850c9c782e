"""Drives a vehicle through a scenario's phases and yields its true motion, block by block."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from scenarios.errors import InputError
from scenarios.paths.base import PhaseBase, Start
from scenarios.spec import Scenario
from sim.engine import advance, buffers_of, mass_matrix
from sim.rotation import matrix_from_q
from sim.state import Array
from sim.vehicles import vehicle_for
from sim.vehicles.base import STEP_S, Kinematics, Vehicle

BLOCK_STEPS = 20_000
"""Physics steps a block: large enough to amortise numpy, small enough that memory stays flat."""


@dataclass(frozen=True)
class Motion:
    """True motion at the n sample times of a block; all of one phase.

    time_s (n,); kinematics of the body frame; R_wb (n, 3, 3); current_A (n, m); reference (n, 18), what guidance
    followed; phase: its index in the scenario; phase_time_s (n,) since the phase began.
    """

    time_s: Array
    kinematics: Kinematics
    R_wb: Array
    current_A: Array
    reference: Array
    phase: int
    phase_time_s: Array


@dataclass
class Loop:
    """One vehicle in the engine: model, data and everything that lives from block to block."""

    vehicle: Vehicle
    every: int
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
        self.buffers = buffers_of(self.model, self.data, self.model.body(self.vehicle.body).id)
        self.added = np.ascontiguousarray(self.vehicle.added_mass(self.model))
        self.share = self._share()
        self.memory = np.zeros(self.vehicle.memory_size)
        self.flow_memory: dict[str, Any] = {}

    def _share(self) -> Array:
        """(M + M_A)^-1 in the body frame, from the engine's own mass matrix at the identity attitude."""
        if not self.added.size:
            return self.added
        return np.asarray(np.linalg.inv(mass_matrix(self.model) + self.added), dtype=np.float64)

    def start(self) -> Start:
        """The state that the next phase begins from."""
        rows = np.concatenate([self.data.qpos, self.data.qvel, self.data.ctrl, np.zeros(self.model.nv)])[None]
        now = self.vehicle.kinematics(self.model, rows)
        forward = matrix_from_q(now.q)[0, :, 0]
        x, y, z = now.pos_enu_m[0]
        return Start((x, y, z), float(np.arctan2(forward[1], forward[0])), float(np.hypot(*now.velocity_m_s[0, :2])))

    def run(self, reference: Array, gains: Array, stop: Array) -> tuple[Array, int]:
        """Advance over the reference rows; the log's filled rows and the number of steps taken."""
        rows = np.empty((-(-len(reference) // self.every), self.model.nq + 2 * self.model.nv + self.model.nu))
        flow = self.vehicle.flow(len(reference), self.rng, self.flow_memory)
        done = advance(
            *(self.vehicle.control, self.model._address, self.data._address, STEP_S, self.buffers),
            *(self.added, self.share, reference, flow, gains, self.memory, stop, self.every, rows),
        )
        self.steps += done
        return rows[: -(-done // self.every)], done

    @property
    def lost(self) -> bool:
        """Whether the state is not finite, or the engine found it so on the way."""
        return not np.isfinite(self.data.qpos).all() or bool(np.any(self.data.warning.number))


def drive(scenario: Scenario, rng: np.random.Generator) -> Iterator[Motion]:
    """True motion of the scenario's vehicle through its phases, at the sensors' sample times.

    Raises InputError where the vehicle does not reach the end of an unpowered phase, or its state is not finite.
    """
    every = round(1.0 / (scenario.sampling.rate_hz * STEP_S))
    loop = Loop(vehicle_for(scenario.vehicle), every, rng)
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
        rows, done = loop.run(reference, gains, stop)
        if loop.lost:
            what = f"the simulated vehicle left its envelope before {STEP_S * loop.steps:g} s"
            do = "ask for a gentler motion, wind or current"
            raise InputError(what, where=f"phases.{index} ({phase.kind})", do=do)
        if len(rows):
            yield _motion(loop, rows, reference[:: loop.every], begin, index, t_s[:: loop.every])
        first += done
        if done < len(t_s):
            return
    if stop[1]:
        depth = f"{phase.end_depth_m:g} m"
        raise InputError(
            f"the vehicle did not reach {depth} in max_duration_s = {phase.duration_s:g} s",
            where=f"phases.{index} ({phase.kind})",
            do="raise max_duration_s or the net weight",
        )


def _stop(phase: PhaseBase, start: Start) -> Array:
    """(z, sign) for the engine: where an unpowered phase ends; sign 0: by time alone."""
    if phase.end_depth_m is None:
        return np.zeros(2)
    z = -phase.end_depth_m
    return np.array([z, 1.0 if z > start.pos_enu_m[2] else -1.0])


def _motion(loop: Loop, rows: Array, reference: Array, begin: int, phase: int, phase_time_s: Array) -> Motion:
    n, model = len(rows), loop.model
    time_s: Array = STEP_S * (begin + loop.every * np.arange(n, dtype=np.float64))
    kinematics = loop.vehicle.kinematics(model, rows)
    ctrl = rows[:, model.nq + model.nv : model.nq + model.nv + model.nu]
    currents = loop.vehicle.currents_A(ctrl)
    return Motion(time_s, kinematics, matrix_from_q(kinematics.q), currents, reference[:n], phase, phase_time_s[:n])
