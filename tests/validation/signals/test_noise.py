"""Slow noise against white, Allan deviation against allantools."""

from __future__ import annotations

import allantools
import numpy as np
import pytest

from tests.validation.inspection.recordings import RATE_HZ
from validation.signals.noise import allan_deviation, block_means


@pytest.mark.parametrize("samples", [0, 1, 3, 11])
def test_too_few_samples_give_no_blocks(samples: int) -> None:
    values = np.zeros((samples, 3))
    assert block_means(np.arange(samples, dtype=float), values) == []


def test_white_noise_has_no_excess() -> None:
    """False alarms of `excess > chance()`, over 80 recordings, 3 lengths and 3 axes: one recording at most."""
    alarms = 0
    for seed in range(80):
        rng = np.random.default_rng(seed)
        samples = int(rng.integers(500, 20_000))
        found = block_means(np.arange(samples) / RATE_HZ, rng.normal(0, 5, (samples, 3)))
        alarms += any((blocks.excess > blocks.chance()).any() for blocks in found)
    assert alarms <= 1


def test_slow_noise_has_the_excess_of_its_own_variance() -> None:
    """Blocks of 5 s of white noise 5 nT and a sine of 0.5 nT in 200 s: sqrt(1 + 0.125 n / 25)."""
    rng = np.random.default_rng(2)
    time_s = np.arange(100_000) / RATE_HZ
    slow = 0.5 * np.sin(2 * np.pi * time_s / 200)
    found = {b.length_s: b for b in block_means(time_s, rng.normal(0, 5, (100_000, 3)) + slow[:, None])}
    np.testing.assert_allclose(found[5.0].excess, np.sqrt(1 + 0.125 * 250 / 25), rtol=0.15)
    assert (found[20.0].excess > found[20.0].chance()).all()
    assert found[5.0].blocks == 400
    assert found[5.0].samples == 250


def test_blocks_across_a_gap_are_left_out() -> None:
    time_s = np.r_[0 : 100 : 1 / RATE_HZ, 103.5 : 200 : 1 / RATE_HZ]
    found = block_means(time_s, np.random.default_rng(3).normal(0, 1, (len(time_s), 1)), (5.0,))
    assert found[0].blocks == 39


def test_allan_deviation_is_that_of_allantools() -> None:
    values = np.cumsum(np.random.default_rng(4).normal(0, 1, (5000, 2)), axis=0)
    tau_s, deviation = allan_deviation(1 / RATE_HZ, values)
    for axis in range(2):
        theirs = allantools.oadev(values[:, axis], rate=RATE_HZ, data_type="freq", taus=tau_s)
        np.testing.assert_allclose(tau_s, theirs[0])
        np.testing.assert_allclose(deviation[:, axis], theirs[1], rtol=1e-6)
