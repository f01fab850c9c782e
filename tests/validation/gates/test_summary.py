"""The JSON of gates: evidence in powers of ten that reaches what decides, at the deciding trial and not before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.validation.gates.conftest import Scripted, gate_text, row
from validation.gates.runner import decide_gates
from validation.gates.summary import full_summary


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
