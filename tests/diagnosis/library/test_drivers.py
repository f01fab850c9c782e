"""Which channels may drive a gap: those that move, by more than the rounding of their values."""

import numpy as np
import pytest

from diagnosis.library.drivers import AT_ONCE, Driver
from diagnosis.policy import STANDARD

N = 2000
ROUNDED = np.random.default_rng(1).integers(-2, 3, N)


@pytest.mark.parametrize("size", [0.0, 24.0, -3e5])
def test_a_channel_that_moves_by_rounding_alone_drives_nothing(size: float) -> None:
    assert Driver.of("still", size + ROUNDED * np.spacing(max(abs(size), 1e-2)), STANDARD) is None


def test_a_short_burst_in_a_channel_that_is_still_but_for_rounding_is_its_range() -> None:
    x = 24.0 + ROUNDED * np.spacing(24.0)
    x[500:505] = 30.0
    one = Driver.of("burst", x, STANDARD)
    assert one is not None
    assert one.half_range == pytest.approx(3.0)
    assert one.candidate(AT_ONCE, 1).effect.name == "channel_effect"


def test_a_small_unit_is_no_rounding() -> None:
    assert Driver.of("tesla", 1e-7 * np.sin(np.arange(N) / 50.0), STANDARD) is not None
