"""Gate outcomes as plain values: the JSON of `magbench gate`, and gates.json with the trajectory of the evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from scenarios.plain import json_ready
from validation.gates.gate_outcome import GateOutcome
from validation.gates.sequential import Verdict


def overall_verdict(outcomes: Sequence[GateOutcome]) -> Verdict:
    """Return `fail` where any gate failed, else `inconclusive` where any is open, else `pass`."""
    verdicts = {outcome.verdict for outcome in outcomes}
    worst: tuple[Verdict, ...] = ("fail", "inconclusive")
    return next((verdict for verdict in worst if verdict in verdicts), "pass")


def summary(outcomes: Sequence[GateOutcome]) -> dict[str, Any]:
    """Return all verdicts; non-finite values become None."""
    found: dict[str, Any] = json_ready(
        {"verdict": overall_verdict(outcomes), "gates": [_of_gate(outcome) for outcome in outcomes]}
    )
    return found


def full_summary(outcomes: Sequence[GateOutcome]) -> dict[str, Any]:
    """Return `summary` with values and evidence of every trial, in the order of runs."""
    found = summary(outcomes)
    for gate, outcome in zip(found["gates"], outcomes, strict=True):
        gate["trajectory"] = json_ready(_trajectory(outcome))
    return found


def _of_gate(outcome: GateOutcome) -> dict[str, Any]:
    gate, test = outcome.plan.gate, outcome.plan.test
    undecided = outcome.verdict == "inconclusive"
    return {
        "name": gate.name,
        "verdict": outcome.verdict,
        "scenario": gate.scenario,
        "calibrator": gate.calibrator,
        "score": gate.score_definition.column,
        "quantile": gate.quantile,
        "measured": outcome.measured,
        "limit": gate.factor,
        "unit": gate.unit,
        "limit_of": gate.reference or gate.baseline,
        "trials": outcome.decision.trials,
        "exceeded": int(outcome.decision.exceeded.sum()),
        "without_estimate": outcome.failures.total(),
        "reason": outcome.failure,
        "max_trials": outcome.plan.max_trials,
        "more_trials": outcome.more_trials if undecided else None,
        "smallest_seen": outcome.smallest_seen,
        "smallest_seen_factor": outcome.factor_seen,
        "smallest_seen_exceedance": outcome.exceedance_seen,
        "power": gate.power,
        "false_fail_rate": test.false_fail_rate,
    }


def _trajectory(outcome: GateOutcome) -> dict[str, Any]:
    decision, test = outcome.decision, outcome.plan.test
    return {
        "value": outcome.values,
        "exceeded": decision.exceeded,
        "log10_evidence_over": decision.over / math.log(10.0),
        "log10_evidence_within": decision.within / math.log(10.0),
        "log10_to_fail": test.failing / math.log(10.0),
        "log10_to_pass": test.passing / math.log(10.0),
    }
