"""How far an effect reaches, by what each recording says of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from validation.diagnosis.policy import STANDARD
from validation.diagnosis.result import Reach
from validation.together import reach
from validation.together.reach import There, finding


@pytest.mark.parametrize(
    ("there", "found"),
    [
        ((There.PRESENT, There.OPEN, There.OPEN), None),
        ((There.PRESENT, There.PRESENT, There.OPEN), Reach.NOT_TRANSFERRED),
    ],
)
def test_what_differs_is_present_in_two_recordings_at_least(
    monkeypatch: pytest.MonkeyPatch, there: tuple[There, ...], found: Reach | None
) -> None:
    """However much the coefficients explain: what one recording alone shows is no name."""
    candidate = SimpleNamespace(possible=lambda c: True)
    joint: Any = SimpleNamespace(asked=("a", "b", "c"), candidate=candidate)
    differ = SimpleNamespace(p=1e-9, c=1.0)
    monkeypatch.setattr(reach, "_there", lambda *_: there)
    monkeypatch.setattr(reach, "_common", lambda *_: (1e3, differ))
    assert finding(joint, 10.0, STANDARD).reach is found
