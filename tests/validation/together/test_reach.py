"""How far an effect reaches, by what each recording says of it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from validation.diagnosis.policy import STANDARD
from validation.diagnosis.result import Reach
from validation.together import reach
from validation.together.coefficients import Estimate
from validation.together.reach import There, _shown_by_two, finding

GIVEN = Estimate(np.diag([20.0, 10.0]), np.array([20.0, 10.0]))
SMALL, TURNED, WANDER = (replace(GIVEN, g=by * GIVEN.g) for by in (0.7, -0.7, 0.6))


def joint_of(estimates: tuple[Estimate, ...], own: tuple[float, ...], candidate: Any = None) -> Any:
    return SimpleNamespace(asked="abc", estimates=estimates, own=own.__getitem__, candidate=candidate, price=0.0)


@pytest.mark.parametrize(
    ("second", "own", "shown"),
    [
        (SMALL, (6.0, 6.0), True),
        (TURNED, (6.0, 6.0), False),
        (TURNED, (6.0, 16.0), False),
        (TURNED, (16.0, 16.0), True),
        (WANDER, (16.0, 6.0), False),
    ],
)
def test_what_has_another_sign_or_is_small_is_no_second_witness(
    second: Estimate, own: tuple[float, float], shown: bool
) -> None:
    """Unless both show it by themselves: 15 nats of the first, 7.4 and 5.4 of the seconds where 7 are needed."""
    assert _shown_by_two(joint_of((GIVEN, second), own), (0, 1), 7.0) is shown


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
    joint: Any = joint_of((GIVEN, SMALL, replace(GIVEN)), (9.0, 9.0, 9.0), candidate)
    differ = SimpleNamespace(p=1e-9, c=1.0)
    monkeypatch.setattr(reach, "_there", lambda *_: there)
    monkeypatch.setattr(reach, "_common", lambda *_: ([4e2, 4e2, 2e2], differ))
    assert finding(joint, 7.0, STANDARD).reach is found


@pytest.mark.parametrize(
    ("named", "needed", "found"),
    [((0, 1), 7.0, (Reach.NOT_TRANSFERRED, 18.0)), ((0,), 7.0, (None, -50.0)), ((0, 1), 10.0, (None, -50.0))],
)
def test_what_two_recordings_name_by_themselves_need_not_be_alike(
    monkeypatch: pytest.MonkeyPatch, named: tuple[int, ...], needed: float, found: tuple[Reach | None, float]
) -> None:
    """A tone begins every run with another phase: the others' coefficients explain less than none."""
    joint: Any = joint_of((GIVEN, TURNED), (9.0, 9.0), SimpleNamespace(possible=lambda c: True))
    monkeypatch.setattr(reach, "_there", lambda *_: (There.PRESENT, There.PRESENT))
    monkeypatch.setattr(reach, "_common", lambda *_: ([-20.0, -30.0], SimpleNamespace(p=1e-9, c=1.0)))
    joint.asked = "ab"
    one = finding(joint, needed, STANDARD, named)
    assert (one.reach, one.nats) == found


@pytest.mark.parametrize(
    ("each", "found"), [([33.8, -0.1, 0.2], None), ([33.8, -0.1, 4.8], Reach.TRANSFERRED), ([9.0, 4.7, -0.1], None)]
)
def test_what_is_explained_in_one_recording_alone_is_no_name(
    monkeypatch: pytest.MonkeyPatch, each: list[float], found: Reach | None
) -> None:
    """Coefficients that the others hardly know may go the way of one that shows an effect: a third of 14 is needed."""
    joint: Any = joint_of((GIVEN, SMALL, SMALL), (138.0, -4.0, -4.0), SimpleNamespace(possible=lambda c: True))
    monkeypatch.setattr(reach, "_there", lambda *_: (There.PRESENT, There.OPEN, There.OPEN))
    monkeypatch.setattr(reach, "_common", lambda *_: (each, SimpleNamespace(p=0.9, c=1.0)))
    assert finding(joint, 14.0, STANDARD).reach is found
