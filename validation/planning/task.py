"""What is asked of a planned motion: the sensor and field it is for, what a method is told, and the goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from scenarios.errors import InputError
from scenarios.paths import PhaseBase
from scenarios.toml import as_dict
from sim.rotation import matrix_from_q
from sim.scenario import Scenario
from sim.simulate import flown, plan
from sim.vehicles import VEHICLES
from validation.bound.experiment import Experiment
from validation.bound.files import scenario_experiment
from validation.bound.goal import OFFSET, Goal
from validation.bound.information import SAMPLE
from validation.bound.limit import Tilts, sample_rows
from validation.planning.manoeuvre import Leg, Manoeuvre, manoeuvre_of

Array = NDArray[np.float64]
PROBE_S = 200.0
"""Simulated at rest to see sensor and noise: two thousand samples at 10 Hz tell the noise to a percent."""
BEST = {"norm": "ml_geometric", "vector": "vector_least_squares"}
"""A calibrator that comes near the bound, by what it is told."""


@dataclass(frozen=True, eq=False)
class Task:
    """What is planned for.

    base : the scenario whose phases are to be found; known : its field, sensor and noise; before : information (k, k)
    that there is already, None for none
    """

    base: Scenario
    known: Experiment
    knowledge: str
    tilts: Tilts
    goal: Goal
    manoeuvre: Manoeuvre
    before: Array | None = None

    @classmethod
    def of(
        cls,
        vehicle: str,
        like: Scenario,
        knowledge: str = "norm",
        *,
        tilts: Tilts | None = None,
        goal: Goal = OFFSET,
        noise_std_nT: float | None = None,
    ) -> Task:
        """For a vehicle with field, sensors and errors of a scenario; tilts: default the vehicle's.

        Raises InputError for knowledge that depends on the samples' order, and what the vehicle cannot give or do.
        """
        if knowledge not in SAMPLE:
            do = f"plan with --knowledge {' or '.join(SAMPLE)}"
            raise InputError(f"what {knowledge} tells depends on the order of the samples", where="--knowledge", do=do)
        rest = manoeuvre_of(vehicle).phase([Leg(0.0, 0.0, 0.0, 1.0)])
        base = based(vehicle, like, [rest], BEST[knowledge])
        first = next(iter(flown(plan(base)))).kinematics.q[:1]
        yaw_deg = float(np.degrees(np.arctan2(*matrix_from_q(first)[0, [1, 0], 0])))
        manoeuvre = manoeuvre_of(vehicle, round(yaw_deg, 3))
        known = scenario_experiment(_resting(base), noise_std_nT)
        return cls(base, known, knowledge, tilts or Tilts(*VEHICLES[vehicle].tilts_deg), goal, manoeuvre)

    @property
    def interval_s(self) -> float:
        """Time between samples."""
        return 1.0 / self.base.sampling.rate_hz

    @property
    def wanted(self) -> Array:
        """B (k, q) of the goal."""
        return self.goal.factor(self.known, self.knowledge)

    def rows(self, attitudes: Rotation) -> Array:
        """What a sample at each attitude tells, (m, r, k)."""
        return sample_rows(self.known, self.knowledge, attitudes)

    def information(self, phase: PhaseBase, from_s: float, to_s: float) -> Array:
        """Information (k, k) of the samples between two times of a phase, as the manoeuvre is meant."""
        rows = self.rows(self.manoeuvre.attitudes(phase, from_s, to_s, self.interval_s))
        flat = rows.reshape(-1, rows.shape[2])
        return np.asarray(flat.T @ flat)

    def scenario(self, phase: PhaseBase, name: str, summary: str) -> Scenario:
        """The scenario that flies a phase."""
        return _validated(as_dict(self.base) | {"phases": [_table(phase)], "name": name, "summary": summary})

    def after(self, information: Array) -> Task:
        """The same with information that there is already."""
        return replace(self, before=information)


def based(vehicle: str, like: Scenario, phases: Sequence[PhaseBase], calibrator: str) -> Scenario:
    """A scenario with a vehicle and phases, and all else of another; its vehicle too, where it is of the same kind."""
    said = as_dict(like)
    table = said["vehicle"] if said["vehicle"]["kind"] == vehicle else {"kind": vehicle}
    vary = {key: how for key, how in said.get("vary", {}).items() if key.split(".")[0] not in ("phases", "vehicle")}
    changed = {"vehicle": table, "phases": [_table(one) for one in phases], "vary": vary, "calibrators": [calibrator]}
    return _validated(said | changed)


def _resting(base: Scenario) -> Scenario:
    """The base long enough to see the sensor's noise."""
    phase = base.phases[0]
    return _validated(as_dict(base) | {"phases": [_table(phase)] * ceil(PROBE_S / phase.duration_s)})


def _table(phase: PhaseBase) -> dict[str, Any]:
    return phase.model_dump(mode="json", by_alias=True, exclude_none=True, exclude_defaults=True) | {"kind": phase.kind}


def _validated(said: dict[str, Any]) -> Scenario:
    return Scenario.model_validate(said)
