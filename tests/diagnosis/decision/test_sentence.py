"""What a sentence tells of each name."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.advice import advice_for
from diagnosis.decision.sentence import describe_effect, sentence_for
from diagnosis.evidence.held_out import BEHIND, TOO_LITTLE
from diagnosis.evidence.localise import ChannelShare
from diagnosis.evidence.rivals import SIZE_DIFFERS
from diagnosis.verdict import Verdict
from sim.effects import EFFECTS
from sim.effects.iron import HardIron
from tests.diagnosis.decision.answers import (
    DRIVEN,
    FOUND,
    IRON,
    diagnosis_of,
    either,
)
from tests.diagnosis.synthetic import problem, recording


def test_the_sentence_says_cause_size_and_share() -> None:
    told = sentence_for(diagnosis_of(Verdict.NAMED, FOUND))
    assert told.startswith(f"Missing in the model: {DRIVEN.name}: {DRIVEN.linear[0]} (1, 0, 0) nT/A, 1 times the noise")
    assert "97 % of the gap of 19.9 nT beyond 2.00 nT of noise explained on held-out data" in told
    unknown = sentence_for(diagnosis_of(Verdict.UNKNOWN, where=(ChannelShare("pump", "body", 0.5),)))
    assert "means over 5 s" in unknown
    assert "the gap follows pump" in unknown


@pytest.mark.parametrize(
    ("outcome", "told"),
    [
        (TOO_LITTLE, "is a, 95.3 of 25.0 nats needed."),
        (SIZE_DIFFERS, f"is a, 95.3 of 25.0 nats needed ({SIZE_DIFFERS})."),
        (BEHIND, "is a, which explains less of the gap than the candidates refused."),
    ],
)
def test_of_the_nearest_candidate_it_is_said_why_it_is_refused(outcome: str, told: str) -> None:
    """Nats beyond the needed ones are told beside a reason alone: those of a first look are none."""
    nearest: Any = SimpleNamespace(name="a", nats=95.31, needed=25.0, outcome=outcome)
    assert f"the nearest candidate {told}" in sentence_for(diagnosis_of(Verdict.UNKNOWN, ranking=(nearest,)))


def test_events_are_told_with_their_moments() -> None:
    cls = next(effect for effect in EFFECTS if effect.with_role("moment"))
    on, off = (cls(**{str(cls.with_role("moment")): time_s}) for time_s in (33.7125, 90.7))
    assert f"{cls.name} at 33.71 s and 90.70 s: " in describe_effect(replace(FOUND, effect=on, also=(off,)))


@pytest.mark.parametrize(("period_s", "told"), [(298.13, True), (4000.0, False)])
def test_a_period_is_told_that_is_shorter_than_the_run(period_s: float, told: bool) -> None:
    """The run has 400 s."""
    cls = next(effect for effect in EFFECTS if effect.with_role("period"))
    swinging = replace(FOUND, effect=cls(**{str(cls.with_role("period")): period_s}))
    assert (f"{cls.name} every 298.1 s: " in sentence_for(diagnosis_of(Verdict.NAMED, swinging))) == told


def test_of_two_changes_of_the_iron_it_is_said_when_each_acts() -> None:
    on = replace(FOUND, effect=HardIron((3.0, 0.0, 0.0), active_s=(30.0, 90.0)), alternatives=("sensor_offset",))
    found = diagnosis_of(Verdict.PARTIAL, on, either(IRON, "sensor_offset"))
    told = sentence_for(found)
    assert "hard_iron (or sensor_offset) from 30 s to 90 s" in told
    assert "; hard_iron (or sensor_offset) throughout the run: offset_nT" in told
    assert "throughout" not in sentence_for(diagnosis_of(Verdict.PARTIAL, FOUND, IRON))
    assert sum("may also be" in line for line in advice_for(found)) == 1


def test_of_several_motors_the_sentence_says_whose_gain_it_tells() -> None:
    two, one = (DRIVEN(**{DRIVEN.linear[0]: (gain, 0.0, 0.0), "motor": motor}) for motor, gain in ((2, 5.0), (1, 3.0)))
    both = replace(FOUND, effect=two, also=(one,))
    assert describe_effect(both).startswith(f"{DRIVEN.name}: {DRIVEN.linear[0]} of current_2_A (5, 0, 0) nT/A")
    rods = {"current_1_A": "rod_x", "current_2_A": "rod_y"}
    assert describe_effect(both, "", rods).startswith(
        f"{DRIVEN.name} of rod_x, rod_y: {DRIVEN.linear[0]} of rod_y (5, 0, 0)"
    )
    alone = replace(FOUND, effect=two)
    assert describe_effect(alone, "", rods).startswith(
        f"{DRIVEN.name} of rod_y: {DRIVEN.linear[0]} (5, 0, 0) nT per unit, "
    )


def test_of_a_bent_line_the_sentence_tells_the_slope_over_what_was_seen() -> None:
    """A current of 0 to 2 A, ``2 I - 3 I^2 + I^3``: over a uniform course the line's slope is -0.4, by hand."""
    given = replace(recording(), current_A=np.linspace(0.0, 2.0, 4000)[:, None])
    bent = DRIVEN(gain_nT_A=(2.0, 0.0, 0.0), square_nT_A2=(-3.0, 0.0, 0.0), cube_nT_A3=(1.0, 0.0, 0.0), motor=1)
    found = diagnosis_of(Verdict.NAMED, replace(FOUND, effect=bent), problem=problem(given))
    told = re.search(rf"{DRIVEN.linear[0]} \((.*), 0, 0\) nT/A on average, 1 times the noise", sentence_for(found))
    assert told is not None
    assert float(told[1]) == pytest.approx(-0.4, abs=1e-3)
    plain = replace(FOUND, effect=DRIVEN(gain_nT_A=(2.0, 0.0, 0.0), motor=1))
    assert f"{DRIVEN.linear[0]} (2, 0, 0) nT/A, 1 times the noise" in sentence_for(replace(found, named=(plain,)))
