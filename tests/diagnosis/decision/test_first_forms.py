"""Effects that show in a fuller form alone: a core that relaxes as the field goes on, a bent course of temperature."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision.choice import Selection, residual_tests
from diagnosis.decision.forms import first_form_evidence
from diagnosis.decision.second_passes import select_jointly
from diagnosis.decision.selection import select
from diagnosis.evidence.baseline import Baseline
from diagnosis.library.candidates import propose_candidates
from recordings import Recording
from scenarios.arrays import Array
from sim.effects import BY_NAME
from sim.effects.nonlinearity import ROUNDED, Hysteresis
from sim.effects.temperature import TemperatureOffset
from tests.diagnosis.synthetic import COSTLY, NOISE_NT, problem, recording, without_attitude

LIBRARY = {"hysteresis", "nonlinearity", "eddy_current", "hard_iron_drift", "offset_jump", "temperature_offset"}
FIELD_NT, WAY_NT = 47_434.0, 15_000.0
SHARE = 0.004


def _any(baseline: Baseline, name: str) -> bool:
    return True


def _relaxing(given: Recording) -> Recording:
    """With ``dM = (H - M) |dH| / k`` on every axis, M far from H at the start, in place of the simulator's loop."""
    H = given.mag_nT
    M = H[0] + np.array([30_000.0, -20_000.0, 25_000.0])
    added = np.tile(M, (len(H), 1))
    for i in range(1, len(H)):
        M = M + (H[i] - M) * -np.expm1(-np.abs(H[i] - H[i - 1]) / WAY_NT)
        added[i] = M
    return replace(given, mag_nT=H + SHARE * (added - added.mean(axis=0)))


def _found(given: Recording) -> Selection:
    return select_jointly(problem(given), frozenset(BY_NAME) - LIBRARY)


@pytest.fixture(scope="module")
def relaxing() -> Recording:
    noise: Array = 40.0 * np.random.default_rng(1).normal(size=(3000, 3))
    made = _relaxing(recording(3000, noise_nT=1e-3))
    return replace(made, mag_nT=made.mag_nT + noise)


def test_a_core_that_relaxes_is_hysteresis(relaxing: Recording) -> None:
    found = _found(without_attitude(relaxing))
    (one,) = found.accepted
    assert (one.name, ROUNDED in one.evidence.candidate.forms) == (Hysteresis.name, True)
    assert found.after.clean


def test_a_form_is_looked_for_a_decade_wider_than_the_plain_effect(relaxing: Recording) -> None:
    posed = problem(relaxing)
    found = Baseline.of(posed)
    members = propose_candidates(posed, frozenset(BY_NAME) - {Hysteresis.name})
    (one,) = first_form_evidence(found, members, _any)
    given = dict(one.candidate.nonlinear)
    assert given["rounded_threshold_nT"] == pytest.approx(10 * given["threshold_nT"])


def _bent(lag_s: float, sigma: float = 1.5) -> Recording:
    """A run that warms up, offset ``k d + k2 d^2`` of a temperature felt late by a lag that is not listed."""
    given = recording(1500)
    time_s = given.time_s
    outside = 12 * (1 - np.exp(-time_s / 30)) + 2 * np.sin(0.13 * time_s + 1)
    felt = outside.copy()
    for i in range(1, len(felt)):
        felt[i] = felt[i - 1] + (outside[i] - felt[i - 1]) * -np.expm1(-(time_s[i] - time_s[i - 1]) / lag_s)
    d = (felt - 3)[:, None]
    added = d * np.array([1.0, -0.6, 0.5]) + d**2 / 10 * np.array([-0.6, 0.9, 0.8])
    return replace(given, temperature_degC=20 + outside, mag_nT=given.mag_nT + sigma * NOISE_NT * added / added.std())


def test_a_bent_course_of_temperature_felt_late_is_found() -> None:
    """By its slope alone it leaves so much colour that it gains less than is needed, whatever its size."""
    posed = problem(_bent(5.0))
    found = select(posed, COSTLY)
    assert ({one.name for one in found.accepted}, found.after.clean) == ({TemperatureOffset.name}, True)


@pytest.mark.parametrize(("temperature_degC", "asked"), [(lambda t: 20 + t / 30, False), (lambda t: 20 + t % 80, True)])
def test_the_curve_of_what_only_rises_is_not_asked_for(temperature_degC: Callable[[Array], Array], asked: bool) -> None:
    given = recording(1500)
    posed = problem(replace(given, temperature_degC=temperature_degC(given.time_s)))
    found = first_form_evidence(Baseline.of(posed), propose_candidates(posed), _any)
    assert (TemperatureOffset.name in {one.name for one in found}) is asked


@pytest.mark.parametrize("lag_s", [5.0, 17.0])
@pytest.mark.parametrize("walk_nT", [0.0, 2.0])
def test_a_curve_is_heard_where_it_leaves_nothing(lag_s: float, walk_nT: float) -> None:
    """Of a slow noise it would follow a part; at a listed lag it would leave something too."""
    given, steps = _bent(lag_s, 2.5), np.random.default_rng(0).normal(scale=walk_nT, size=(1500, 3))
    posed = problem(replace(given, mag_nT=given.mag_nT + steps.cumsum(axis=0)))

    def is_clean(after: Baseline, name: str) -> bool:
        return residual_tests(after, [name]).clean

    heard = first_form_evidence(Baseline.of(posed), propose_candidates(posed), is_clean)
    assert (TemperatureOffset.name in {one.name for one in heard}) is (walk_nT == 0)
