"""What a row's mean hides is counted: means and what is about them together give the nats of all samples."""

from __future__ import annotations

import pytest

from diagnosis.decision.selection import select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.candidate_test import gain_within
from diagnosis.evidence.held_out import judge_settings
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.linear import LinearProblem
from sim.effects import EFFECTS
from tests.diagnosis.synthetic import COSTLY, problem

COARSE = Policy(most_rows=1000)
FAST_HZ = 2.317


def _tone() -> Candidate:
    effect = next(effect for effect in EFFECTS if effect.search_role() == "frequency")
    name = effect.with_role("frequency")
    assert name is not None
    return Candidate(effect, ((name, FAST_HZ),))


def _waving(policy: Policy = COARSE, **coloured_baseline: object) -> LinearProblem:
    effect, name = _tone().effect, _tone().effect.with_role("frequency")
    return problem(
        hidden={effect.name: {effect.linear[0]: [0.3, -0.2, 0.3], name: FAST_HZ}, **coloured_baseline}, policy=policy
    )


def _rows(posed: LinearProblem) -> BinnedRows:
    return BinnedRows.of(posed.state.time_s, posed.usable, posed.base, posed.target, posed.policy)


def test_means_and_what_is_about_them_have_the_nats_of_all_samples() -> None:
    posed, tone = _waving(), _tone()
    evidence = judge_settings(Baseline.of(posed), [tone])
    assert evidence is not None
    found = gain_within(Baseline.of(posed), _rows(posed), tone.columns(posed))
    assert found == pytest.approx(evidence.gain, rel=0.2)  # of means 0.4 s long a hundredth of it is left
    taken = gain_within(Baseline.of(posed, [tone.columns(posed)]), _rows(posed), tone.columns(posed))
    assert taken < 1.0


def test_nothing_is_counted_twice_where_the_means_show_it() -> None:
    driven = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
    for posed, one in ((_waving(), Candidate(driven)), (_waving(STANDARD), _tone())):
        assert gain_within(Baseline.of(posed), _rows(posed), one.columns(posed)) == 0.0


def test_a_tone_faster_than_the_rows_is_named_beside_a_wander() -> None:
    posed = _waving(offset_random_walk={"std_nT_sqrt_s": [0.3] * 3})
    assert _tone().name in {one.name for one in select(posed, COSTLY).accepted}
