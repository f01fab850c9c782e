"""A core whose magnetisation relaxes as the field goes on: no play, and not at rest before the run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.dataset import Recording
from sim.effects import BY_NAME
from sim.effects.nonlinear import ROUNDED, Hysteresis
from sim.state import Array
from tests.validation.diagnosis.synthetic import problem, recording, without_attitude
from validation.diagnosis.decision import first_forms, selection
from validation.diagnosis.decision.jointly import select_jointly
from validation.diagnosis.decision.selection import Selection

LIBRARY = {"hysteresis", "nonlinearity", "eddy_current", "hard_iron_drift", "offset_jump", "temperature_offset"}
FIELD_NT, WAY_NT = 47_434.0, 15_000.0
SHARE = 0.004


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
    (one,) = found.found
    assert (one.name, ROUNDED in one.evidence.candidate.forms) == (Hysteresis.name, True)
    assert found.after.clean


def test_by_plays_alone_it_is_not_found(relaxing: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(selection, "fuller", lambda ground, members: ())
    names = [one.name for one in _found(without_attitude(relaxing)).found]
    assert names != [Hysteresis.name], names


def test_a_form_is_looked_for_a_decade_wider_than_the_plain_effect(relaxing: Recording) -> None:
    posed = problem(relaxing)
    found = selection.Ground.of(posed)
    (one,) = first_forms.fuller(found, selection.proposed(posed, frozenset(BY_NAME) - LIBRARY))
    given = dict(one.candidate.nonlinear)
    assert given["rounded_threshold_nT"] == pytest.approx(10 * given["threshold_nT"])
