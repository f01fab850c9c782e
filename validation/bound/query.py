"""A question to the bound, and the answer: the least errors, what they mean, and what is weak."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from scenarios.sweep import Sweep, Value, swept
from sim.scenario import Scenario
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.files import scenario_experiment
from validation.bound.limit import Limit, Tilts, limit
from validation.bound.score_bounds import Use, uses
from validation.bound.unobservable import Weak, weak_directions

OPTION = "--what-if"


@dataclass(frozen=True, eq=False)
class BoundAnswer:
    """Of one experiment: the bound, the least errors of what it is used for, the weak directions, the tilts' limit."""

    known: Experiment
    bound: Bound
    used: tuple[Use, ...]
    weak: tuple[Weak, ...]
    limit: Limit | None = None


@dataclass(frozen=True)
class BoundQuery:
    """What a method is told: `knowledge` of the field, with its strength or without; and noise that is stated.

    noise_std_nT, gyro_std_rad_s : of white noise; None: as found
    tilts : those within which the limit of all motions is asked; None: of none
    coloured : of a scenario, with its flicker noise and random walk
    gyro_scale_std : of the gyro's scale, each axis, a fraction; 0: it is exact
    """

    knowledge: str = "norm"
    strength_known: bool = True
    noise_std_nT: float | None = None
    gyro_std_rad_s: float | None = None
    tilts: Tilts | None = None
    coloured: bool = False
    gyro_scale_std: float = 0.0

    def answer(self, known: Experiment) -> BoundAnswer:
        """The answer for an experiment; InputError for knowledge that it does not hold."""
        if self.gyro_std_rad_s is not None:
            known = replace(known, gyro_std_rad_s=self.gyro_std_rad_s)
        known = replace(known, gyro_scale_std=self.gyro_scale_std)
        bound = Bound.of(known, self.knowledge, strength_known=self.strength_known)
        least = None if self.tilts is None else limit(known, self.knowledge, self.tilts)
        return BoundAnswer(known, bound, uses(known, bound), weak_directions(known, bound), least)

    def of_scenario(self, scenario: Scenario) -> BoundAnswer:
        """The answer for a simulated run; InputError where the vehicle cannot do the motion."""
        return self.answer(scenario_experiment(scenario, self.noise_std_nT, coloured=self.coloured))


@dataclass(frozen=True)
class WhatIf:
    """The answers at the values that one of a scenario's takes."""

    key: str
    values: Sequence[Value]
    answers: Sequence[BoundAnswer]

    @classmethod
    def of(cls, question: BoundQuery, scenario: Scenario, sweep: Sweep) -> WhatIf:
        """Fly the scenario at each value; InputError where the vehicle cannot."""
        flown = [swept(scenario, {sweep.key: value}, OPTION) for value in sweep.values]
        answers = [question.of_scenario(one) for one in flown]
        return cls(sweep.key, sweep.values, answers)
