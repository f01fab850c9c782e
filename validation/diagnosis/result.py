"""What a diagnosis says: verdict, named effects with their parameters, the gap before and after, and what to do."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from scenarios.spec import Scenario
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.evidence.battery import Battery
from validation.diagnosis.evidence.problem import Problem

LEAST_EXCESS = 0.02
"""Excess of power over the noise's that its own chance allows; a share of less cannot be told."""
Verdict = Literal["none", "named", "class", "composite", "partial", "generic", "unknown", "not_observable"]


@dataclass(frozen=True)
class Named:
    """One effect that is missing in the model: fitted, with 95 % intervals, and those that it may be mistaken for.

    how: "held-out" evidence, "direct" (seen in the values themselves), "base" (iron or sensor constants that differ
    from the model's), "spectrum" (noise). D: nats on held-out data; strength: rms after the base refit, in noise.
    """

    effect: Effect
    alternatives: tuple[str, ...]
    how: str
    D: float | None
    strength: float
    spread: dict[str, Array] = field(default_factory=dict)
    evidence: str = "single-run"

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name


@dataclass(frozen=True)
class Gap:
    """Rms of measured minus simulated on held-out segments, hard and soft iron refitted on the others."""

    before_nT: float
    before_sigma: float
    after_nT: float
    after_sigma: float

    @property
    def explained(self) -> float | None:
        """(g0^2 - g1^2) / (g0^2 - 1), at most 1, g in units of the noise; None where there is no gap to explain."""
        excess = self.before_sigma**2 - 1
        return min(1.0, (self.before_sigma**2 - self.after_sigma**2) / excess) if excess > LEAST_EXCESS else None


@dataclass(frozen=True)
class Diagnosis:
    """All that is reported of one recording against one model.

    where: channel, frame ("body", "earth") and held-out share of the gap's power that it explains; ranking: name and
    evidence of every candidate in the first round; before_nT, after_nT (n, q): what is left.
    """

    verdict: Verdict
    sentence: str
    named: tuple[Named, ...]
    where: tuple[tuple[str, str, float], ...]
    gap: Gap
    not_observable: tuple[str, ...]
    advice: tuple[str, ...]
    ranking: tuple[tuple[str, float, float], ...]
    before: Battery
    after: Battery
    model: Scenario
    problem: Problem
    before_nT: Array
    after_nT: Array

    def as_dict(self) -> dict[str, Any]:
        """The JSON of `magbench diagnose`."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "mode": self.problem.mode,
            "effects": [_effect(one) for one in self.named],
            "where": [{"channel": c, "frame": f, "score": round(s, 4)} for c, f, s in self.where],
            "gap": {
                "before": {"rms_nT": self.gap.before_nT, "rms_sigma": self.gap.before_sigma},
                "after": {"rms_nT": self.gap.after_nT, "rms_sigma": self.gap.after_sigma},
                "explained": self.gap.explained,
            },
            "left": list(self.after.why),
            "candidates": [{"name": n, "evidence_nats": d, "strength_sigma": s} for n, d, s in self.ranking],
            "not_observable": list(self.not_observable),
            "advice": list(self.advice),
        }


def _effect(one: Named) -> dict[str, Any]:
    return {
        "name": one.name,
        "alternatives": list(one.alternatives),
        "parameters": parameters(one),
        "evidence": one.evidence,
        "how": one.how,
        "evidence_nats": one.D,
        "strength_sigma": one.strength,
    }


def parameters(one: Named) -> dict[str, dict[str, Any]]:
    """Value with 95 % interval and unit of every parameter in use; no interval where the data do not give one."""
    out: dict[str, dict[str, Any]] = {}
    for p in one.effect.parameters():
        value = getattr(one.effect, p.name)
        if isinstance(value, str):
            out[p.name] = {"value": value, "low": None, "high": None, "unit": ""}
            continue
        spread = one.spread.get(p.name)
        if spread is not None and not np.isfinite(spread).all():
            spread = None  # the data leave a combination of its components open
        middle = np.asarray(value, dtype=float)
        out[p.name] = {
            "value": middle.tolist(),
            "low": None if spread is None else (middle - 1.96 * spread).tolist(),
            "high": None if spread is None else (middle + 1.96 * spread).tolist(),
            "unit": p.unit,
        }
    return out


def short(value: Any) -> str:
    """A value, or an array of them, to four digits."""
    if isinstance(value, list):
        return "(" + ", ".join(short(v) for v in value) + ")"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
