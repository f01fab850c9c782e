"""A few wrong values in a row are wrong; what lasts, or stands in a rest that is not quiet, is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.evidence.direct import direct_evidence
from recordings import Recording
from sim.effects.faults import Spikes
from tests.diagnosis.synthetic import FIELD_ENU_NT, HZ, NOISE_NT, problem, recording, without_attitude

FIRST = (400, 900, 1500, 2100, 3333)


def _with_bursts(samples: int, size_nT: float = 20 * NOISE_NT, rest_nT: float = 0.0) -> Recording:
    given = recording()
    mag_nT = given.mag_nT + rest_nT * np.sin(given.time_s)[:, None]
    for k, first in enumerate(FIRST):
        mag_nT[first : first + samples, k % 3] += size_nT * (-1) ** k
    return replace(given, mag_nT=mag_nT)


@pytest.mark.parametrize(("samples", "seen"), [(1, True), (2, True), (3, True), (4, True), (5, False)])
def test_wrong_values_are_seen_by_themselves_and_some_in_a_row(samples: int, seen: bool) -> None:
    (found,) = direct_evidence(problem(_with_bursts(samples))) or (None,)
    assert (found is not None) is seen
    if found is not None:
        assert isinstance(found.effect, Spikes)
        assert found.samples.sum() == pytest.approx(samples * len(FIRST), abs=2)
        assert found.effect.rate_hz == pytest.approx(len(FIRST) / 400, rel=0.5)


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_without_attitude_the_strength_shows_them(samples: int) -> None:
    posed = problem(without_attitude(_with_bursts(samples, 60 * NOISE_NT)))
    (found,) = direct_evidence(posed)
    assert isinstance(found.effect, Spikes)
    assert found.samples.sum() == pytest.approx(samples * len(FIRST), abs=samples)


@pytest.mark.parametrize("attitude_errs", [False, True])
def test_in_fast_turns_a_value_is_wrong_where_the_strength_shows_it(attitude_errs: bool) -> None:
    """At 10 Hz in a hand the raw values leap by thousands of nT; one attitude that errs leaves the strength alone."""
    t = np.arange(4000) / HZ
    turn = Rotation.from_euler("ZYX", np.column_stack([2 * np.sin(2.6 * t), 0.9 * np.sin(3.1 * t), np.cos(2.3 * t)]))
    off_nT = np.zeros((4000, 3))
    for k, at in enumerate(FIRST):
        off_nT[at, k % 3] = 40 * NOISE_NT
    shown = Rotation.from_rotvec(off_nT / np.linalg.norm(FIELD_ENU_NT) * attitude_errs) * turn
    noise_nT = np.random.default_rng(8).normal(size=(4000, 3), scale=NOISE_NT)
    mag_nT = turn.inv().apply(FIELD_ENU_NT) + noise_nT + off_nT * (not attitude_errs)
    given = replace(recording(), mag_nT=mag_nT, att_q=shown.as_quat()[:, [3, 0, 1, 2]])
    seen = direct_evidence(problem(given))
    assert [one.effect.name for one in seen] == ([] if attitude_errs else [Spikes.name])
    assert all(one.samples[list(FIRST)].all() for one in seen)


def test_what_is_far_from_a_rest_that_is_not_quiet_is_no_burst() -> None:
    assert direct_evidence(problem(_with_bursts(3, rest_nT=300 * NOISE_NT))) == []


def test_white_noise_has_no_burst() -> None:
    assert direct_evidence(problem(recording(20_000, noise_nT=5.0))) == []


def test_at_rest_some_values_in_a_row_may_be_what_was_switched() -> None:
    """A coil that is on for three samples is no failure; a single value is one still."""
    given = without_attitude(_with_bursts(3))
    field_nT = np.array([900.0, 2e4, -4e4]) + given.mag_nT - without_attitude(recording()).mag_nT
    at_rest = replace(given, mag_nT=field_nT + np.random.default_rng(5).normal(size=field_nT.shape, scale=NOISE_NT))
    assert problem(at_rest).still
    assert direct_evidence(problem(at_rest)) == []
