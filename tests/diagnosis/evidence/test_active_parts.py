"""When the gap is large: parts of steady size, with phase and heading."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.evidence.active_parts import ActivePart, largest_part, split_by_power
from diagnosis.policy import STANDARD
from tests.diagnosis.synthetic import problem, recording, without_attitude


@pytest.fixture(scope="module")
def posed():  # type: ignore[no-untyped-def]
    return problem()


def _noise(n: int, seed: int = 2):  # type: ignore[no-untyped-def]
    return np.random.default_rng(seed).normal(size=(n, 3))


def test_white_noise_is_one_part(posed) -> None:  # type: ignore[no-untyped-def]
    n = len(posed.state)
    counts = [len(split_by_power(posed, _noise(n, seed))) for seed in range(30)]
    assert counts.count(1) >= 28
    assert largest_part(split_by_power(posed, 2 * _noise(n)), STANDARD) is None


def test_a_part_with_twice_the_noise_is_found_within_a_cell(posed) -> None:  # type: ignore[no-untyped-def]
    n = len(posed.state)
    residual = _noise(n)
    residual[1000:1800] *= 2.0
    parts = split_by_power(posed, residual)
    part = largest_part(parts, STANDARD)
    assert part is not None
    assert np.abs(np.subtract([part.from_s, part.to_s], [100.0, 180.0])).max() < 400.0 / 60
    assert part.rms_sigma == pytest.approx(2.0, rel=0.05)
    assert part.rms_nT == pytest.approx(2.0 * float(np.sqrt((posed.sigma_nT**2).mean())), rel=0.05)
    assert sum(one.share for one in parts) == pytest.approx(1.0)


def test_a_stretch_says_its_phases_and_a_steady_compass_heading() -> None:
    given = recording(1000)
    yaw = np.where(np.arange(1000) < 500, 0.0, np.arange(1000) * 0.05)
    east = Rotation.from_euler("Z", yaw[:, None])
    phase = np.where(np.arange(1000) < 490, "transit", "spiral")
    posed = problem(replace(given, att_q=east.as_quat()[:, [3, 0, 1, 2]], phase=phase))
    leg, turn = ActivePart.of(posed, 0.0, 50.0), ActivePart.of(posed, 50.0, 100.0)
    assert (leg.phase, leg.heading_deg) == ("transit", pytest.approx(90.0, abs=1e-6))
    assert (turn.phase, turn.heading_deg) == ("spiral", None)
    assert leg.words == "from 0 s to 50 s (phase transit, heading 90°, 50 % of the run)"
    assert ActivePart.of(posed, 0.0, 100.0).phase == "transit, spiral"
    assert ActivePart.of(problem(without_attitude(recording(1000))), 0.0, 50.0).heading_deg is None


def test_a_burst_is_no_part(posed) -> None:  # type: ignore[no-untyped-def]
    residual = _noise(len(posed.state))
    residual[1000:1040] *= 10.0
    assert min(one.share for one in split_by_power(posed, residual)) >= STANDARD.least_part


@pytest.mark.parametrize(("louder", "share"), [(200, 0.05), (80, 0.04)])
def test_a_part_is_a_twenty_fifth_of_the_run_at_least(posed, louder: int, share: float) -> None:  # type: ignore[no-untyped-def]
    """What is louder for less has its part in quiet."""
    residual = _noise(len(posed.state))
    residual[1000 : 1000 + louder] *= 5.0
    part = largest_part(split_by_power(posed, residual), STANDARD)
    assert part is not None
    assert part.share == pytest.approx(share, abs=0.009)


@pytest.mark.parametrize(("share", "words"), [(0.08, "transit"), (0.12, "transit, spiral")])
def test_a_phase_of_a_tenth_of_a_stretch_is_one_of_its_phases(share: float, words: str) -> None:
    phase = np.where(np.arange(1000) < 1000 * (1 - share), "transit", "spiral")
    assert ActivePart.of(problem(replace(recording(1000), phase=phase)), 0.0, 100.0).phase == words


@pytest.mark.parametrize("some", [0.0, 0.03, 0.6, 1.0])
def test_samples_left_out_change_no_size(posed, some: float) -> None:  # type: ignore[no-untyped-def]
    """Of half of the run a share is there."""
    n = len(posed.state)
    there = (np.random.default_rng(1).random(n) < some) | (np.arange(n) >= n / 2)
    parts = split_by_power(replace(posed, usable=there.astype(float)), _noise(n) * there[:, None])
    assert [one.rms_sigma for one in parts] == pytest.approx([1.0], rel=0.03)


def test_a_run_of_few_samples_may_have_no_part(posed) -> None:  # type: ignore[no-untyped-def]
    n = len(posed.state)
    for first, whole in ((n - 200, 1.0), (n - 20, 0.0)):
        there = np.arange(n) >= first
        parts = split_by_power(replace(posed, usable=there.astype(float)), _noise(n) * there[:, None])
        assert sum(one.share for one in parts) == pytest.approx(whole)


@pytest.mark.parametrize(
    ("sizes", "far"),
    [
        (((1.2, 0.1), (1.0, 0.9)), True),
        (((1.02, 0.1), (1.0, 0.9)), False),
        (((2.2, 0.1), (2.0, 0.9)), False),
        (((3.0, 0.1), (2.0, 0.1), (1.0, 0.8)), True),
        (((2.0, 0.1), (1.5, 0.8), (1.0, 0.1)), False),
        (((1.4, 0.1), (1.2, 0.4), (0.8, 0.5)), True),
    ],
)
def test_a_part_is_far_larger_by_its_power_beyond_the_noise(sizes, far) -> None:  # type: ignore[no-untyped-def]
    """Over that of the rest, each part by its length; what is next to nothing is not divided by."""
    parts = tuple(ActivePart(0.0, 1.0, share, None, None, size, size) for size, share in sizes)
    assert (largest_part(parts, STANDARD) is parts[0]) is far
