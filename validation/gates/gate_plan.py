"""Before anything is simulated: the test that a gate stands for, and how many trials it may take."""

from __future__ import annotations

from dataclasses import dataclass

from scenarios.errors import InputError
from validation.gates.gate_file import SMALLEST_DEFECT, Gate
from validation.gates.power import MOST_TRIALS, exceedance_of, fewest_trials, trials_to_fail
from validation.gates.sequential import SequentialTest


@dataclass(frozen=True)
class GatePlan:
    """A gate, the test that decides it, and the trials after which it is left undecided."""

    gate: Gate
    test: SequentialTest
    max_trials: int


def plan_gate(gate: Gate, false_fail_rate: float, where: str) -> GatePlan:
    """The plan of a gate with that rate of false failures of its own.

    Without max_trials it may take as many trials as its smallest defect does. Raises InputError, naming `where` the
    gate stands, for a defect that max_trials cannot show and for max_trials within which nothing fails.
    """
    test = SequentialTest(1.0 - gate.quantile, false_fail_rate, 1.0 - gate.power)
    fewest = fewest_trials(test)
    if gate.max_trials is not None and gate.max_trials < fewest:
        what = f"within {gate.max_trials} trials nothing fails at a rate of false failures of {false_fail_rate:.2g}"
        raise InputError(what, where=f"{where}.max_trials", do=f"allow {fewest} or more")
    if gate.max_trials is not None and gate.smallest_defect is None:
        return GatePlan(gate, test, gate.max_trials)
    return GatePlan(gate, test, _enough(gate, test, where))


def _enough(gate: Gate, test: SequentialTest, where: str) -> int:
    """max_trials, or where it is not given the trials that the smallest defect takes."""
    defect = gate.smallest_defect or SMALLEST_DEFECT
    needed = trials_to_fail(test, exceedance_of(defect, gate.quantile, gate.spread), gate.power)
    most = gate.max_trials or MOST_TRIALS
    if needed is None or needed > most:
        takes = f"{needed:,}" if needed else f"more than {MOST_TRIALS:,}"
        what = f"a defect of {defect:g} times the limit takes {takes} trials, max_trials is {most:,}"
        spread = f"the spread of ln({gate.score_definition.name}) if it is below {gate.spread:g}"
        raise InputError(
            what, where=f"{where}.smallest_defect", do=f"allow more, name a greater defect, or state {spread}"
        )
    return gate.max_trials or needed
