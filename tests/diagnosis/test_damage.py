"""A small bench, and proof that it notices a damaged workflow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision import coloured_choice as hearing
from diagnosis.evidence import baseline as baseline
from diagnosis.evidence import held_out as compare
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_candidate, judge_settings
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.library.candidates import propose_candidates
from diagnosis.policy import STANDARD
from diagnosis.problem.blocks import held_out_folds
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.problem.linear import LinearProblem
from diagnosis.workflow import diagnose
from sim.processes import GaussMarkov
from sim.rotation import multiply_q, q_from_rotation_vector
from sim.scenario import ModelSpec

HIDDEN: dict[str, Any] = {
    "motor_current": {"gain_nT_A": [2.0, -1.0, 4.0]},
    "hysteresis": {"gain": [1e-3, 1e-3, 7e-4], "threshold_nT": 2000.0},
    "offset_jump": {"time_s": 100.0, "step_nT": [2.0, -3.0, 1.0]},
}
TURN_DEG, TURN_S = 0.02, 20.0
COLUMNS_COST = 5 / 6
"""Nats that a column costs on held-out data for nothing: k/2 of the parameters' noise, 2/3 of it held, 5/2 times."""


def _misses(flight: Callable[..., Any], model: Callable[..., ModelSpec]) -> list[str]:
    """What a small bench finds wrong: names, the left-out rule, evidence of nothing, evidence against colour."""
    out = []
    for name, table in HIDDEN.items():
        found = diagnose(flight({name: table}), model())
        if [one.name for one in found.named] != [name] or found.verdict not in ("named", "class"):
            out.append(f"{name}: {found.sentence}")
    rest = diagnose(flight({"hysteresis": HIDDEN["hysteresis"]}), model(), without=frozenset({"hysteresis"}))
    if rest.verdict in ("named", "class", "composite"):
        out.append(f"left out: {rest.sentence}")
    return out + _misses_in_evidence(flight, model)


def _misses_in_evidence(flight: Callable[..., Any], model: Callable[..., ModelSpec]) -> list[str]:
    """Evidence of nothing, and evidence against colour, that are not what they must be; of whole flights.

    The cost of a column is that of a long recording, of which every fold determines the columns.
    """
    out = []
    cost = np.mean([_cost_of_a_column(_problem(flight({}, seed=seed, whole=True), model())) for seed in range(4)])
    if abs(cost - COLUMNS_COST) > 0.35:
        out.append(f"a column costs {cost:.2f} nats of white noise")
    most = _most_evidence(_problem(_turned(flight({}, whole=True)), model()))
    if most > 10 * STANDARD.apart:
        out.append(f"{most:.0f} nats for an effect where only the attitude wanders")
    return out


def _problem(recording: Any, model: ModelSpec) -> LinearProblem:
    assert model.field is not None
    assert model.field.enu_nT is not None
    field = np.array(model.field.enu_nT)
    effects = model.chain()
    return pose(recording, Known(field, float(np.linalg.norm(field)), effects))


def _fixed(problem: LinearProblem) -> list[compare.Evidence]:
    """Evidence of the candidates that have no search, at one setting each."""
    basis = Baseline.of(problem)
    members = [several[0] for several in propose_candidates(problem).values() if not several[0].effect.search_role()]
    judged = [judge_settings(basis, [one]) for one in members]
    return [e for e in judged if e is not None]


def _cost_of_a_column(problem: LinearProblem) -> float:
    evidence = _fixed(problem)
    return -sum(e.gain for e in evidence) / sum(e.width for e in evidence)


def _most_evidence(problem: LinearProblem) -> float:
    basis = Baseline.of(problem)
    judged = [
        judge_candidate(basis, several)
        for several in propose_candidates(problem).values()
        if not several[0].effect.search_role()
    ]
    return max(e.nats for e in judged if e is not None)


def _turned(recording: Any) -> Any:
    step_s = float(np.median(np.diff(recording.time_s)))
    error = GaussMarkov(np.radians(TURN_DEG), TURN_S, step_s, 3, np.random.default_rng(3)).draw(len(recording))
    return replace(recording, att_q=multiply_q(q_from_rotation_vector(error), np.array(recording.att_q)))


def test_evidence_of_nothing_is_what_it_must_be(flight, model) -> None:  # type: ignore[no-untyped-def]
    assert _misses_in_evidence(flight, model) == []


@pytest.mark.slow
def test_the_small_bench_passes(flight, model) -> None:  # type: ignore[no-untyped-def]
    """What `test_workflow.py` asks of the same effects in the test run, once more: the damages below are beside it."""
    assert _misses(flight, model) == []


def _swap(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(baseline, "held_out_folds", lambda policy: (~held for held in held_out_folds(policy)))


def _no_deflation(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(compare, "inflation", lambda *given: 1.0)


def _anything_is_clean(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(ResidualTests, "clean", property(lambda run_residual_tests: True))


def _weakest_first(patch: pytest.MonkeyPatch) -> None:
    in_order = hearing._run_trials
    patch.setattr(hearing, "_run_trials", lambda one, tried: in_order(one, tried[::-1]))


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(_no_deflation, marks=pytest.mark.slow),
        pytest.param(_anything_is_clean, marks=pytest.mark.slow),
        pytest.param(_swap, marks=pytest.mark.slow),
        pytest.param(_weakest_first, marks=pytest.mark.slow),
    ],
)
def test_a_damaged_workflow_fails_the_small_bench(damage, flight, model, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    damage(monkeypatch)
    assert _misses(flight, model) != []
