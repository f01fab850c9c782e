"""When the gap is large: parts of steady size, with phase and heading."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.validation.diagnosis.synthetic import problem, recording
from validation.diagnosis.evidence.when import Stretch, largest, parts_of
from validation.diagnosis.policy import STANDARD


@pytest.fixture(scope="module")
def posed():  # type: ignore[no-untyped-def]
    return problem()


def _noise(n: int, seed: int = 2):  # type: ignore[no-untyped-def]
    return np.random.default_rng(seed).normal(size=(n, 3))


def test_white_noise_is_one_part(posed) -> None:  # type: ignore[no-untyped-def]
    n = len(posed.state)
    counts = [len(parts_of(posed, _noise(n, seed))) for seed in range(30)]
    assert counts.count(1) >= 28
    assert largest(parts_of(posed, _noise(n)), STANDARD) is None


def test_a_part_with_twice_the_noise_is_found_within_a_cell(posed) -> None:  # type: ignore[no-untyped-def]
    n = len(posed.state)
    residual = _noise(n)
    residual[1000:1800] *= 2.0
    parts = parts_of(posed, residual)
    part = largest(parts, STANDARD)
    assert part is not None
    assert np.abs(np.subtract([part.stretch.from_s, part.stretch.to_s], [100.0, 180.0])).max() < 400.0 / 60
    assert part.rms_sigma == pytest.approx(2.0, rel=0.05)
    assert part.rms_nT == pytest.approx(2.0 * float(np.sqrt((posed.sigma_nT**2).mean())), rel=0.05)
    assert sum(one.stretch.share for one in parts) == pytest.approx(1.0)


def test_a_stretch_says_its_phases_and_a_steady_compass_heading() -> None:
    given = recording(1000)
    yaw = np.where(np.arange(1000) < 500, 0.0, np.arange(1000) * 0.05)
    east = Rotation.from_euler("Z", yaw[:, None])
    phase = np.where(np.arange(1000) < 490, "leg", "spiral")
    posed = problem(replace(given, att_q=east.as_quat()[:, [3, 0, 1, 2]], phase=phase))
    leg, turn = Stretch.of(posed, 0.0, 50.0), Stretch.of(posed, 50.0, 100.0)
    assert (leg.phase, leg.heading_deg) == ("leg", pytest.approx(90.0, abs=1e-6))
    assert (turn.phase, turn.heading_deg) == ("spiral", None)
    assert leg.words == "from 0 s to 50 s (phase leg, heading 90°, 50 % of the run)"
