"""The logs of the honesty bench are what they say: the truth fits them, and each disturbance is in them."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.honesty.bench import table
from benchmarks.honesty.logs import DISTURBANCES, log_of
from benchmarks.honesty.motion import largest_hole_deg, rocking, tumbling
from benchmarks.honesty.verdicts import Verdict


@pytest.mark.parametrize("kind", DISTURBANCES)
def test_a_log_is_the_same_for_its_seed_and_another_for_the_next(kind: str) -> None:
    one, again, next_one = (log_of(kind, seed).text() for seed in (3, 3, 4))
    assert one == again
    assert one != next_one


@pytest.mark.parametrize("seed", range(5))
def test_a_sound_log_lies_on_an_ellipsoid_about_its_offset(seed: int) -> None:
    log = log_of("sound", seed)
    centred = log.cells[:, 1:4] - log.offset_nT
    x, y, z = (centred / log.strength_nT).T
    columns = np.column_stack([x * x, y * y, z * z, x * y, x * z, y * z])
    rest = columns @ np.linalg.lstsq(columns, np.ones(len(x)), rcond=None)[0] - 1
    assert np.std(rest) < 0.01


def test_the_rates_are_those_of_the_attitude() -> None:
    """d(R_bw h)/dt = -omega x R_bw h."""
    for course in (
        tumbling(np.random.default_rng(1), 2000, 50.0),
        rocking(np.random.default_rng(1), 2000, 50.0, 25.0),
    ):
        seen = course.seen(np.array([0.3, 0.5, -0.8]))
        moved = np.diff(seen, axis=0) * 50.0
        expected = -np.cross(course.rate_rad_s, seen)[:-1]
        assert np.abs(moved - expected).max() < 0.03 * np.abs(expected).max()


def test_a_hole_is_as_wide_as_a_cap_without_directions() -> None:
    rng = np.random.default_rng(2)
    unit = rng.normal(size=(200_000, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    assert largest_hole_deg(unit[unit[:, 2] < np.cos(np.radians(50))]) == pytest.approx(50, abs=8)


def test_ok_beyond_the_claim_is_wrong_and_a_harmless_disturbance_needs_no_word() -> None:
    right = Verdict("short flicker", "ok", 1.0, 2.0, False, True, "")
    wrong = Verdict("short flicker", "ok", 1.0, 20.0, False, True, "")
    stuck = Verdict("stuck axis", "ok", 1.0, 2.0, False, True, "")
    assert [one.wrong for one in (right, wrong, stuck)] == [False, True, False]
    assert [one.explained for one in (right, wrong, stuck)] == [True, False, False]
    assert len(list(table([right, wrong, stuck]))) == 3
