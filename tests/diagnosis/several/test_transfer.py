"""How far an effect reaches, by what each recording says of it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.result import Transfer
from diagnosis.several import transfer as transfer
from diagnosis.several.coefficients import Agreement, CoefficientEstimate
from diagnosis.several.transfer import (
    Presence,
    _common_nats,
    _presence,
    _presences,
    _two_support,
    assess_transfer,
    compare_sensors,
    predicts,
)

GIVEN = CoefficientEstimate(np.diag([20.0, 10.0]), np.array([20.0, 10.0]))
SMALL, TURNED, WANDER = (replace(GIVEN, g=by * GIVEN.g) for by in (0.7, -0.7, 0.6))


def pooled_candidate(estimates: tuple[CoefficientEstimate, ...], own: tuple[float, ...], candidate: Any = None) -> Any:
    return SimpleNamespace(
        in_recordings="abc", estimates=estimates, own_nats=own.__getitem__, candidate=candidate, price=0.0
    )


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
    second: CoefficientEstimate, own: tuple[float, float], shown: bool
) -> None:
    """Unless both show it by themselves: 15 nats of the first, 7.4 and 5.4 of the seconds where 7 are needed."""
    assert _two_support(pooled_candidate((GIVEN, second), own), (0, 1), 7.0) is shown


@pytest.mark.parametrize(
    ("there", "found"),
    [
        ((Presence.PRESENT, Presence.UNDECIDED, Presence.UNDECIDED), None),
        ((Presence.PRESENT, Presence.PRESENT, Presence.UNDECIDED), Transfer.NOT_TRANSFERRED),
    ],
)
def test_what_differs_is_present_in_two_recordings_at_least(
    monkeypatch: pytest.MonkeyPatch, there: tuple[Presence, ...], found: Transfer | None
) -> None:
    """However much the coefficients explain: what one recording alone shows is no name."""
    candidate = SimpleNamespace(within_bounds=lambda c: True)
    pooled: Any = pooled_candidate((GIVEN, SMALL, replace(GIVEN)), (9.0, 9.0, 9.0), candidate)
    differ = SimpleNamespace(p=1e-9, c=1.0)
    monkeypatch.setattr(transfer, "_presences", lambda *_: there)
    monkeypatch.setattr(transfer, "_common_nats", lambda *_: ([4e2, 4e2, 2e2], differ))
    assert assess_transfer(pooled, 7.0, STANDARD).transfer is found


@pytest.mark.parametrize(
    ("named", "third", "needed", "found"),
    [
        ((0, 1), Presence.UNDECIDED, 7.0, (Transfer.NOT_TRANSFERRED, 18.0)),
        ((0,), Presence.UNDECIDED, 7.0, (None, -50.0)),
        ((0, 1), Presence.UNDECIDED, 10.0, (None, -50.0)),
        ((0, 2), Presence.PRESENT, 7.0, (Transfer.NOT_TRANSFERRED, 18.0)),
        ((0, 2), Presence.UNDECIDED, 7.0, (None, -50.0)),
    ],
)
def test_what_two_recordings_name_by_themselves_need_not_be_alike(
    monkeypatch: pytest.MonkeyPatch,
    named: tuple[int, ...],
    third: Presence,
    needed: float,
    found: tuple[Transfer | None, float],
) -> None:
    """A tone begins every run with another phase: the others' coefficients explain less than none.

    What a recording names by numbers that the effect cannot have, it does not show.
    """
    pooled: Any = pooled_candidate(
        (GIVEN, TURNED, GIVEN), (9.0, 9.0, 9.0), SimpleNamespace(within_bounds=lambda c: True)
    )
    monkeypatch.setattr(transfer, "_presences", lambda *_: (Presence.PRESENT, Presence.PRESENT, third))
    monkeypatch.setattr(transfer, "_common_nats", lambda *_: ([-20.0, -30.0], SimpleNamespace(p=1e-9, c=1.0)))
    one = assess_transfer(pooled, needed, STANDARD, named)
    assert (one.transfer, one.nats) == found


@pytest.mark.parametrize(
    ("each", "found"), [([33.8, -0.1, 0.2], None), ([33.8, -0.1, 4.8], Transfer.TRANSFERRED), ([9.0, 4.7, -0.1], None)]
)
def test_what_is_explained_in_one_recording_alone_is_no_name(
    monkeypatch: pytest.MonkeyPatch, each: list[float], found: Transfer | None
) -> None:
    """Coefficients that the others hardly know may go the way of one that shows an effect: a third of 14 is needed."""
    pooled: Any = pooled_candidate(
        (GIVEN, SMALL, SMALL), (138.0, -4.0, -4.0), SimpleNamespace(within_bounds=lambda c: True)
    )
    monkeypatch.setattr(transfer, "_presences", lambda *_: (Presence.PRESENT, Presence.UNDECIDED, Presence.UNDECIDED))
    monkeypatch.setattr(transfer, "_common_nats", lambda *_: (each, SimpleNamespace(p=0.9, c=1.0)))
    assert assess_transfer(pooled, 14.0, STANDARD).transfer is found


@pytest.mark.parametrize(("second", "same"), [(1.03, True), (1.2, False)])
def test_coefficients_are_the_same_within_an_error_of_form(second: float, same: bool) -> None:
    """However well they are known: 4 % on one motion or another."""
    sharp: Any = tuple(CoefficientEstimate(np.array([[1e6]]), np.array([1e6 * c])) for c in (1.0, second))
    pooled: Any = SimpleNamespace(in_recordings="ab", estimates=sharp, nats=lambda i, c: 9.0, error_degrees=None)
    _, agree = _common_nats(pooled, [0, 1], STANDARD)
    assert (agree.p > STANDARD.not_transferred_alarm) is same
    assert predicts(pooled, STANDARD) is same


PRESENT, ABSENT, UNKNOWN = Presence.PRESENT, Presence.ABSENT, Presence.UNDECIDED


@pytest.mark.parametrize(
    ("there", "of_all", "of_some", "possible", "found"),
    [
        ((PRESENT, PRESENT, ABSENT), (10.0, 0.06), (12.0, 0.5), True, (Transfer.TRANSFERRED, 10.0)),
        ((PRESENT, PRESENT, ABSENT), (10.0, 0.04), (12.0, 0.06), True, (Transfer.SOME, 12.0)),
        ((PRESENT, PRESENT, UNKNOWN), (10.0, 1e-9), (12.0, 0.5), True, (Transfer.NOT_TRANSFERRED, 12.0)),
        ((PRESENT, PRESENT, ABSENT), (10.0, 1e-9), (5.0, 0.5), True, (Transfer.NOT_TRANSFERRED, 10.0)),
        ((PRESENT, PRESENT, ABSENT), (10.0, 1e-9), (12.0, 1e-9), True, (Transfer.NOT_TRANSFERRED, 12.0)),
        ((PRESENT, ABSENT, UNKNOWN), (5.0, 0.5), (12.0, 0.5), True, (None, 5.0)),
        ((PRESENT, PRESENT, ABSENT), (10.0, 0.5), (12.0, 0.5), False, (None, 12.0)),
    ],
)
def test_how_far_coefficients_hold_decides_how_far_an_effect_reaches(
    monkeypatch: pytest.MonkeyPatch,
    there: tuple[Presence, ...],
    of_all: tuple[float, float],
    of_some: tuple[float, float],
    possible: bool,
    found: tuple[Transfer | None, float],
) -> None:
    """In all; in those that show it, where another lacks it; of two sizes where two show it."""
    pooled: Any = pooled_candidate(
        (GIVEN, SMALL, GIVEN), (9.0, 9.0, 9.0), SimpleNamespace(within_bounds=lambda c: possible)
    )

    def common(pooled: object, which: list[int], policy: object) -> tuple[list[float], Any]:
        nats, p = of_all if len(which) == 3 else of_some
        return [nats / len(which)] * len(which), SimpleNamespace(p=p, c=1.0)

    monkeypatch.setattr(transfer, "_presences", lambda *_: there)
    monkeypatch.setattr(transfer, "_common_nats", common)
    one = assess_transfer(pooled, 7.0, STANDARD)
    assert (one.transfer, one.nats) == found


@pytest.mark.parametrize(
    ("own", "possible", "gain", "inflation", "says"),
    [
        (9.0, True, -9.0, 1.0, PRESENT),
        (9.0, False, -9.0, 1.0, ABSENT),
        (3.0, True, 6.0, 1.0, PRESENT),
        (3.0, True, 6.0, 2.0, UNKNOWN),
        (3.0, True, -3.0, 1.0, UNKNOWN),
        (3.0, True, -6.0, 1.0, ABSENT),
    ],
)
def test_a_recording_speaks_by_its_own_coefficients_or_by_those_of_others(
    own: float, possible: bool, gain: float, inflation: float, says: Presence, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By ln(100) nats over their inflation; without the causes it is not asked."""
    monkeypatch.setattr(transfer, "agreement", lambda *_: SimpleNamespace(c=1.0))
    one: Any = SimpleNamespace(gain=lambda c: gain, inflation=lambda c: inflation, c=1.0)
    pooled = pooled_candidate((one, GIVEN), (own, 9.0), SimpleNamespace(within_bounds=lambda c: possible))
    assert _presence(pooled, 0, [1], STANDARD) is says
    assert _presence(pooled_candidate((None, GIVEN), (own, 9.0)), 0, [1], STANDARD) is Presence.NOT_RECORDED  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("own", "others"),
    [((9.0, 3.0, 9.0), ([2], [0, 2], [0])), ((3.0, 3.0, 3.0), ([1, 2], [0, 2], [0, 1]))],
)
def test_a_recording_is_asked_by_those_that_show_an_effect_if_any(
    own: tuple[float, ...], others: tuple[list[int], ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transfer, "_presence", lambda pooled, i, which, policy: which)
    assert _presences(pooled_candidate((GIVEN,) * 3, own), [0, 1, 2], STANDARD) == others


@pytest.mark.parametrize(
    ("some", "p", "found"),
    [
        ([0, 1, 2], 0.06, Transfer.TRANSFERRED),
        ([0, 1], 0.06, Transfer.SOME),
        ([0, 1], 0.04, Transfer.NOT_TRANSFERRED),
        ([0], 0.06, None),
        ([], 0.06, Transfer.TRANSFERRED),
    ],
)
def test_sensors_are_compared_by_those_that_have_an_effect_known_no_better_than_by_one(
    some: list[int], p: float, found: Transfer | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By all where none has it by itself."""
    monkeypatch.setattr(transfer, "_present_in", lambda *_: ([0, 1, 2], (), some))
    agree = Agreement(np.ones(1), np.eye(1), 1.0, 1, p)
    monkeypatch.setattr(transfer, "_common_nats", lambda pooled, which, policy: ([1.0] * len(which), agree))
    one = compare_sensors(pooled_candidate((GIVEN,) * 3, (9.0,) * 3), STANDARD)
    assert (one.transfer, one.nats) == (found, len(some) or 3)
    assert one.agreement.covariance == (len(some) or 3)


def test_the_nats_of_common_coefficients_are_less_their_price() -> None:
    assert transfer._total_nats(SimpleNamespace(price=4.0), [9.0, 9.0]) == 14.0  # type: ignore[arg-type]


@pytest.mark.parametrize(("nats", "p", "holds"), [(9.0, 0.06, True), (3.0, 0.5, False), (9.0, 0.04, False)])
def test_a_second_recording_is_foretold_by_enough_and_agrees(
    nats: float, p: float, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transfer, "agreement", lambda *_: SimpleNamespace(p=p))
    pooled: Any = SimpleNamespace(estimates=(GIVEN, GIVEN), nats=lambda i, c: nats, error_degrees=None)
    assert predicts(pooled, STANDARD) is holds
    pooled.estimates = (GIVEN, None)
    assert not predicts(pooled, STANDARD)
