"""Query of the Cramer-Rao bound, and the answer: least errors, score bounds and weak directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from scenarios.sweep import Sweep, Value, swept
from sim.scenario import Scenario
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.files import scenario_experiment
from validation.bound.limit import Limit, Tilts, limit
from validation.bound.score_bounds import ScoreBound, score_bounds
from validation.bound.unobservable import Weak, weak_directions

OPTION = "--what-if"


@dataclass(frozen=True, eq=False)
class BoundAnswer:
    """Bound of an experiment, with score bounds, weak directions, and the limit of the tilts."""

    known: Experiment
    bound: Bound
    used: tuple[ScoreBound, ...]
    weak: tuple[Weak, ...]
    limit: Limit | None = None


@dataclass(frozen=True)
class BoundQuery:
    """Information given to a method: `knowledge` of the field, with or without strength, and the noise.

    noise_std_nT, gyro_std_rad_s : white noise; None for the noise of the experiment
    tilts : tilts for the limit of all motions; None for no limit
    coloured : with the scenario's flicker noise and random walk
    gyro_scale_std : standard deviation of the gyro's scale, each axis, a fraction; 0 for an exact scale
    """

    knowledge: str = "norm"
    strength_known: bool = True
    noise_std_nT: float | None = None
    gyro_std_rad_s: float | None = None
    tilts: Tilts | None = None
    coloured: bool = False
    gyro_scale_std: float = 0.0

    def answer(self, known: Experiment) -> BoundAnswer:
        """Return the answer for an experiment; InputError for knowledge that the experiment does not provide."""
        if self.gyro_std_rad_s is not None:
            known = replace(known, gyro_std_rad_s=self.gyro_std_rad_s)
        known = replace(known, gyro_scale_std=self.gyro_scale_std)
        bound = Bound.of(known, self.knowledge, strength_known=self.strength_known)
        least = None if self.tilts is None else limit(known, self.knowledge, self.tilts)
        return BoundAnswer(known, bound, score_bounds(known, bound), weak_directions(known, bound), least)

    def of_scenario(self, scenario: Scenario) -> BoundAnswer:
        """Return the answer for a simulated run; InputError if the vehicle cannot perform the motion."""
        return self.answer(scenario_experiment(scenario, self.noise_std_nT, coloured=self.coloured))


@dataclass(frozen=True)
class WhatIf:
    """Answers for several values of a scenario's parameter."""

    key: str
    values: Sequence[Value]
    answers: Sequence[BoundAnswer]

    @classmethod
    def of(cls, question: BoundQuery, scenario: Scenario, sweep: Sweep) -> WhatIf:
        """Simulate the scenario at each value; InputError if the vehicle cannot perform the motion."""
        flown = [swept(scenario, {sweep.key: value}, OPTION) for value in sweep.values]
        answers = [question.of_scenario(one) for one in flown]
        return cls(sweep.key, sweep.values, answers)
