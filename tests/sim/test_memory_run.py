"""A run in memory is the run on disk, and a motion that is used again is the motion that was flown."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recordings import read_run
from scenarios.load import catalogue
from sim.dataset_writer import generate
from sim.memory_run import run_in_memory
from sim.motion_cache import MotionCache, motion_key, size_of
from sim.simulation import plan, true_motion
from sim.vehicles import VEHICLES, vehicle_for
from tests.short import short


def assert_same(one: Any, other: Any) -> None:
    """Equal to the bit and in the same order, arrays with the same layout."""
    if dataclasses.is_dataclass(one):
        for item in dataclasses.fields(one):
            assert_same(getattr(one, item.name), getattr(other, item.name))
    elif isinstance(one, dict):
        assert list(one) == list(other)
        for key, value in one.items():
            assert_same(value, other[key])
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape, one.strides) == (other.dtype, other.shape, other.strides)
        assert one.tobytes() == other.tobytes()
    else:
        assert one == other


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_a_run_in_memory_is_the_run_on_disk_to_the_bit(name: str, tmp_path: Path) -> None:
    """The second run, on a motion that the first has left."""
    scenario, flights = short(name), MotionCache()
    generate(scenario, tmp_path, runs=2, seed=3)
    run_in_memory(plan(scenario, 0, 3), flights.motions(plan(scenario, 0, 3)))
    ready = plan(scenario, 1, 3)
    for one, other in zip(run_in_memory(ready, flights.motions(ready)), read_run(tmp_path, run=1), strict=True):
        assert_same(one, other)


class Forbidden:
    """A source of random numbers that must not be asked."""

    def __getattr__(self, name: str) -> Any:
        raise AssertionError(f"draws {name}")


@pytest.mark.parametrize("kind", sorted(VEHICLES))
def test_a_flow_draws_random_numbers_only_where_the_vehicle_says_so(kind: str) -> None:
    vehicle = vehicle_for(VEHICLES[kind].table(kind=kind))
    assert not vehicle.random_flow
    vehicle.flow(100, Forbidden(), {})  # type: ignore[arg-type]


def test_with_gusts_every_run_is_its_own_flight() -> None:
    gusts, calm = short("quad-comb", "vehicle.gust_std_m_s=1"), short("quad-comb", "vehicle.gust_std_m_s=0")
    assert motion_key(plan(gusts, 0, 1)) != motion_key(plan(gusts, 1, 1)) != motion_key(plan(gusts, 1, 2))
    assert motion_key(plan(calm, 0, 1)) == motion_key(plan(calm, 1, 2))


def test_the_motions_that_were_asked_for_last_are_kept() -> None:
    slow, fast = (plan(short("auv-spiral", f"phases.0.turn_rate_deg_s={rate}")) for rate in (2, 4))
    flights = MotionCache(most_bytes=sum(size_of(motion) for motion in true_motion(slow)) * 3 // 2)
    first = list(flights.motions(slow))
    assert all(one is other for one, other in zip(flights.motions(slow), first, strict=True))
    list(flights.motions(fast))  # takes the other's place
    again = list(flights.motions(slow))
    assert not any(one is other for one, other in zip(again, first, strict=True))
    for one, other in zip(again, first, strict=True):
        assert_same(one, other)


def test_a_motion_that_is_too_large_is_flown_each_time() -> None:
    ready, flights = plan(short("auv-spiral")), MotionCache(most_bytes=1000)
    first, again = list(flights.motions(ready)), list(flights.motions(ready))
    assert not any(one is other for one, other in zip(again, first, strict=True))


def test_nobody_can_write_to_a_motion_that_others_use() -> None:
    (motion,) = MotionCache().motions(plan(short("tumble")))
    with pytest.raises(ValueError, match="read-only"):
        motion.R_wb[0] = 0.0
