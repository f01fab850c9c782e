"""Legs for a vehicle, and the measured motion on a leg by the simulator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydantic import ValidationError

from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.motion import motion_of
from recordings import Recording
from recordings.channels import HEIGHT
from scenarios.errors import InputError
from scenarios.toml import as_dict
from sim.chain import apply_deterministic
from sim.effects import Effects
from sim.effects.base import Effect
from sim.memory_run import run_in_memory
from sim.scenario import Model, ModelSpec, Scenario
from sim.simulation import channels_of, plan
from sim.state import MOTION
from sim.vehicles.auv import Auv
from sim.vehicles.turntable import Turntable

Phase = dict[str, Any]
SWAYING: Phase = {"roll_amplitude_deg": 20.0, "pitch_amplitude_deg": 20.0}
QUICK: Phase = {**SWAYING, "roll_period_s": 11.0, "pitch_period_s": 17.0}
SPIRAL: Phase = {"kind": "spiral", "radius_m": 20.0, "turn_rate_deg_s": 2.0, "duration_s": 240.0}
LEGS: tuple[tuple[str, tuple[Phase, ...]], ...] = (
    ("rest", ({"kind": "hover", "duration_s": 240.0},)),
    ("a level spiral to the left, then to the right", (
        SPIRAL | {"duration_s": 180.0}, SPIRAL | {"turn_rate_deg_s": -2.0, "duration_s": 180.0},
    )),
    ("a spiral that sways in roll and pitch", (SPIRAL | SWAYING,)),
    ("a spiral that sways quickly in roll and pitch", (SPIRAL | QUICK | {"turn_rate_deg_s": 3.0},)),
    ("a comb", ({"kind": "comb", "line_length_m": 60.0, "line_spacing_m": 20.0, "lines": 4, "speed_m_s": 1.0},)),
    ("a dive and the way up", (
        {"kind": "descent", "to_depth_m": 200.0, "max_duration_s": 600.0},
        {"kind": "ascent", "to_depth_m": 50.0, "max_duration_s": 600.0},
    )),
    ("turns on the spot that sway slowly", (
        {"kind": "rotate", "duration_s": 240.0, "turn_rate_deg_s": 15.0, "tilt_amplitude_deg": 20.0,
         "tilt_period_s": 8.0},
    )),
    ("turns on the spot at two rates, both ways, that sway quickly", (
        {"kind": "rotate", "duration_s": 120.0, "turn_rate_deg_s": 60.0, "tilt_amplitude_deg": 15.0,
         "tilt_period_s": 2.0},
        {"kind": "rotate", "duration_s": 120.0, "turn_rate_deg_s": -20.0, "tilt_amplitude_deg": 20.0,
         "tilt_period_s": 4.0},
    )),
    ("a slow tumble through all attitudes", ({"kind": "tumble", "duration_s": 240.0},)),
    ("turns about every axis at 60 degrees a second", ({"kind": "turntable_turns", "rate_deg_s": 60.0},)),
    ("stops on the way round", ({"kind": "turntable_stops", "stops": 12, "dwell_s": 10.0},)),
)  # fmt: skip
"""Words and phases of possible legs; a vehicle is offered the feasible ones."""
QUIET = {"attitude_noise_std_deg": 0.0, "position_noise_std_m": 0.0}


@dataclass(frozen=True)
class CandidateLeg:
    """A leg in words, and its scenario."""

    words: str
    scenario: Scenario

    @property
    def duration_s(self) -> float:
        """Duration of the leg."""
        return sum(phase.duration_s for phase in self.scenario.phases)

    def repeated(self, times: int) -> Scenario:
        """The scenario of the leg flown several times."""
        told = {"name": "next", "summary": f"To distinguish: {self.words}"}
        return self.scenario.model_copy(update={"phases": self.scenario.phases * times, **told})

    def problem(self, like: LinearProblem, always: Sequence[Effect]) -> LinearProblem | None:
        """Pose the problem on the motion of the leg, with permanent effects and the noise of a given problem.

        The iron is parametrised as in the given problem: `base` has equal coefficients. None where the vehicle does not
        reach the end of the leg.
        """
        try:
            recording = measured_along(self.scenario)
        except InputError:
            return None
        enu_nT = like.state.field_enu_nT
        state = motion_of(recording, enu_nT, like.policy, None)
        flown = replace(recording, mag_nT=apply_deterministic(always, state)[0])
        posed = pose(flown, Known(enu_nT, float(np.linalg.norm(enu_nT)), like.effects, like.policy))
        return replace(posed, sigma_nT=like.sigma_nT)


def legs_of(model: Model) -> list[CandidateLeg]:
    """The legs that are feasible for the model's vehicle, without the motion just flown."""
    flyable = as_dict(model) | ({} if isinstance(model, Scenario) else _vehicle_for(model))
    flown = [phase.model_dump(exclude_unset=True) for phase in getattr(model, "phases", ())]
    legs = []
    for words, phases in LEGS:
        try:
            scenario = Scenario.model_validate(flyable | {"phases": list(phases)})
        except (ValidationError, InputError):
            continue
        if [phase.model_dump(exclude_unset=True) for phase in scenario.phases] != flown:
            legs.append(CandidateLeg(words, scenario))
    return legs


def _vehicle_for(model: ModelSpec) -> dict[str, Any]:
    """The vehicle for a model without one: a turntable, or one with motors where an effect needs their currents."""
    needed = {name for effect in model.chain() for name in effect.required_inputs} - MOTION
    vehicle = Turntable if needed <= {*channels_of(Turntable.name), HEIGHT} else Auv
    late = {"attitude_delay_s": model.navigation.attitude_delay_s}
    return {"vehicle": {"kind": vehicle.name}, "navigation": late}


def measured_along(scenario: Scenario) -> Recording:
    """The recording of a flight without errors of magnetometer and navigation."""
    bare: dict[str, Any] = {"effects": Effects(), "effect_order": None, "vary": {}, "sensor": None}
    quiet = scenario.navigation.model_copy(update=QUIET)
    return run_in_memory(plan(scenario.model_copy(update={**bare, "navigation": quiet}), 0, 0))[0]
