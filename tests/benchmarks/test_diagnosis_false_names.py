"""Nats from scores are those of the diagnosis, and white noise seldom has the nats of a name."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.diagnosis.false_names import Scores, best_nats
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_settings
from diagnosis.library.candidates import propose_candidates
from diagnosis.policy import STANDARD
from sim.effects import EFFECTS
from sim.effects.currents import MotorCurrent
from sim.effects.temperature import TemperatureOffset
from tests.diagnosis.synthetic import problem


@pytest.mark.parametrize("effect", [MotorCurrent, TemperatureOffset])
def test_the_gain_from_the_scores_of_a_recording_is_its_evidence(effect: type) -> None:
    baseline = Baseline.of(problem())
    several = propose_candidates(baseline.problem)[effect.name]
    columns = [one.columns(baseline.problem) for one in several]
    sums = baseline.sums_with(np.concatenate(columns, axis=2))
    q = sums.BC.shape[2]
    power = np.append(np.repeat(np.einsum("fpp->p", sums.BB), q), np.einsum("fkk->k", sums.CC)[1:])
    of_target = np.concatenate([sums.BC[:, :, :, 0].reshape(len(sums.BB), -1), sums.CC[:, 0, 1:]], axis=1)
    drawn = Scores.of(baseline, np.concatenate(columns, axis=2), 1, np.random.default_rng(0))
    scores = replace(drawn, drawn=(of_target / np.sqrt(power))[:, None])
    ends = scores.base + np.cumsum([0, *(one.shape[2] for one in columns)])
    settings = [slice(*pair) for pair in itertools.pairwise(ends)]
    found = judge_settings(baseline, several)
    assert found is not None
    gains = scores.gains(settings, baseline.splits, baseline.problem.policy.held_segments)
    assert gains[0] == pytest.approx(found.gain, abs=1e-6)


def test_white_noise_seldom_has_the_nats_of_a_name() -> None:
    """Of some effects together fewer than the share `alpha` that the whole library may have."""
    baseline = Baseline.of(problem())
    plain = {
        name: each for name, each in propose_candidates(baseline.problem).items() if not each[0].effect.search_role()
    }
    nats = np.max(list(best_nats(baseline, plain, 4000, 0).values()), axis=0)
    assert (nats > STANDARD.accepted(len(EFFECTS))).mean() < STANDARD.alpha
    assert (nats > STANDARD.apart).mean() < 5 * STANDARD.alpha
