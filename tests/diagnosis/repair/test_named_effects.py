"""What of slow noise is named, and what it may be instead."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from diagnosis.decision.conclusion import conclude
from diagnosis.decision.selection import select
from diagnosis.policy import STANDARD
from diagnosis.repair.named_effects import explain, named_values
from sim.effects.offsets import OffsetRandomWalk
from tests.diagnosis.synthetic import COSTLY, problem


@pytest.mark.parametrize(("identified", "listed"), [(True, ()), (False, ("a", "b", "c"))])
def test_noise_of_open_nature_lists_the_three_effects_that_explain_most(
    identified: bool, listed: tuple[str, ...]
) -> None:
    """None of which gains less than by chance."""
    nats = {"d": 8.0, "a": 50.0, "c": 9.0, "b": 20.0, "e": 4.0}
    judged = [SimpleNamespace(evidence=SimpleNamespace(name=name, gain=n, nats=n)) for name, n in nats.items()]
    noise = SimpleNamespace(
        effect=OffsetRandomWalk((1.0,) * 3), alternatives=("flicker_noise",), gain=30.0, identified=identified
    )
    end = SimpleNamespace(problem=SimpleNamespace(policy=STANDARD))
    selection: Any = SimpleNamespace(end=end, results=judged, noise=noise)
    (one,) = named_values(selection, (), ())
    assert one.alternatives == ("flicker_noise", *listed)


def test_the_form_of_a_cause_belongs_to_it_and_is_no_second_name() -> None:
    posed = problem(
        hidden={
            "motor_current": {"gain_nT_A": [2.0, -1.0, 4.0]},
            "hard_iron_drift": {"rate_nT_h": [200.0, -100.0, 150.0]},
        }
    )
    selection = conclude(select(posed, COSTLY))
    first, second = selection.accepted
    assert len(explain(selection, ()).named) == 2
    accepted = (first, replace(second, form_of=first.name))
    (one,) = explain(replace(selection, accepted=accepted), ()).named
    assert (one.name, [part.name for part in one.also]) == (first.name, [second.name])
    assert second.name in one.alternatives
