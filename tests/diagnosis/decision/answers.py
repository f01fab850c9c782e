"""Names, cases and diagnoses made by hand, to judge and to word."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from diagnosis.decision.verdict_rules import VerdictInput
from diagnosis.evidence.residual_tests import ResidualTests, RisingSpectrum
from diagnosis.result import Diagnosis, EvidenceKind, GapSize, NamedEffect
from diagnosis.verdict import Verdict
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
TURN = NamedEffect(SoftIron(((0.0, 0.01, 0.0), (-0.01, 0.0, 0.0), (0.0, 0.0, 0.0))), (), EvidenceKind.IRON, 50.0, 1.0)


def case_of(*named: NamedEffect, clean: bool = True, explained: float | None = 0.97, **changes: Any) -> VerdictInput:
    case = VerdictInput(POSED, named, clean, replace(GAP, explained=explained), (), np.zeros_like(POSED.target))
    return replace(case, **changes)


def either(named: NamedEffect, *others: str) -> NamedEffect:
    return replace(named, alternatives=others)


def diagnosis_of(verdict: Verdict = Verdict.NAMED, *named: NamedEffect, **changes: Any) -> Diagnosis:
    tests = ResidualTests({}, (), 0.0, ("means over 5 s",))
    model: Any = SimpleNamespace(chain=lambda: POSED.effects)
    made = Diagnosis(verdict, "", named, (), GAP, (), (), (), (), tests, tests, model, POSED, LEFT_NT, LEFT_NT)
    return replace(made, **changes)
