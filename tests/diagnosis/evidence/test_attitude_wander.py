"""An attitude that wanders is told from a constant turn of it, and from what stands beside it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from diagnosis.evidence.attitude_wander import attitude_wander_explains_more, with_attitude_wander
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.evidence.held_out import judge_candidate
from diagnosis.library.candidates import propose_candidates
from diagnosis.policy import STANDARD
from diagnosis.problem.linear import LinearProblem
from tests.diagnosis.synthetic import problem, recording, without_attitude

N, MEMORY = 2000, 3000
DRIVEN: dict[str, Any] = {"motor_current": {"gain_nT_A": [2.4, -1.2, 1.6]}}


def _posed(seed: int, wander_deg: float, turn_deg: float = 0.0, hidden: dict[str, Any] | None = None) -> LinearProblem:
    """With an attitude that wanders on the world's side, of a memory of so many samples, about a constant turn."""
    given = recording(N, hidden=hidden)
    kicks = np.random.default_rng(seed).normal(size=(N, 3)) * np.sqrt(2 / MEMORY)
    wander = lfilter([1.0], [1.0, -np.exp(-1 / MEMORY)], kicks, axis=0)
    error = Rotation.from_rotvec(np.radians(wander_deg * wander + [turn_deg, -turn_deg, 0.0]))
    true = Rotation.from_quat(given.att_q, scalar_first=True)
    return problem(replace(given, att_q=(error * true).as_quat(scalar_first=True)))


def _asked(name: str, posed: LinearProblem) -> tuple[CandidateFit, ColouredBaseline]:
    evidence = judge_candidate(Baseline.of(posed), propose_candidates(posed)[name])
    coloured_baseline = ColouredBaseline.of(posed, ())
    wander = with_attitude_wander(coloured_baseline, posed)
    assert evidence is not None
    assert wander is not None
    return coloured_baseline.fit_candidate(
        evidence, coloured_baseline.rows.bin(evidence.candidate.columns(posed))
    ), wander


@pytest.mark.parametrize("seed", [4, 5, 6])
def test_the_mean_of_an_attitude_that_wanders_is_no_constant_turn_of_it(seed: int) -> None:
    """Beside a rest of the sensor's axes it is one by many nats."""
    one, wander = _asked("attitude_misalignment", _posed(seed, 0.02))
    assert one.gain > 2 * STANDARD.coloured_nats
    assert attitude_wander_explains_more(one, wander, STANDARD.coloured_nats)


@pytest.mark.parametrize(("wander_deg", "turn_deg"), [(0.0, 0.02), (0.004, 0.1)])
def test_a_constant_turn_stands_with_a_small_wander_and_without(wander_deg: float, turn_deg: float) -> None:
    one, wander = _asked("attitude_misalignment", _posed(1, wander_deg, turn_deg))
    assert not attitude_wander_explains_more(one, wander, STANDARD.coloured_nats)


def test_what_a_wander_does_not_take_up_stands_beside_it() -> None:
    """Though the wander is by far the larger part."""
    one, wander = _asked("motor_current", _posed(1, 0.02, hidden=DRIVEN))
    assert wander.hypothesis.log_likelihood > one.hypothesis.log_likelihood + STANDARD.apart
    assert not attitude_wander_explains_more(one, wander, STANDARD.coloured_nats)


def test_what_is_gained_between_the_samples_of_a_row_counts() -> None:
    one, wander = _asked("attitude_misalignment", _posed(1, 0.02))
    assert not attitude_wander_explains_more(replace(one, within=1e3), wander, STANDARD.coloured_nats)


def test_without_attitude_there_is_no_wander_to_ask_for() -> None:
    posed = problem(without_attitude(recording(600)))
    assert with_attitude_wander(ColouredBaseline.of(posed, ()), posed) is None
    one, _ = _asked("attitude_misalignment", _posed(1, 0.02))
    assert not attitude_wander_explains_more(one, None, STANDARD.coloured_nats)
