"""Diagnoses of several recordings made by hand: what is told is known."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from diagnosis.evidence.gap_size import GapSize
from diagnosis.policy import STANDARD
from diagnosis.result import EvidenceKind, Explanation, NamedEffect, Transfer
from diagnosis.several.coefficients import Agreement
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.pooled_effect import Presence
from diagnosis.several.result import PooledDiagnosis
from diagnosis.verdict import Verdict
from sim.effects.currents import MotorCurrent
from sim.effects.iron import HardIron

GAP = GapSize(20.0, 10.0, 6.0, 3.0, 91 / 99)
NAMES = ("first", "second", "third")
POSED: Any = SimpleNamespace(compared="vector", policy=STANDARD)
AGREE = Agreement(np.zeros(3), np.eye(3), 1.5, 3, 0.7)
HERE, ABSENT, OPEN = Presence.PRESENT, Presence.ABSENT, Presence.UNDECIDED


def motor(
    gain_nT_A: float = 3.0, transfer: Transfer = Transfer.TRANSFERRED, kind: EvidenceKind = EvidenceKind.HELD_OUT
) -> NamedEffect:
    """A motor's field along x, known to a tenth of a nT an ampere."""
    spread = {"gain_nT_A": np.array([0.1, 0.1, 0.1])}
    return NamedEffect(MotorCurrent(gain_nT_A=(gain_nT_A, 0.0, 0.0)), (), kind, 50.0, 2.0, spread, transfer)


def iron(transfer: Transfer = Transfer.TRANSFERRED) -> NamedEffect:
    """A change of the hard iron."""
    return NamedEffect(HardIron(offset_nT=(9.0, 0.0, 0.0)), (), EvidenceKind.IRON, 30.0, 1.0, {}, transfer)


def common(
    transfer: Transfer,
    presence: Sequence[Presence] = (HERE, HERE, HERE),
    gains: Sequence[float | None] = (3.0, 3.0, 3.0),
    ratios: Sequence[tuple[float, float] | None] = (),
) -> CommonEffect:
    """A motor's field in three recordings, of a size in each."""
    each = tuple(None if gain is None else motor(gain, transfer) for gain in gains)
    return CommonEffect(motor(3.0, transfer), each, tuple(presence), AGREE, tuple(ratios))


def own(verdict: Verdict = Verdict.NONE, effects: Sequence[dict[str, str]] = ({"name": "scale"},), **said: Any) -> Any:
    """A recording's own diagnosis, as far as several recordings ask for it; effects : in its JSON."""
    table = {"verdict": verdict, "sentence": f"it is {verdict}.", "gap": {"own": 1}, "effects": list(effects)}
    about = {"named": (), "advice": (), "not_observable": (), "gap": GAP, "problem": POSED}
    return SimpleNamespace(verdict=verdict, sentence=f"it is {verdict}.", as_dict=lambda: table, **(about | said))


def gap(size: GapSize = GAP, where: Sequence[Any] = (), left: tuple[str, ...] = ()) -> Explanation:
    """What is explained of one recording."""
    tests: Any = SimpleNamespace(why=left)
    none = np.zeros((1, 3))
    return Explanation(POSED, (), False, size, tuple(where), none, none, tests, None)


def pooled(*effects: CommonEffect, each: Sequence[Any] = (), **said: Any) -> PooledDiagnosis:
    """Three recordings with common effects."""
    diagnoses = tuple(each) or (own(), own(), own())
    known: dict[str, Any] = {
        "names": NAMES,
        "each": diagnoses,
        "verdict": Verdict.NAMED,
        "common": effects,
        "single": (),
        "gaps": (gap(),) * 3,
        "model": None,
    }
    return PooledDiagnosis(**(known | said))
