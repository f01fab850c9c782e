"""How far an effect reaches, by the coefficients that each recording has of it."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.result import Transfer
from diagnosis.several.coefficients import CoefficientEstimate
from diagnosis.several.pooled_effect import PooledEffect, Presence
from diagnosis.several.transfer import assess_transfer, compare_sensors

PRESENT, ABSENT, OPEN, UNASKED = (
    Presence.PRESENT,
    Presence.ABSENT,
    Presence.UNDECIDED,
    Presence.NOT_RECORDED,
)
ALL, SOME, DIFFERS = Transfer.TRANSFERRED, Transfer.SOME, Transfer.NOT_TRANSFERRED
NEEDED = 10.0
Size = tuple[float, float]
"""A coefficient, and the information on it."""


PARTS = 50
"""Parts of a recording that agree: their number makes the error known."""


def lot(
    *sizes: Size | None, own: Sequence[float] = (), largest: float = 1e9, price: float = 0.0, strength: float = 1.0
) -> PooledEffect:
    """A candidate of one column in recordings whose coefficients are known; None where the causes are missing.

    own : nats on held-out folds; those of the coefficients themselves by default.
    """
    here: Any = {}
    for i, size in enumerate(sizes):
        if size is not None:
            c, N = size
            whole = CoefficientEstimate(np.array([[N]]), np.array([N * c]))
            here[i] = SimpleNamespace(
                parts=[CoefficientEstimate(whole.N / PARTS, whole.g / PARTS)] * PARTS,
                estimate=whole,
                inflation=1.0,
                null_gain=0.0,
                held_out_gain=own[i] if own else whole.gain(whole.c),
                strength=strength + i,
                baseline=SimpleNamespace(rows=SimpleNamespace(policy=STANDARD)),
            )
    candidate: Any = SimpleNamespace(name="motor_current", within_bounds=lambda c: bool(c[0] <= largest))
    return PooledEffect(candidate, here, price)


def assessed(*sizes: Size | None, named: tuple[int, ...] = (), **others: Any) -> PooledEffect:
    return assess_transfer(lot(*sizes, **others), NEEDED, named)


@pytest.mark.parametrize(
    ("sizes", "reaches", "presence"),
    [
        (((1.0, 20.0), (1.0, 20.0), (1.0, 20.0)), ALL, (PRESENT,) * 3),
        (((1.0, 8.0), (1.1, 8.0), (0.9, 8.0)), ALL, (OPEN, PRESENT, OPEN)),
        (((1.0, 4.0), (1.1, 4.0), (0.9, 4.0)), None, (OPEN,) * 3),
        (((1.0, 9e4), (1.0, 9e4), (1.03, 9e4)), ALL, (PRESENT,) * 3),
        (((1.0, 9e4), (1.0, 9e4), (1.3, 9e4)), DIFFERS, (PRESENT,) * 3),
        (((1.0, 40.0), (1.0, 40.0), (0.0, 40.0)), SOME, (PRESENT, PRESENT, ABSENT)),
        (((1.0, 40.0), (1.0, 40.0), None), ALL, (PRESENT, PRESENT, UNASKED)),
        (((1.0, 90.0), (0.0, 90.0), (0.0, 90.0)), None, (PRESENT, ABSENT, ABSENT)),
        (((1.0, 200.0), (0.1, 2.0), (0.1, 2.0)), None, (PRESENT, OPEN, OPEN)),
        (((1.0, 200.0), (0.7, 200.0)), DIFFERS, (PRESENT, PRESENT)),
        (((1.0, 90.0), (-1.0, 90.0)), None, (PRESENT, PRESENT)),
    ],
)
def test_coefficients_tell_how_far_an_effect_reaches(
    sizes: tuple[Size | None, ...], reaches: Transfer | None, presence: tuple[Presence, ...]
) -> None:
    """In all within an error of form of 4 %; in those that show it, where another lacks it; of two sizes where two do.

    Weak in each, strong together; a tenth of the size in recordings that hardly know it is no second witness.
    """
    found = assessed(*sizes)
    there = tuple(found.presence.get(i, UNASKED) for i in range(len(sizes)))
    assert (found.transfer, there) == (reaches, presence)


def test_a_tone_that_two_recordings_name_by_themselves_begins_each_with_another_phase() -> None:
    """The others' coefficients explain less than nothing; each its own 45 nats."""
    opposite = ((1.0, 90.0), (-1.0, 90.0), (0.0, 1.0))
    found = assessed(*opposite, named=(0, 1))
    assert (found.transfer, found.nats) == (DIFFERS, pytest.approx(90.0))
    assert assessed(*opposite, named=(0,)).transfer is None
    assert assessed(*opposite, named=(0, 2)).transfer is None
    weak = assessed((1.0, 18.0), (-1.0, 18.0), named=(0, 1))
    assert (list(weak.presence.values()), weak.transfer) == ([PRESENT, PRESENT], None)


def test_evidence_is_less_its_price_and_sizes_stay_within_bounds() -> None:
    same = ((1.0, 20.0), (1.0, 20.0))
    assert assessed(*same).nats == pytest.approx(20.0)
    found = assessed(*same, price=11.0)
    assert (found.transfer, found.nats) == (None, pytest.approx(9.0))
    beyond = assessed(*same, largest=0.5)
    assert (beyond.transfer, list(beyond.presence.values())) == (None, [PRESENT, PRESENT])


@pytest.mark.parametrize(
    ("sizes", "reaches"),
    [
        (((1.0, 90.0), (1.0, 90.0)), ALL),
        (((1.0, 90.0), (1.0, 90.0), (0.0, 90.0)), SOME),
        (((1.0, 90.0), (-0.5, 90.0)), DIFFERS),
        (((1.0, 90.0), (0.0, 90.0)), None),
        (((0.2, 9.0), (0.2, 9.0)), ALL),
    ],
)
def test_sensors_are_compared_by_those_that_have_an_effect_known_no_better_than_by_one(
    sizes: tuple[Size, ...], reaches: Transfer | None
) -> None:
    """By all where none has it by itself; the covariance is of one sensor, since all share the run's slow errors."""
    found = compare_sensors(lot(*sizes))
    assert found.transfer is reaches
    if reaches is ALL:
        assert found.agreement.covariance == pytest.approx(1 / sizes[0][1])


@pytest.mark.parametrize(
    ("sizes", "strength"),
    [
        (((1.0, 90.0), (1.0, 90.0)), 12.5**0.5),
        (((1.0, 90.0), (0.0, 90.0)), 3.0),
        (((0.0, 9.0), (0.0, 9.0)), 12.5**0.5),
    ],
)
def test_the_strength_is_that_of_the_recordings_with_the_effect(sizes: tuple[Size, ...], strength: float) -> None:
    """The root of the mean square; of all that were asked where none has it."""
    assert lot(*sizes, strength=3.0).strength == pytest.approx(strength)
