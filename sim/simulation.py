"""One run of a scenario: motion, field, magnetometers and instruments, block by block."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.channels import HEIGHT, SCALAR, TEMPERATURE, current_name, currents_of
from recordings.columns import (
    ACCEL,
    ATTITUDE,
    GYRO,
    POSITION,
    TRUE_ATTITUDE,
    TRUE_FIELD,
    TRUE_POSITION,
    Column,
    columns,
    effect_names,
    mag_names,
)
from recordings.metadata import run_metadata
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.seeds import stream
from scenarios.toml import as_dict
from scenarios.vary import apply_vary, values_at
from sim import effects as effect_table
from sim.chain import Chain, continuous_part
from sim.effects.base import Effect
from sim.effects.earth import AttitudeMisalignment
from sim.field import earth_field_enu_nT
from sim.instruments import Instruments
from sim.motion import Motion, drive
from sim.rotation import cross, matrix_from_q, q_from_matrix, to_body, to_world
from sim.scalar import ScalarMagnetometer
from sim.scenario import Scenario, SensorSpec, equipped
from sim.state import MOTION, State, missing_channel
from sim.thermal import Thermometer
from sim.vehicles import VEHICLES
from sim.vehicles.base import STEP_S

Block = dict[str, NDArray[Any]]
"""The dataset's columns over a block of samples."""


@dataclass(frozen=True)
class PreparedRun:
    """A scenario ready to run: values of the run drawn, effects of each sensor built.

    scenario: as written; drawn: with the sensors' data sheets written out and the varied values of the run;
    field_enu_nT (3,); effects: a tuple in chain order for each vector magnetometer; scalar: effects of the scalar
    magnetometer, None without.
    """

    scenario: Scenario
    drawn: Scenario
    run: int
    seed: int
    field_enu_nT: Array
    effects: tuple[tuple[Effect, ...], ...]
    scalar: tuple[Effect, ...] | None = None

    @property
    def interval_s(self) -> float:
        """Time between samples."""
        return 1.0 / self.drawn.sampling.rate_hz

    @property
    def finer(self) -> bool:
        """Whether an effect depends on the field between samples, computed at the engine's steps."""
        return any(continuous_part(effects) for effects in (*self.effects, self.scalar or ()))

    @property
    def effects_named(self) -> tuple[str, ...]:
        """Names of all effects of all sensors, each once, in chain order."""
        present = {effect.name for sensor in self.effects for effect in sensor}
        return tuple(name for name in self.drawn.effect_order or effect_table.BY_NAME if name in present)

    @property
    def columns(self) -> tuple[Column, ...]:
        """The columns of the run's file."""
        vehicle = VEHICLES[self.scenario.vehicle.kind]
        own = [Column(name, unit, meaning, "channel") for name, (unit, meaning) in vehicle.own_channels.items()]
        if self.scalar is not None:
            own.append(Column(SCALAR, "nT", "measured strength of the field at the scalar magnetometer", "channel"))
        motors = range(1, vehicle.motors + 1)
        return columns(sensors=len(self.effects), motors=motors, channels=own, effects=self.effects_named)

    @property
    def metadata(self) -> dict[str, Any]:
        """Metadata of the run's file: the scenario, and the true parameters of field and effects."""
        parameters = {
            "field_enu_nT": self.field_enu_nT.tolist(),
            "effects": [effect_table.as_tables(sensor)[0] for sensor in self.effects],
            "effect_order": self.effects_named,
            "navigation": self.drawn.navigation.model_dump(),
            **({} if self.scalar is None else {"scalar": effect_table.as_tables(self.scalar)[0]}),
            "drawn": values_at(self.drawn, equipped(self.scenario).vary),
        }
        return run_metadata(as_dict(self.scenario), self.seed, self.run, parameters)


def plan(scenario: Scenario, run: int = 0, seed: int | None = None) -> PreparedRun:
    """Draw the values that vary from run to run; InputError for an effect on a channel missing from the vehicle."""
    seed = scenario.seed if seed is None else seed
    drawn = apply_vary(equipped(scenario), stream(seed, run, "vary"))
    effects = tuple(drawn.chain(sensor) for sensor in drawn.vectors)
    scalar = None if drawn.scalar is None else drawn.chain(drawn.scalar)
    _check_channels(drawn.vehicle.kind, chain.from_iterable((*effects, scalar or ())))
    return PreparedRun(scenario, drawn, run, seed, earth_field_enu_nT(drawn.field), effects, scalar)


def channels_of(vehicle: str) -> tuple[str, ...]:
    """The channels of a simulation with a kind of vehicle."""
    cls = VEHICLES[vehicle]
    return (TEMPERATURE, *(current_name(motor) for motor in range(1, cls.motors + 1)), *cls.own_channels)


def _check_channels(vehicle: str, effects: Iterable[Effect]) -> None:
    there = dict.fromkeys((*channels_of(vehicle), HEIGHT))
    for effect in effects:
        for name in sorted(set(effect.required_inputs) - MOTION - set(there)):
            problem, place = missing_channel(name, there), f"effects.{effect.name}"
            raise InputError(f"{problem.what}, which the {vehicle} has not", where=place, do=problem.do)


def true_motion(plan: PreparedRun) -> Iterator[Motion]:
    """The run's true motion, block by block, by the simulator's engine."""
    return drive(plan.drawn, stream(plan.seed, plan.run, "flow"), plan.finer)


def blocks(plan: PreparedRun, motions: Iterable[Motion] | None = None) -> Iterator[Block]:
    """The run's columns, block by block: memory does not grow with the run's length.

    motions : true motion of the run if already computed.
    """
    scenario = plan.drawn
    thermometer = Thermometer(scenario.thermal, plan.interval_s)
    instruments = Instruments(scenario.navigation, plan.seed, plan.run, plan.interval_s, _alignment_q(plan.effects[0]))
    magnetometers = _Magnetometers(plan)
    for motion in true_motion(plan) if motions is None else motions:
        temperature = thermometer.temperature_degC(-motion.kinematics.pos_enu_m[:, 2], motion.current_A)
        block = _recorded(scenario, motion, instruments.measure(motion, temperature))
        block |= magnetometers.measure(motion, temperature)
        yield block | _truth(plan, motion)


class _Magnetometers:
    """All magnetometers of a run, with the memory of the run so far."""

    def __init__(self, plan: PreparedRun) -> None:
        self.plan = plan
        self._vectors = [Chain(effects, plan.seed, plan.run, k) for k, effects in enumerate(plan.effects)]
        self._scalar = None if plan.scalar is None else ScalarMagnetometer(plan.scalar, plan.seed, plan.run)

    def measure(self, motion: Motion, temperature_degC: Array) -> Block:
        """Signals over the next block, and the contribution of each effect."""
        scenario, block = self.plan.drawn, Block()
        for k, (effects, sensor) in enumerate(zip(self._vectors, scenario.vectors, strict=True)):
            states = _states(self.plan, motion, scenario.sensors[sensor], temperature_degC)
            block |= _magnetometer(self.plan, effects, *states, k + 1 if len(self._vectors) > 1 else None)
        if self._scalar is not None and scenario.scalar is not None:
            states = _states(self.plan, motion, scenario.sensors[scenario.scalar], temperature_degC)
            block[SCALAR] = self._scalar.measure(*states)
        return block


def _recorded(scenario: Scenario, motion: Motion, measured: dict[str, Array]) -> Block:
    """Measurements of the further instruments."""
    about: Block = {
        "time_s": motion.time_s,
        "phase": np.full(len(motion.time_s), scenario.phases[motion.phase].label),
        TEMPERATURE: measured["temperature_degC"],
    }
    vectors: Block = {}
    for key, group in (
        *(("gyro_rad_s", GYRO), ("accel_m_s2", ACCEL)),
        *(("att_q", ATTITUDE), ("pos_enu_m", POSITION)),
    ):
        vectors |= _columns(group, measured[key])
    return about | vectors | currents_of(measured["current_A"]) | motion.channels


def _magnetometer(plan: PreparedRun, effects: Chain, state: State, finer: State | None, number: int | None) -> Block:
    """Signal of a magnetometer, and the contribution of each effect; number: index from 1 in an array, else None."""
    mag_nT, labels = effects.apply(state, finer)
    block = _columns(mag_names(number), mag_nT)
    for name in plan.effects_named:
        label_nT = labels[name] if name in labels else np.zeros_like(mag_nT)
        block |= _columns(effect_names(name, number), label_nT)
    return block


def _truth(plan: PreparedRun, motion: Motion) -> Block:
    """The undisturbed field in the body, and the true pose."""
    return {
        **_columns(TRUE_FIELD, to_body(motion.R_wb, plan.field_enu_nT[None])),
        **_columns(TRUE_ATTITUDE, motion.kinematics.q),
        **_columns(TRUE_POSITION, motion.kinematics.pos_enu_m),
    }


def _states(
    plan: PreparedRun, motion: Motion, sensor: SensorSpec, temperature_degC: Array
) -> tuple[State, State | None]:
    """State at the position of a magnetometer on the body, at the samples and, if known, on the finer grid.

    The temperature is held from sample to sample.
    """
    state, finer = _state(plan, motion, sensor, temperature_degC), motion.finer
    if finer is None:
        return state, None
    every = round(plan.interval_s / STEP_S)
    held_degC = np.repeat(temperature_degC, every)[: len(finer.time_s)]
    return state, replace(_state(plan, finer, sensor, held_degC), interval_s=STEP_S)


def _state(plan: PreparedRun, motion: Motion, sensor: SensorSpec, temperature_degC: Array) -> State:
    """State at the position of a magnetometer for a motion with the sample interval."""
    k = motion.kinematics
    field = to_body(motion.R_wb, plan.field_enu_nT[None])
    pos_enu_m = k.pos_enu_m + to_world(motion.R_wb, np.array([sensor.position_m]))
    driven = {TEMPERATURE: temperature_degC, HEIGHT: pos_enu_m[:, 2], **currents_of(motion.current_A)}
    return State(
        time_s=motion.time_s,
        interval_s=plan.interval_s,
        pos_enu_m=pos_enu_m,
        R_wb=motion.R_wb,
        rate_rad_s=k.rate_rad_s,
        field_enu_nT=plan.field_enu_nT,
        field_nT=field,
        field_rate_nT_s=-cross(k.rate_rad_s, field),
        channels=driven | motion.channels,
    )


def _alignment_q(effects: tuple[Effect, ...]) -> Array:
    """Navigation's initial alignment error as a quaternion (1, 4): the product of all such effects in the chain."""
    q = np.array([[1.0, 0.0, 0.0, 0.0]])
    for effect in effects:
        if isinstance(effect, AttitudeMisalignment):
            q = q_from_matrix(effect.turn(matrix_from_q(q)))
    return q


def _columns(labels: tuple[str, ...], values: Array) -> Block:
    return dict(zip(labels, values.T, strict=True))
