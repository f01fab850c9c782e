"""Sentences and table rows of gates: verdict, smallest detectable defect, remedy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from validation.gates.gate_outcome import GateOutcome
from validation.gates.power import MOST_TRIALS
from validation.text import counted, figure

MARKS = {"pass": "✅", "fail": "❌", "inconclusive": "❔"}
HEADS = ("gate", "verdict", "measured", "limit", "trials", "smallest defect seen")


def headline(outcomes: Sequence[GateOutcome]) -> str:
    """Return the number of failed and inconclusive gates; without either, the number of passed gates."""
    number = {verdict: sum(one.verdict == verdict for one in outcomes) for verdict in MARKS}
    parts = [f"{number['fail']} of {counted(len(outcomes), 'gate')} failed"] if number["fail"] else []
    if number["inconclusive"]:
        parts.append(f"{number['inconclusive']} inconclusive")
    return ", ".join(parts) or f"{counted(len(outcomes), 'gate')} passed"


def gate_rows(outcomes: Sequence[GateOutcome], *, marks: bool = True) -> list[tuple[str, ...]]:
    """Return a row per gate: `HEADS`; marks : an emoji before each verdict, for a pull request."""
    return [
        (
            one.plan.gate.name,
            f"{MARKS[one.verdict]} {one.verdict}" if marks else one.verdict,
            value_with_unit(one, one.measured) if np.isfinite(one.measured) else "no value",
            value_with_unit(one, one.plan.gate.factor),
            str(one.decision.trials),
            _defect(one),
        )
        for one in outcomes
    ]


def sentence(outcome: GateOutcome) -> str:
    """Return the measured value, the limit, and the number of trials over the limit."""
    gate, k = outcome.plan.gate, int(outcome.decision.exceeded.sum())
    quantile = "median" if gate.quantile == 0.5 else f"{100 * gate.quantile:g} % quantile of"
    measured = f"is {value_with_unit(outcome, outcome.measured)}" if np.isfinite(outcome.measured) else "has no value"
    limit, trials = value_with_unit(outcome, gate.factor), counted(outcome.decision.trials, "trial")
    text = f"{quantile} {gate.score_definition.name} {measured}, the limit {limit}, exceeded in {k} of {trials}"
    if outcome.failures:
        text += f" (failed in {outcome.failures.total()}, for instance {outcome.failure})"
    return text


def detectable_defect(outcome: GateOutcome) -> str:
    """Return the smallest defect that the gate detects, with the probability and the number of trials."""
    chance = f"{100 * outcome.plan.gate.power:g} %, within {counted(outcome.plan.max_trials, 'trial')}"
    factor = f": {figure(outcome.factor_seen)} times what was measured" if np.isfinite(outcome.smallest_seen) else ""
    return f"smallest defect that this gate catches ({chance}): {_defect(outcome)}{factor}"


def advice(outcome: GateOutcome) -> str:
    """Return the remedy for a verdict other than `pass`."""
    if outcome.verdict == "pass":
        return ""
    if outcome.verdict == "fail":
        return "find what changed since the last pass; raise the limit only if the new score is intended"
    more = outcome.more_trials
    if more is None:
        return f"no number of trials up to {MOST_TRIALS} decides at this rate; set a limit farther from the score"
    total = outcome.decision.trials + more
    return f"at this rate {counted(more, 'more trial')} would decide: max_trials = {total}, or a limit farther away"


def value_with_unit(outcome: GateOutcome, value: float) -> str:
    """Return a finite value of the gate as text: in the score's unit, or as a multiple of the reference."""
    gate = outcome.plan.gate
    if gate.kind == "limit":
        return f"{figure(value)} {gate.unit}".strip()
    return f"{figure(value)} x {gate.reference or 'baseline'}"


def _defect(outcome: GateOutcome) -> str:
    if np.isfinite(outcome.smallest_seen):
        return value_with_unit(outcome, outcome.smallest_seen)
    return f"over it in {100 * outcome.exceedance_seen:.0f} % of trials"
