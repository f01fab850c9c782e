"""What of slow noise is named, and what it may be instead."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from diagnosis.policy import STANDARD
from diagnosis.repair.named_effects import named_values
from sim.effects.offsets import OffsetRandomWalk


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
    conclusion: Any = SimpleNamespace(selection=SimpleNamespace(end=end, results=judged), noise=noise)
    (one,) = named_values(conclusion, (), ())
    assert one.alternatives == ("flicker_noise", *listed)
