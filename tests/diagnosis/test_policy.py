"""Every number that decides stands in the policy, with words, and changing one changes a decision."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest

from diagnosis.decision.selection import select
from diagnosis.policy import STANDARD, Policy, changed
from diagnosis.problem.blocks import Cut
from scenarios.errors import InputError
from sim.effects import EFFECTS
from tests.bare_numbers import compared, constants
from tests.conftest import ROOT
from tests.diagnosis.synthetic import problem

FILES = sorted((ROOT / "diagnosis").rglob("*.py"))
DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
GUARDS = {
    "formulation.py": {"NOMINAL_NT"},
    "reference_checks.py": {"MISREAD", "LEAST_SHOWN_NT"},
    "known.py": {"NODES", "ANY_DATE", "HIGHEST_M"},
    "motion.py": {"LEAST_NOISE"},
    "vector.py": {"FIELD_ERROR", "DELAY_S", "STEPS"},
    "second_passes.py": {"FARTHEST", "SETTLED_S"},
    "hypothesis.py": {"GONE", "SAME_NATS", "FAR_NATS", "TOGETHER"},
    "windowed_candidates.py": {"NOTHING"},
    "strength.py": {
        "TURN_STEP_S",
        "MOST_STEPS",
        "SETTLED",
        "FIRST_DAMPING",
        "DAMPING_FACTOR",
        "LEAST_LEVEL",
        "ROUNDS",
        "DIP_ERROR_RAD",
        "LEAST_NOISE",
    },
    "linear.py": {"STEPS", "SETTLED"},
    "coefficients.py": {"OPEN", "NOT_COMPARED"},
    "common_effects.py": {"STEP"},
    "candidates.py": {"HEADROOM"},
    "parameter_search.py": {"PIECE", "OWN_NOISE", "LEAST_SHARE"},
    "drivers.py": {"ROUNDING", "LEAST_RANGE"},
    "field_pulsations.py": {"LEAST_ROWS", "MOST_ROWS", "ROWS_A_PERIOD", "TOGETHER", "FINER", "ROUNDS"},
    "dipole_position.py": {"MEAN_S", "MOST_MEANS", "SAME_M", "LEAST_M", "STEP_M"},
    "residual_tests.py": {"MOST_TONES"},
    "advice.py": {"MINUTE_S", "MOST_TIMES", "TRIED_CHANNELS"},
    "legs.py": {"LEGS", "SWAYING", "QUICK", "QUIET"},
    "result.py": {"NORMAL_95"},
    "new_model.py": {"DIGITS"},
    "sentence.py": {"LISTED_CHANNELS"},
    "refinement.py": {"STEPS", "ROUNDS", "CHAINS", "IMPOSSIBLE"},
    "squares.py": {"SAME", "SMALLEST_STEP", "DIFFERENCE", "FLOOR", "ROWS"},
    "noise_model.py": {"LEAST_POWER", "ROUNDS", "LEAST_WHITE", "LEAST_SLOW"},
}
"""Constants that decide nothing: efforts and scales of a computation, theory, and how much is listed."""
COUNTS = {0, 1, 2, 3, 24}
"""Numbers that may be compared with: signs, shapes, whether there are several; 24 / n is a kurtosis' variance."""


@pytest.mark.parametrize("path", [f for f in FILES if f.name != "policy.py"], ids=lambda p: p.name)
def test_no_number_that_decides_stands_elsewhere(path: Path) -> None:
    assert constants(path) <= GUARDS.get(path.name, set())
    assert compared(path) <= COUNTS


def test_every_number_has_its_words() -> None:
    for one in fields(Policy):
        assert len(one.metadata["meaning"].split()) >= 4, one.name
        assert one.metadata["alarms"], one.name
        assert one.metadata["run"], one.name


def test_every_number_is_used() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in FILES)
    for one in fields(Policy):
        assert f"policy.{one.name}" in text or f"self.{one.name}" in text, one.name


def test_a_stricter_policy_names_less() -> None:
    posed = problem(hidden={DRIVEN.name: {DRIVEN.linear[0]: [0.2, -0.15, 0.2]}})
    strict = problem(posed.recording, policy=Policy(alpha=1e-300))
    assert [one.name for one in select(posed).accepted] == [DRIVEN.name]
    assert select(strict).accepted == ()


def test_blocks_follow_the_policy() -> None:
    assert Cut.of(10_000, 0.1, STANDARD).length == 50
    assert Cut.of(10_000, 0.1, changed(STANDARD, ["block_s=2"])).length == 20
    assert Cut.of(1_000, 0.1, STANDARD).length == 10


def test_numbers_are_read_as_their_kind() -> None:
    made = changed(STANDARD, ["alpha=0.001", "splits=4", "colour_blocks=1,4"])
    assert (made.alpha, made.splits, made.colour_blocks) == (0.001, 4, (1, 4))
    assert made.apart > STANDARD.apart


@pytest.mark.parametrize("text", ["nonsense=1", "alpha=much", "splits=2.5", "alpha", "alpha=-1", "half=inf"])
def test_what_is_no_number_of_the_policy_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=text.partition("=")[0]):
        changed(STANDARD, [text])
