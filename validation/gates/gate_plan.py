"""Plan of a gate before simulation: the sequential test and the largest number of trials."""

from __future__ import annotations

from dataclasses import dataclass

from scenarios.errors import InputError
from validation.gates.gate_file import SMALLEST_DEFECT, Gate
from validation.gates.power import MOST_TRIALS, exceedance_of, fewest_trials, trials_to_fail
from validation.gates.sequential import SequentialTest
from validation.text import figure


@dataclass(frozen=True)
class GatePlan:
    """A gate, the deciding test, and the number of trials after which the gate stays inconclusive."""

    gate: Gate
    test: SequentialTest
    max_trials: int


def plan_gate(gate: Gate, false_fail_rate: float, where: str) -> GatePlan:
    """Plan a gate for a rate of false failures.

    Without max_trials the plan allows the trials needed for the smallest defect. where : place of the gate for error
    messages. Raises InputError for a defect not detectable within max_trials, and for max_trials too small to fail.
    """
    test = SequentialTest(1.0 - gate.quantile, false_fail_rate, 1.0 - gate.power)
    fewest = fewest_trials(test)
    if gate.max_trials is not None and gate.max_trials < fewest:
        what = (
            f"within {gate.max_trials} trials nothing fails at a rate of false failures of {figure(false_fail_rate, 2)}"
        )
        raise InputError(what, where=f"{where}.max_trials", do=f"allow {fewest} or more")
    if gate.max_trials is not None and gate.smallest_defect is None:
        return GatePlan(gate, test, gate.max_trials)
    return GatePlan(gate, test, _max_trials(gate, test, where))


def _max_trials(gate: Gate, test: SequentialTest, where: str) -> int:
    """Return max_trials, by default the trials needed for the smallest defect."""
    defect = gate.smallest_defect or SMALLEST_DEFECT
    needed = trials_to_fail(test, exceedance_of(defect, gate.quantile, gate.spread), gate.power)
    most = gate.max_trials or MOST_TRIALS
    if needed is None or needed > most:
        takes = f"{needed}" if needed else f"more than {MOST_TRIALS}"
        what = f"a defect of {defect:g} times the limit takes {takes} trials, max_trials is {most}"
        spread = f"the spread of ln({gate.score_definition.name}) if it is below {gate.spread:g}"
        raise InputError(
            what, where=f"{where}.smallest_defect", do=f"allow more, name a greater defect, or state {spread}"
        )
    return gate.max_trials or needed
