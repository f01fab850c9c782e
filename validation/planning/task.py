"""Planning task: sensor, field, knowledge of the method, tilts and goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.paths import Ability, PhaseBase
from scenarios.toml import as_dict
from sim.rotation import matrix_from_q
from sim.scenario import Scenario
from sim.simulation import plan, true_motion
from sim.vehicles import VEHICLES
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.files import scenario_experiment
from validation.bound.goal import OFFSET, Goal
from validation.bound.information import SAMPLE
from validation.bound.limit import Tilts, inverse, sample_rows
from validation.planning.manoeuvre import HandHeld, Leg, Manoeuvre, manoeuvre_of

HAND, HAND_DEG_S, HAND_STEP_DEG = "hand", 45.0, 45.0
"""A person as vehicle: name, turning rate, and steps of the attitudes."""
USUAL_S, USUAL_HAND_S = 600.0, 120.0
"""Default times: ten minutes for a vehicle, two for a person."""
PROBE_S = 200.0
"""Time simulated at rest; a scenario without stated white noise is measured there, to one percent at 10 Hz."""
BEST = {"norm": "ml_geometric", "norm+gyro": "gyro_ml", "vector": "vector_least_squares"}
"""A calibrator near the bound for each knowledge."""


@dataclass(frozen=True, eq=False)
class PlanningTask:
    """Task of a plan.

    name : vehicle, or HAND; base : scenario with phases to be found; known : field, sensor and noise of the scenario
    before : information (k, k) from earlier recordings, None without; step_deg : step of attitudes, None for any
    """

    name: str

    base: Scenario
    known: Experiment
    knowledge: str
    tilts: Tilts
    goal: Goal
    manoeuvre: Manoeuvre
    before: Array | None = None
    step_deg: float | None = None

    @classmethod
    def of(
        cls,
        who: str,
        like: Scenario,
        knowledge: str = "norm",
        *,
        tilts: Tilts | None = None,
        goal: Goal = OFFSET,
        noise_std_nT: float | None = None,
    ) -> PlanningTask:
        """Return the task of a vehicle with field, sensors and errors of a scenario; default tilts are the vehicle's.

        noise_std_nT : white noise; None for the scenario's, as stated, or measured where no white noise is stated.
        HAND : a person with the vehicle in the hands, simulated by a turntable; attitudes in steps of HAND_STEP_DEG.

        Raises InputError for unsupported knowledge, and for a vehicle without suitable motion or sensors.
        """
        if knowledge not in BEST:
            do = f"plan with --knowledge {' or '.join(BEST)}"
            raise InputError(f"there are no plans for {knowledge}", where="--knowledge", do=do)
        vehicle = who if who != HAND else next(name for name, one in VEHICLES.items() if Ability.POINT in one.abilities)
        rest = manoeuvre_of(vehicle).phase([Leg(0.0, 0.0, 0.0, 1.0)])
        base = based(vehicle, like, [rest], BEST[knowledge])
        known = scenario_experiment(_resting(base), noise_std_nT)
        yaw_deg = _heading_deg(base)
        if who == HAND:
            shown, all_round = HandHeld(HAND_DEG_S, yaw_deg), tilts or Tilts(180.0, 90.0)
            return cls(who, base, known, knowledge, all_round, goal, shown, step_deg=HAND_STEP_DEG)
        manoeuvre = manoeuvre_of(vehicle, yaw_deg)
        allowed = _allowed(vehicle, manoeuvre, tilts)
        return cls(who, base, known, knowledge, allowed, goal, manoeuvre.within(allowed))

    @property
    def angles_deg(self) -> Array:
        """Return yaw, pitch, roll (m, 3) of the candidate attitudes of legs."""
        return self.tilts.angles_deg(self.step_deg)

    @property
    def linked(self) -> bool:
        """Return whether the order of the samples matters."""
        return self.knowledge not in SAMPLE

    @property
    def usual_s(self) -> float:
        """Return the default time of a plan in s."""
        return USUAL_HAND_S if self.name == HAND else USUAL_S

    @property
    def interval_s(self) -> float:
        """Return the time between samples in s."""
        return 1.0 / self.base.sampling.rate_hz

    @property
    def wanted(self) -> Array:
        """Return B (k, q) of the goal."""
        return self.goal.factor(self.known, self.knowledge)

    def rows(self, attitudes: Rotation) -> Array:
        """Return rows (m, r, k) of a sample at each attitude."""
        return sample_rows(self.known, self.knowledge, attitudes)

    def information(self, phase: PhaseBase, from_s: float, to_s: float) -> Array:
        """Return the information (k, k) of the samples between two times of an intended phase."""
        rows = self.rows(self.manoeuvre.attitudes(phase, from_s, to_s, self.interval_s))
        flat = rows.reshape(-1, rows.shape[2])
        return np.asarray(flat.T @ flat)

    def meant(self, phase: PhaseBase) -> Experiment:
        """Return the experiment of a phase with intended attitudes."""
        attitudes = self.manoeuvre.attitudes(phase, 0.0, phase.duration_s, self.interval_s)
        assert self.known.field_enu_nT is not None
        return replace(
            self.known,
            field_nT=np.asarray(attitudes.inv().apply(self.known.field_enu_nT)),
            turns=np.asarray((attitudes[1:].inv() * attitudes[:-1]).as_matrix()),
            step_s=np.full(len(attitudes) - 1, self.interval_s),
            up=None,
        )

    def phase_information(self, phase: PhaseBase) -> Array:
        """Return the information (k, k) of an intended phase alone."""
        if self.linked:
            return Bound.of(self.meant(phase), self.knowledge).information.matrix
        return self.information(phase, 0.0, phase.duration_s)

    def scenario(self, phases: Sequence[PhaseBase], summary: str) -> Scenario:
        """Return the scenario with phases."""
        about = {"phases": [_table(phase) for phase in phases], "name": f"plan-{self.name}", "summary": summary}
        return _validated(as_dict(self.base) | about)

    def error(self, information: Array) -> float:
        """Return the goal's error from information (k, k), infinite if unobservable."""
        covariance = inverse(information)
        return np.inf if covariance is None else float(np.sqrt(np.sum(self.wanted * (covariance @ self.wanted))))

    def error_with(self, information: Array) -> float:
        """Return the goal's error from information (k, k) and the information from before."""
        return self.error(information if self.before is None else information + self.before)

    @property
    def error_before(self) -> float:
        """Return the goal's error before the flight."""
        return np.inf if self.before is None else self.error(self.before)

    def flown_by(self, manoeuvre: Manoeuvre) -> PlanningTask:
        """Return the task with another manoeuvre."""
        return replace(self, manoeuvre=manoeuvre)

    def going_on(self, information: Array, yaw_deg: float) -> PlanningTask:
        """Return the task with earlier information and an initial heading."""
        return replace(self, before=information, manoeuvre=replace(self.manoeuvre, yaw_deg=yaw_deg))

    def after(self, known: Experiment) -> PlanningTask:
        """Return the task after a recording, with field, sensor, noise and information of the recording.

        The gyro's noise remains. Raises InputError if the direction of the field is unknown.
        """
        field_enu_nT = known.field_enu_nT
        if field_enu_nT is None:
            do = "give --field-enu-nT E,N,U"
            raise InputError("the field's direction is not known", where="--after", do=do)
        known = replace(known, gyro_std_rad_s=self.known.gyro_std_rad_s)
        information = Bound.of(known, self.knowledge).information.matrix
        return replace(self, base=in_field(self.base, field_enu_nT.tolist()), known=known, before=information)


def in_field(scenario: Scenario, field_enu_nT: Sequence[float]) -> Scenario:
    """Return the scenario in another field (3,): east, north, up."""
    return _validated(as_dict(scenario) | {"field": {"enu_nT": list(field_enu_nT)}})


def _heading_deg(base: Scenario) -> float:
    """Return the yaw of the vehicle at the start in degrees."""
    first = next(iter(true_motion(plan(base)))).kinematics.q[:1]
    return round(float(np.degrees(np.arctan2(*matrix_from_q(first)[0, [1, 0], 0]))), 3)


def _allowed(vehicle: str, manoeuvre: Manoeuvre, tilts: Tilts | None) -> Tilts:
    """Return the given tilts, or the vehicle's; InputError for more than the vehicle can perform."""
    asked = tilts or Tilts(*VEHICLES[vehicle].tilts_deg)
    if max(asked.roll_deg, asked.pitch_deg) > manoeuvre.most_deg:
        what = f"{VEHICLES[vehicle].noun} tilts by at most {manoeuvre.most_deg:g} degrees"
        raise InputError(what, where="--tilt-limits", do="give smaller tilts")
    return asked


def based(vehicle: str, like: Scenario, phases: Sequence[PhaseBase], calibrator: str) -> Scenario:
    """Return a scenario with a new vehicle and phases; a vehicle of equal kind is kept with all settings."""
    said = as_dict(like)
    table = said["vehicle"] if said["vehicle"]["kind"] == vehicle else {"kind": vehicle}
    vary = {key: how for key, how in said.get("vary", {}).items() if key.split(".")[0] not in ("phases", "vehicle")}
    changed = {"vehicle": table, "phases": [_table(one) for one in phases], "vary": vary, "calibrators": [calibrator]}
    return _validated(said | changed)


def _resting(base: Scenario) -> Scenario:
    """Return the base, long enough to measure the sensor's noise."""
    phase = base.phases[0]
    return _validated(as_dict(base) | {"phases": [_table(phase)] * ceil(PROBE_S / phase.duration_s)})


def _table(phase: PhaseBase) -> dict[str, Any]:
    return phase.model_dump(mode="json", by_alias=True, exclude_none=True, exclude_defaults=True) | {"kind": phase.kind}


def _validated(said: dict[str, Any]) -> Scenario:
    return Scenario.model_validate(said)
