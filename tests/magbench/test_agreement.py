"""What `inspect` says a recording suffices for is the status and the reason that `calibrate` gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import magbench
from recordings import Recording
from tests.validation.screening.tumbling import F_NT, tumble

CASES = sorted(
    path for path in (Path(__file__).parents[1] / "recordings" / "cases").glob("*.*") if path.suffix != ".md"
)
METHODS = ["sphere", "ellipsoid", "planar"]
DAILY = ((1, 39_000.0),)
"""Seed and strength of the test run, where every fault has a size; the nightly run takes all."""
SEEDS = [((seed, f), [pytest.mark.slow] * ((seed, f) not in DAILY)) for seed in range(5) for f in (F_NT, 39_000.0)]
FAULTS = ("none", "stuck", "sentinel", "clip", "wrap", "half", "few", "wild", "step", "room")


def check(data: Path | Recording, strength_nT: float) -> None:
    fits = magbench.calibrate(data, strength_nT, with_=METHODS)
    found = {one.name: one.value for one in magbench.inspect(data).findings}
    methods = [method for method in METHODS if f"enough_for_{method}" in found]
    assert methods
    stated = {one.name: one.value for one in magbench.inspect(data, strength_nT).findings}
    assert {m: found[f"enough_for_{m}"]["status"] for m in methods} == {m: fits[m].status.kind for m in methods}
    assert {m: stated[f"enough_for_{m}"]["reason"] for m in methods} == {m: fits[m].status.reason for m in methods}
    assert set(found["enough_for"]) & set(methods) == {m for m in methods if fits[m].status.kind == "ok"}


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.name)
def test_of_every_small_log(path: Path) -> None:
    try:
        check(path, F_NT)
    except magbench.InputError:
        pytest.skip("refused")


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize(("seed", "strength_nT"), [pytest.param(*one, marks=marks) for one, marks in SEEDS])
def test_of_disturbed_recordings(seed: int, fault: str, strength_nT: float) -> None:
    """The reference's strength scales the answer only."""
    check(disturbed(seed, fault), strength_nT)


def disturbed(seed: int, fault: str) -> Recording:
    recording = tumble(100 + seed)
    rng, mag_nT, time_s = np.random.default_rng(seed), recording.mag_nT, recording.time_s
    if fault == "stuck":
        mag_nT[60 + 100 * seed :, seed % 3] = mag_nT[60 + 100 * seed, seed % 3]
    elif fault == "sentinel":
        mag_nT[rng.integers(0, 600, 9), 1] = 99_999.0
    elif fault == "clip":
        np.clip(mag_nT, None, 45_000 + 3000 * seed, out=mag_nT)
    elif fault == "wrap":
        mag_nT[:] = (np.rint(mag_nT / 1.9) + 32_768) % 65_536 * 1.9
    elif fault == "half":
        keep = mag_nT[:, 2] > 20_000 + 5000 * seed
        mag_nT, time_s = mag_nT[keep], time_s[keep]
    elif fault == "few":
        mag_nT, time_s = mag_nT[:: 15 + 10 * seed], time_s[:: 15 + 10 * seed]
    elif fault == "wild":
        mag_nT[rng.integers(0, 600, 6)] += rng.normal(0, 3000, (6, 3))
    elif fault == "step":
        mag_nT[300:] += [1500 * seed, 500, 0]
    elif fault == "room":
        mag_nT += 300 * seed * np.sin(time_s / 7)[:, None]
    return Recording(time_s, mag_nT)
