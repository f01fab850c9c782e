"""What follows the field between samples meets it at every step of the engine, whatever the sample rate."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sim.chain import Chain, continuous_part
from sim.effects import BY_NAME, Effects, build
from sim.memory_run import run_in_memory
from sim.motion_cache import MotionCache
from sim.scenario import Scenario, load
from sim.simulation import blocks, plan

LATE = ["effects.latency.delay_s=0.013", "effects.bandwidth.cutoff_hz=6"]
CORE = ["effects.hysteresis.gain=[0.02,0.01,0.03]", "effects.hysteresis.threshold_nT=[200,3000]"]


def flown(rate_hz: float, *changes: str) -> dict[str, Any]:
    """A minute of a quadrotor whose tilts oscillate within a sample."""
    scenario = load("quad-calibration", [f"sampling.rate_hz={rate_hz}", "effects.white_noise.std_nT=5", *changes])
    return joined(scenario.model_copy(update={"phases": scenario.phases[1:2]}))


def joined(scenario: Scenario) -> dict[str, Any]:
    pieces = list(blocks(plan(scenario)))
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


def label(columns: dict[str, Any], name: str) -> Any:
    return np.stack([columns[f"effect_{name}_{axis}_nT"] for axis in "xyz"], axis=1)


@pytest.mark.parametrize("name", ["latency", "bandwidth", "hysteresis"])
def test_half_the_sample_interval_changes_a_label_by_less_than_a_hundredth(name: str) -> None:
    coarse, fine = (label(flown(rate, *LATE, *CORE), name) for rate in (5.0, 10.0))
    n = len(coarse)
    assert np.abs(coarse - fine[::2][:n]).max() < 0.01 * np.abs(coarse).max()
    assert np.abs(coarse).max() > 10


def test_the_noise_is_neither_delayed_nor_smoothed() -> None:
    late, prompt = (flown(10.0, *changes) for changes in (LATE, []))
    assert (label(late, "white_noise") == label(prompt, "white_noise")).all()
    names = [key for key in late if key.startswith("effect_") and "white_noise" not in key]
    for axis in "xyz":
        clean = late[f"true_field_{axis}_nT"] + sum(late[key] for key in names if key.endswith(f"_{axis}_nT"))
        np.testing.assert_allclose(
            late[f"mag_{axis}_nT"] - clean, late[f"effect_white_noise_{axis}_nT"], rtol=0, atol=1e-9
        )


def test_the_motion_and_all_else_that_is_recorded_stay_as_they_are() -> None:
    late, prompt = (flown(5.0, *changes) for changes in (LATE, []))
    for key in prompt:
        if not key.startswith(("mag", "effect")) and key != "phase":
            assert late[key].tobytes() == prompt[key].tobytes(), key


def test_a_dive_ends_on_the_same_sample() -> None:
    dive = load("auv-dive", ["phases.0.to_depth_m=12"])
    bare = dive.model_copy(update={"phases": dive.phases[:1], "effects": Effects(), "effect_order": None})
    slow = bare.model_copy(update={"effects": Effects({"bandwidth": {"cutoff_hz": 1.0}})})
    late, prompt = joined(slow), joined(bare)
    assert (late["time_s"] == prompt["time_s"]).all()
    assert (late["true_pos_up_m"] == prompt["true_pos_up_m"]).all()


def test_a_flight_that_is_used_again_gives_the_same_bits() -> None:
    scenario = load("quad-calibration", ["sampling.rate_hz=5", *LATE])
    ready, flights = plan(scenario), MotionCache()
    runs = [run_in_memory(ready, motions)[0] for motions in (None, flights.motions(ready), flights.motions(ready))]
    assert all(run.mag_nT.tobytes() == runs[0].mag_nT.tobytes() for run in runs)
    other = plan(load("quad-calibration", ["sampling.rate_hz=5"]))
    assert not next(iter(flights.motions(other))).finer
    assert next(iter(flights.motions(ready))).finer


def test_noise_before_a_low_pass_is_noise_of_samples() -> None:
    tables = {"white_noise": {"std_nT": 5}, "bandwidth": {"cutoff_hz": 3}}
    assert continuous_part(build(tables, ["white_noise", "bandwidth"], "")) == 0
    assert continuous_part(build(tables, None, "")) == 1


def test_blocks_of_any_length_give_the_same(states: Any, cut: Any, active: Any) -> None:
    late = {name: active[name] for name, effect in BY_NAME.items() if effect.continuous}
    chain, state = build(late, None, ""), states(2000)
    fine, coarse = state, _every(state, 5)
    whole = Chain(chain, 1).apply(coarse, fine)[0]
    pieces = Chain(chain, 1)
    parts = [pieces.apply(cut(coarse, i, i + 100), cut(fine, 5 * i, 5 * i + 500))[0] for i in range(0, 400, 100)]
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def _every(state: Any, every: int) -> Any:
    rows = {
        key: getattr(state, key)[::every]
        for key in ("time_s", "pos_enu_m", "R_wb", "rate_rad_s", "field_nT", "field_rate_nT_s")
    }
    channels = {name: values[::every] for name, values in state.channels.items()}
    return replace(state, **rows, channels=channels, interval_s=every * state.interval_s)
