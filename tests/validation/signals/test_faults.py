"""Repeats, pile-up and spikes: found where injected, nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation.inspection.recordings import rounded, still, turning
from validation.signals.faults import pile_up, repeats, spikes
from validation.signals.lattice import Lattice, find_lattice

CONVERTERS = [(5.0, 0.0), (5.0, 1.0), (5.0, 15.0), (0.0, 15.0), (5.0, 60.0)]
"""Noise and least significant bit, nT."""


def lattices(values: np.ndarray) -> tuple[Lattice | None, ...]:
    return tuple(find_lattice(column) for column in values.T)


def measured(seed: int, noise: float, samples: int = 12_000, motion=turning) -> np.ndarray:  # type: ignore[no-untyped-def]
    field = motion(samples)[1]
    return field + np.random.default_rng(seed).normal(0, noise, field.shape)


@pytest.mark.parametrize(("noise", "step"), CONVERTERS)
def test_full_scale_is_found_at_its_level(noise: float, step: float) -> None:
    for seed in range(5):
        values = rounded(np.clip(measured(seed, noise), -45_000, 45_000), step)
        found = pile_up(values, lattices(values))
        assert found
        assert all(abs(abs(one.level) - 45_000) <= step / 2 for one in found)
        assert all(one.count == np.count_nonzero(values[:, one.axis] == one.level) for one in found)


@pytest.mark.parametrize(("noise", "step"), CONVERTERS)
def test_a_frozen_stretch_is_found_where_it_is(noise: float, step: float) -> None:
    for seed in range(5):
        values = rounded(measured(seed, noise), step)
        values[4000:4025] = values[4000]
        first, rows = repeats(values).frozen[0]
        assert abs(first - 4000) <= 1
        assert abs(rows - 25) <= 1


@pytest.mark.parametrize(("noise", "step"), CONVERTERS[:4])
def test_spikes_are_counted(noise: float, step: float) -> None:
    for seed in range(5):
        values, rng = measured(seed, noise), np.random.default_rng(seed)
        row, axis = rng.choice(np.arange(10, 11_990, 40), 20, replace=False), rng.integers(0, 3, 20)
        values[row, axis] += rng.choice([-1, 1], 20) * 300
        found = spikes(rounded(values, step), np.full(3, step))
        assert found[row, axis].all()
        assert found.sum() == 20


@pytest.mark.parametrize(("noise", "step"), [*CONVERTERS, (0.0, 100.0), (1.0, 100.0)])
@pytest.mark.parametrize("motion", [still, turning])
def test_nothing_where_there_is_nothing(motion, noise: float, step: float) -> None:  # type: ignore[no-untyped-def]
    """False alarms: none in 14 x 20 recordings."""
    for seed in range(20):
        values = rounded(measured(seed, noise, int(np.random.default_rng(seed).integers(20, 6000)), motion), step)
        assert not repeats(values).frozen
        assert pile_up(values, lattices(values)) == []
        assert not spikes(values, np.full(3, step)).any()


def test_a_stop_at_the_extreme_is_no_pile_up() -> None:
    """A turntable that stops where an axis has its greatest value, twice: the other axes stand still as well."""
    angle = np.interp(np.arange(3000), [0, 500, 1000, 1500, 2000, 2500, 3000], [-2, 0, 0, -2, 0, 0, 2])
    values = rounded(np.column_stack([3e4 * np.cos(angle), 3e4 * np.sin(angle), 1e4 * np.sin(angle)]), 100.0)
    assert pile_up(values, lattices(values)) == []


def test_a_jump_is_no_spike() -> None:
    values = measured(0, 5.0)
    values[6000:] += 500
    assert not spikes(values).any()


def test_a_channel_that_is_held() -> None:
    held = np.repeat(np.random.default_rng(0).normal(0, 1, (300, 2)), 12, axis=0)
    found = repeats(held)
    assert (found.hold, found.repeated, found.frozen) == (12, 300 * 11, ())


def test_a_held_channel_may_be_held_a_row_longer_now_and_then() -> None:
    """A new value every 12 rows, in one case of ten after 13."""
    rows = np.where(np.arange(300) % 10 == 9, 13, 12)
    found = repeats(np.repeat(np.random.default_rng(0).normal(size=(300, 3)), rows, axis=0))
    assert (found.hold, found.frozen) == (12, ())


@pytest.mark.parametrize("values", [np.zeros((0, 3)), np.zeros((1, 3)), np.zeros((3, 3)), np.ones((100, 3))])
def test_little_or_constant_data_show_no_fault(values: np.ndarray) -> None:
    assert pile_up(values, (None, None, None)) == []
    assert not spikes(values).any()
    assert not repeats(values).frozen
