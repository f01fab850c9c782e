"""Least significant bit: found whatever happened to the values since, and not found where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation.inspection.recordings import rounded, turning
from validation.signals.lattice import find_lattice, odd_share


def series(seed: int, samples: int = 8000, noise: float = 5.0) -> np.ndarray:
    return turning(samples)[1][:, 0] + np.random.default_rng(seed).normal(0, noise, samples)


@pytest.mark.parametrize("step", [0.01, 1.0, 15.0, 24.4140625, 100.0, 3000.0])
@pytest.mark.parametrize("noise", [0.0, 5.0])
def test_step_is_recovered(step: float, noise: float) -> None:
    found = find_lattice(rounded(series(1, noise=noise), step))
    assert found is not None
    assert found.step == pytest.approx(step, rel=1e-9)
    assert found.share == 1.0
    assert not found.floating


@pytest.mark.parametrize("step", [1.0, 15.0, 100.0, 3000.0])
def test_step_survives_later_arithmetic(step: float) -> None:
    values = rounded(series(2), step)
    rng = np.random.default_rng(3)
    scaled = find_lattice(1.0234 * values + 17.3)
    single = find_lattice((values / 1e3).astype(np.float32).astype(float) * 1e3)
    blurred = find_lattice(values + rng.normal(0, 0.02 * step, len(values)))
    assert scaled is not None
    assert scaled.step == pytest.approx(1.0234 * step, rel=1e-9)
    assert single is not None
    assert single.step == pytest.approx(step, rel=1e-6)
    assert blurred is not None
    assert blurred.step == pytest.approx(step, rel=1e-4)
    assert blurred.scatter == pytest.approx(0.02, rel=0.1)


@pytest.mark.parametrize("step", [15.0, 100.0, 3000.0])
def test_strays_lower_the_share_and_nothing_else(step: float) -> None:
    values, rng = rounded(series(4), step), np.random.default_rng(5)
    strays = rng.random(len(values)) < 0.03
    values[strays] += step * rng.uniform(0.25, 0.75, strays.sum())
    found = find_lattice(values)
    assert found is not None
    assert found.step == pytest.approx(step, rel=1e-6)
    assert found.share == pytest.approx(1 - strays.mean(), abs=1e-3)


def test_codes_that_are_skipped() -> None:
    """Few values far apart have the step as common divisor; all even codes have the doubled step."""
    rng = np.random.default_rng(6)
    few = 12.5 * rng.integers(-3000, 3000, 24)
    even = 30.0 * rng.integers(-1000, 1000, 500)
    found = find_lattice(few)
    assert found is not None
    assert found.step == pytest.approx(12.5)
    found = find_lattice(even)
    assert found is not None
    assert found.step == pytest.approx(30.0)


def test_single_precision_is_storage() -> None:
    found = find_lattice(series(7).astype(np.float32).astype(float))
    assert found is None or found.floating


def test_three_digits_are_storage() -> None:
    """A text with three significant digits: 1 nT near 500 nT, 100 nT near 50,000 nT."""
    values = np.array([float(f"{v:.3g}") for v in series(8)])
    found = find_lattice(values)
    assert found is None or found.floating or found.share < 1


def test_no_lattice_without_one() -> None:
    """False alarms: none in 300 recordings of any length, noise and motion."""
    for seed in range(300):
        rng = np.random.default_rng(seed)
        samples = int(rng.integers(1, 3000))
        values = rng.normal(0, 10 ** rng.uniform(-1, 4), samples) + rng.uniform(-5e4, 5e4)
        assert find_lattice(values) is None


@pytest.mark.parametrize("values", [[], [1.0], [1.0] * 50, [1.0, 2.0] * 50, [np.nan] * 5, [0.0, 0.0, 5.0, np.inf]])
def test_too_little_to_tell(values: list[float]) -> None:
    assert find_lattice(np.array(values)) is None


def test_the_share_of_odd_codes_takes_no_memory_for_codes_between() -> None:
    """Three codes 1e12 apart among codes whose odd neighbours are rare, as averaging leaves them, from -400 to 400."""
    rng = np.random.default_rng(3)
    codes = 2 * rng.integers(-200, 200, 20_000) + (rng.random(20_000) < 0.1)
    share = odd_share(np.concatenate([codes, [-(10**12), 0, 10**12]]))
    assert share == pytest.approx(0.1, abs=0.01)
