"""Scenarios flown in the engine: true motion as the state that a paper's errors act on, and the measured attitude."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from papers.attitudes import state_at_attitudes
from recordings import Recording
from recordings.assemble import recording_of
from sim.effects import Effects
from sim.scenario import Scenario, load
from sim.simulation import blocks, plan, true_motion
from sim.state import State


@dataclass(frozen=True, eq=False)
class FlownRun:
    """A run without magnetic errors: true state, and what gyro and navigation measured."""

    state: State
    measured: Recording


def bare(name: str, overrides: Sequence[str] = (), **parts: Any) -> Scenario:
    """Return a scenario of the catalogue without magnetic errors, with overrides and other parts (field, phases)."""
    return load(name, list(overrides)).model_copy(update={"effects": Effects({}), **parts})


def flight(scenario: Scenario, seed: int) -> FlownRun:
    """Return a flight; the seed draws gusts and instruments."""
    ready = plan(scenario, 0, seed)
    motions = list(true_motion(ready))
    pieces = list(blocks(ready, motions))
    state = state_at_attitudes(np.concatenate([m.R_wb for m in motions]), ready.field_enu_nT, ready.interval_s)
    rate = np.concatenate([m.kinematics.rate_rad_s for m in motions])
    position = np.concatenate([m.kinematics.pos_enu_m for m in motions])
    moving = replace(
        state,
        time_s=np.concatenate([m.time_s for m in motions]),
        pos_enu_m=position,
        rate_rad_s=rate,
        field_rate_nT_s=-np.cross(rate, state.field_nT),
    )
    return FlownRun(
        moving, recording_of({name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]})
    )
