"""Names, cases and diagnoses made by hand, to judge and to word."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from diagnosis.evidence.gap_size import GapSize
from diagnosis.evidence.residual_tests import ResidualTests, RisingSpectrum
from diagnosis.result import Diagnosis, EvidenceKind, Explanation, NamedEffect
from diagnosis.verdict import Verdict
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.iron import HardIron, SoftIron
from tests.diagnosis.synthetic import problem

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
POSED = problem()
LEFT_NT = POSED.target * POSED.sigma_nT
GAP = GapSize(20.0, 10.0, 4.0, 2.0, 0.97)
EFFECT = DRIVEN(**{DRIVEN.linear[0]: (1.0, 0.0, 0.0)})
FOUND = NamedEffect(EFFECT, (), EvidenceKind.HELD_OUT, 50.0, 1.0)
IRON = NamedEffect(HardIron((3.0, 0.0, 0.0)), (), EvidenceKind.IRON, 50.0, 1.0)
SEEN = replace(FOUND, kind=EvidenceKind.DIRECT, nats=None)
NOISE = NamedEffect(EFFECT, (), EvidenceKind.SPECTRUM, 50.0, 0.0)
FAST = RisingSpectrum(2.0, 4.0, hides=False)
RISING = replace(FOUND, rivals=("temperature_degC",))
TESTS = ResidualTests(("means over 5 s",))
TURN = NamedEffect(SoftIron(((0.0, 0.01, 0.0), (-0.01, 0.0, 0.0), (0.0, 0.0, 0.0))), (), EvidenceKind.IRON, 50.0, 1.0)


def case_of(*named: NamedEffect, clean: bool = True, explained: float | None = 0.97, **changes: Any) -> Explanation:
    """A case that leaves nothing, if not told otherwise."""
    made = Explanation(POSED, named, clean, replace(GAP, explained=explained), (), LEFT_NT, LEFT_NT, TESTS, None)
    changed = replace(made, **changes)
    return replace(changed, after_nT=np.zeros_like(changed.problem.target))


def leaving(case: Explanation, residual: Array, **changes: Any) -> Explanation:
    """The case with a residual (n, 3) in units of the noise."""
    changed = replace(case, **changes)
    return replace(changed, after_nT=residual * changed.problem.sigma_nT)


def either(named: NamedEffect, *others: str) -> NamedEffect:
    return replace(named, alternatives=others)


def diagnosis_of(verdict: Verdict = Verdict.NAMED, *named: NamedEffect, **changes: Any) -> Diagnosis:
    model: Any = SimpleNamespace(chain=lambda: POSED.effects)
    explained = (POSED, named, False, GAP, (), LEFT_NT, LEFT_NT, TESTS, None)
    return replace(Diagnosis(*explained, verdict, (), (), (), TESTS, model), **changes)
