"""The JSON of gates: evidence in powers of ten that reaches what decides, at the deciding trial and not before."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.validation.gates.conftest import Scripted, gate_text, row
from validation.gates.runner import decide_gates, record_scores
from validation.gates.score_baseline import write_baseline
from validation.gates.summary import full_summary, overall_verdict, summary


@pytest.mark.parametrize(("limit", "verdict", "side"), [(2.0, "pass", "within"), (0.5, "fail", "over")])
def test_the_evidence_of_the_last_trial_is_the_first_that_decides(
    limit: float,
    verdict: str,
    side: str,
    groups_of: Callable,  # type: ignore[type-arg]
) -> None:
    text = gate_text("a", limit=limit)
    told = decide_gates(groups_of("false_fail_rate = 0.01", text), Scripted(lambda group, run: [row("ellipsoid", 1.0)]))
    (gate,) = full_summary(told)["gates"]
    course, enough = gate["trajectory"], {"within": "log10_to_pass", "over": "log10_to_fail"}[side]
    evidence = np.array(course[f"log10_evidence_{side}"])
    assert gate["verdict"] == verdict
    assert evidence[-1] >= course[enough] > evidence[:-1].max()
    # all of n trials on one side of the limit: 2^(n + 1) / (n + 1) (1 - 2^-(n + 1)) to one
    n = np.arange(1, len(evidence) + 1)
    np.testing.assert_allclose(10**evidence, 2.0 ** (n + 1) * (1 - 0.5 ** (n + 1)) / (n + 1), rtol=1e-9)
    assert course["log10_to_fail"] == pytest.approx(2.0)


def told_by(*scores: float) -> Scripted:
    """Each gate's group has the same score in every run."""
    return Scripted(lambda group, run: [row("ellipsoid", scores[group])])


def test_the_worst_verdict_is_the_verdict_of_all(groups_of: Callable) -> None:  # type: ignore[type-arg]
    """Fail before inconclusive before pass; none at all passes."""
    kept, broken = gate_text("a", limit=2.0), gate_text("b", limit=0.5)
    near = gate_text("c", score="failure", limit=0.5, quantile=0.9, max_trials=60)
    told = Scripted(lambda group, run: [row("ellipsoid", 1.0, *(("unobservable", "level") if run % 8 == 0 else ()))])
    verdicts = {
        texts: overall_verdict(decide_gates(groups_of(*texts), told))
        for texts in ((near,), (kept, near), (near, broken))
    }
    assert list(verdicts.values()) == ["inconclusive", "inconclusive", "fail"]
    assert overall_verdict([]) == "pass"


def test_the_json_repeats_gate_and_evidence(groups_of: Callable) -> None:  # type: ignore[type-arg]
    """Three in ten trials have no estimate, as many as the limit allows: sixty decide nothing."""
    near = gate_text("near", limit=2.0, quantile=0.7, max_trials=60)
    told = Scripted(
        lambda group, run: [row("ellipsoid", *((None, "unobservable", "level") if run % 10 in (0, 3, 7) else (1.0,)))]
    )
    outcomes = decide_gates(groups_of("false_fail_rate = 0.01", near), told)
    (gate,) = summary(outcomes)["gates"]
    assert (gate["name"], gate["scenario"], gate["calibrator"]) == ("near", "tumble", "ellipsoid")
    assert (gate["score"], gate["unit"], gate["limit"], gate["limit_of"]) == ("offset_error_nT", "nT", 2.0, None)
    assert (gate["verdict"], gate["trials"], gate["max_trials"]) == ("inconclusive", 60, 60)
    assert (gate["exceeded"], gate["without_estimate"], gate["reason"]) == (18, 18, "unobservable: level")
    assert (gate["quantile"], gate["power"], gate["false_fail_rate"]) == (0.7, 0.99, 0.01)
    assert gate["more_trials"] == outcomes[0].more_trials
    assert "trajectory" not in gate
    (decided,) = summary(decide_gates(groups_of(gate_text("kept", limit=2.0)), told_by(1.0)))["gates"]
    assert decided["more_trials"] is None
    assert (decided["exceeded"], decided["measured"], decided["smallest_seen"]) == (0, 1.0, 2.0)


def test_the_json_says_of_what_a_limit_is_a_multiple(tmp_path: Path, groups_of: Callable) -> None:  # type: ignore[type-arg]
    """Of the reference's score, or of the baseline's, without a unit."""
    told = Scripted(lambda group, run: [row("ellipsoid", 1.0), row("sphere", 2.0)])
    write_baseline(tmp_path / "base.parquet", record_scores(groups_of(gate_text("a", limit=2.0, max_trials=60)), told))
    against = (
        gate_text("against", ratio=0.9, reference="sphere"),
        gate_text("held", baseline="base.parquet", max_trials=60),
    )
    one, other = summary(decide_gates(groups_of(*against), told))["gates"]
    assert (one["limit_of"], one["limit"], one["unit"], one["measured"]) == ("sphere", 0.9, "", 0.5)
    assert (other["limit_of"], other["limit"], other["unit"], other["measured"]) == ("base.parquet", 1.1, "", 1.0)
