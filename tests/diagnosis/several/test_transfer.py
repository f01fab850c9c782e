"""How far an effect reaches, by the coefficients that each recording has of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from diagnosis.policy import STANDARD, Policy
from diagnosis.result import Transfer
from diagnosis.several.coefficients import CoefficientEstimate
from diagnosis.several.transfer import PooledEffect, Presence, assess_transfer, compare_sensors, predicts

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


@dataclass(frozen=True)
class Lot:
    """A candidate of one column in recordings whose coefficients are known; None where the causes are missing."""

    sizes: tuple[Size | None, ...]
    own: tuple[float, ...] | None = None
    largest: float = 1e9
    price: float = 0.0
    error_degrees: int | None = None
    name: str = "motor_current"

    @property
    def policy(self) -> Policy:
        return STANDARD

    @property
    def here(self) -> dict[int, Size]:
        return {i: size for i, size in enumerate(self.sizes) if size is not None}

    @property
    def estimates(self) -> dict[int, CoefficientEstimate]:
        return {i: CoefficientEstimate(np.array([[N]]), np.array([N * c])) for i, (c, N) in self.here.items()}

    @property
    def candidate(self) -> Any:
        return self

    def within_bounds(self, c: np.ndarray) -> bool:
        return bool(c[0] <= self.largest)

    def nats(self, i: int, c: np.ndarray) -> float:
        return self.estimates[i].gain(c)

    def own_nats(self, i: int) -> float:
        if self.own is not None:
            return self.own[i]
        return self.estimates[i].gain(self.estimates[i].c) if i in self.here else 0.0


def assessed(*sizes: Size | None, named: tuple[int, ...] = (), **others: Any) -> PooledEffect:
    return assess_transfer(Lot(sizes, **others), NEEDED, named)  # type: ignore[arg-type]


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
    assert (found.transfer, found.nats) == (DIFFERS, 90.0)
    assert assessed(*opposite, named=(0,)).transfer is None
    assert assessed(*opposite, named=(0, 2)).transfer is None
    weak = assessed((1.0, 18.0), (-1.0, 18.0), named=(0, 1))
    assert (list(weak.presence.values()), weak.transfer) == ([PRESENT, PRESENT], None)


def test_evidence_is_less_its_price_and_sizes_stay_within_bounds() -> None:
    same = ((1.0, 20.0), (1.0, 20.0))
    assert assessed(*same).nats == 20.0
    found = assessed(*same, price=11.0)
    assert (found.transfer, found.nats) == (None, 9.0)
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
    found = compare_sensors(Lot(sizes))  # type: ignore[arg-type]
    assert found.transfer is reaches
    if reaches is ALL:
        assert found.agreement.covariance == pytest.approx(1 / sizes[0][1])


@pytest.mark.parametrize(
    ("second", "holds"),
    [((1.0, 20.0), True), ((1.03, 9e4), True), ((1.3, 9e4), False), ((1.0, 4.0), False), (None, False)],
)
def test_a_second_recording_is_foretold_by_enough_and_agrees(second: Size | None, holds: bool) -> None:
    assert predicts(Lot(((1.0, 9e4), second))) is holds  # type: ignore[arg-type]


def test_the_strength_is_that_of_the_recordings_with_the_effect() -> None:
    """The root of the mean square; of all that were asked where none has it."""
    here: Any = {0: _Strong(3.0), 1: _Strong(4.0)}

    def strength(*there: Presence) -> float:
        pooled: Any = _Tested(here)
        return PooledEffect(pooled, None, 0.0, dict(enumerate(there)), assessed((1.0, 1.0)).agreement).strength

    assert strength(PRESENT, PRESENT) == pytest.approx(12.5**0.5)
    assert strength(PRESENT, ABSENT) == pytest.approx(3.0)
    assert strength(ABSENT, OPEN) == pytest.approx(12.5**0.5)


@dataclass(frozen=True)
class _Strong:
    strength: float


@dataclass(frozen=True)
class _Tested:
    here: dict[int, _Strong]
