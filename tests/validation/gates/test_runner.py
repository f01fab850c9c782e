"""Gates on scripted trials: which verdict, after how many, whatever the order in which trials land."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pytest

from tests.validation.gates.conftest import Scripted, gate_text, row
from validation.comparison.trial import TrialRow
from validation.gates.gate_groups import GateGroup
from validation.gates.runner import decide_gates, record_scores
from validation.gates.sequential import decide

Groups = Callable[..., tuple[GateGroup, ...]]
SCORES = np.exp(0.5 * np.random.default_rng(11).standard_normal(5000))


def alternating(group: int, run: int) -> Iterable[TrialRow]:
    """Ellipsoid around 1 nT, sphere four times that, twostep now and then without an estimate."""
    yield row("ellipsoid", SCORES[run])
    yield row("sphere", 4.0 * SCORES[run])
    yield row("twostep", *((None, "unobservable", "too level") if run % 10 else (SCORES[run], "ok")))
    yield row("uncorrected", 1000.0)


def test_clear_cases_are_decided_each_on_its_own_trials(groups_of: Groups) -> None:
    groups = groups_of(
        gate_text("good", limit=2.0),
        gate_text("bad", "sphere", limit=2.0),
        gate_text("paired", "sphere", ratio=3.9, reference="ellipsoid"),
        gate_text("mostly without estimate", "twostep", limit=1e6),
        gate_text("beats the raw measurement", ratio=0.1, reference="uncorrected"),
    )
    assert len(groups) == 1
    outcomes = decide_gates(groups, Scripted(alternating))
    assert [one.verdict for one in outcomes] == ["pass", "fail", "fail", "fail", "pass"]
    assert all(one.decision.trials <= 120 for one in outcomes)
    paired = outcomes[2]
    assert paired.measured == pytest.approx(4.0)
    assert paired.decision.exceeded.all()
    assert outcomes[3].failures.most_common(1)[0][0] == "unobservable: too level"


@pytest.mark.parametrize("seed", range(5))
def test_the_order_in_which_trials_land_changes_nothing(seed: int, groups_of: Groups) -> None:
    texts = (gate_text("a", limit=1.6), gate_text("b", "sphere", limit=4.9), gate_text("c", limit=1.3, max_trials=60))
    expected = decide_gates(groups_of(*texts), Scripted(alternating))
    for found, one in zip(decide_gates(groups_of(*texts), Scripted(alternating, 7, seed)), expected, strict=True):
        assert found.verdict == one.verdict
        np.testing.assert_array_equal(found.scores, one.scores)
        np.testing.assert_array_equal(found.decision.over, one.decision.over)


def test_no_more_trials_are_computed_than_are_in_hand_when_all_is_decided(groups_of: Groups) -> None:
    engine = Scripted(alternating, window=4)
    outcomes = decide_gates(groups_of(gate_text("a", limit=50.0), gate_text("b", "sphere", limit=50.0)), engine)
    assert max(one.decision.trials for one in outcomes) <= engine.computed <= outcomes[0].decision.trials + 6


def test_gates_of_two_scenarios_read_their_own_trials(groups_of: Groups) -> None:
    groups = groups_of(
        gate_text("a", limit=2.0),
        gate_text("b", scenario="quad-calibration", limit=2.0),
        gate_text("c", limit=2.0, set=["sampling.rate_hz=5"]),
    )
    assert [len(group.design.points) for group in groups] == [1, 2, 3]

    def told(group: int, run: int) -> Iterable[TrialRow]:
        yield row("ellipsoid", (1.0, 5.0, 1.0)[group])

    assert [one.verdict for one in decide_gates(groups, Scripted(told, window=3))] == ["pass", "fail", "pass"]


def test_near_its_limit_a_gate_says_how_many_more_trials_it_takes(groups_of: Groups) -> None:
    (outcome,) = decide_gates(groups_of(gate_text("near", limit=1.15, max_trials=80)), Scripted(alternating))
    assert outcome.verdict == "inconclusive"
    assert outcome.decision.trials == 80
    assert outcome.more_trials is not None
    longer = 80 + outcome.more_trials
    share = np.mean(outcome.decision.exceeded)
    again = np.arange(1, longer + 1) * share
    repeated = np.diff(np.floor(again), prepend=0.0)  # exceedances spread evenly at the same rate

    def told(group: int, run: int) -> Iterable[TrialRow]:
        yield row("ellipsoid", 2.0 if repeated[min(run, longer - 1)] else 1.0)

    (later,) = decide_gates(groups_of(gate_text("near", limit=1.15, max_trials=longer + 3)), Scripted(told))
    assert later.verdict != "inconclusive"


def test_the_smallest_defect_seen_is_one_that_fails_with_the_power(groups_of: Groups) -> None:
    text = gate_text("a", limit=2.0, max_trials=100, power=0.9)
    (outcome,) = decide_gates(groups_of(text), Scripted(alternating))
    assert outcome.verdict == "pass"
    rng = np.random.default_rng(2)
    worse = outcome.factor_seen * 1.25 * np.exp(0.5 * rng.standard_normal((500, 100)))  # seen from a handful of trials
    verdicts = [decide(outcome.plan.test, trials > 2.0).verdict for trials in worse]
    assert verdicts.count("fail") >= 450


def test_a_failure_rate_is_a_score_too(groups_of: Groups) -> None:
    text = gate_text("a", "twostep", score="failure", limit=0.5, quantile=0.9, max_trials=300)
    (outcome,) = decide_gates(groups_of(text), Scripted(alternating))
    assert outcome.verdict == "fail"


def test_what_is_recorded_is_every_trial(groups_of: Groups) -> None:
    groups = groups_of(gate_text("a", limit=50.0, max_trials=40), gate_text("b", "twostep", limit=50.0, max_trials=25))
    one, other = record_scores(groups, Scripted(alternating, window=5))
    assert one["value"].to_pylist() == SCORES[:40].tolist()
    assert other["value"].to_pylist()[:11] == [SCORES[0], *[None] * 9, SCORES[10]]
    assert other.num_rows == 25
