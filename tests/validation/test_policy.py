"""Numbers that decide in `signals`, `screening` and `inspection` stand in the policy, with words, and are used."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from tests.bare_numbers import compared, constants
from tests.conftest import ROOT
from validation.policy import POLICY, InspectionPolicy
from validation.signals import faults
from validation.signals.faults import spikes

ROOMS = ("signals", "screening", "inspection")
FILES = sorted(path for room in ROOMS for path in (ROOT / "validation" / room).glob("*.py"))
GUARDS = {
    "bands.py": {"WINDOW_LINES", "LEAST_WHITE"},
    "fault.py": {"MOST_STRETCHES"},
    "faults.py": {"NOISE_WINDOW", "NOISE_BLOCK", "STENCIL", "LONGEST_SLOPE"},
    "frames.py": {"GYRO_UNITS", "LEAST_TOLD_DEG"},
    "lattice.py": {"SINGLE_PRECISION", "GROUP", "SAME_DISTANCE", "MOST_DIFFERENCES", "NEAREST", "GCD_TOLERANCES"},
    "log.py": {"LATEST_S"},
    "neighbours.py": {"PLACES", "MOST_SAMPLES"},
    "offset_steps.py": {"LARGE", "NORMAL_90", "NORMAL_HALF", "SIDE"},
    "quaternion_conventions.py": {"BASELINE_S", "FINE_LAG"},
    "sentinel.py": {"MOST"},
    "spectra.py": {"MOST_LISTED"},
    "sphere.py": {"BAND_DEG", "THINNED", "BLOCK", "ROUNDING"},
    "timing.py": {"SLOW_S", "MOST_LISTED", "RESOLUTION_DIGITS"},
    "tones.py": {"MAINS_HZ", "HARMONICS", "NEIGHBOURHOOD", "NARROWER", "MOST_TONES"},
    "units.py": {"USUAL_NT"},
    "values.py": {"MOST_COLUMNS", "MOST_LISTED"},
    "wrapped.py": {"BITS"},
}
"""Constants that decide nothing: units, physics, efforts and scales of a computation, and how much is listed."""
COUNTS = {0, 1, 2, 3, 0.5}
"""Numbers that may be compared with: signs, shapes, whether there are several; half of all codes are odd."""
SHARED = ("still_spread", "mean_lengths_s")
"""Numbers of the diagnosis with the same meaning here."""


@pytest.mark.parametrize("path", FILES, ids=lambda p: f"{p.parent.name}/{p.name}")
def test_no_number_that_decides_stands_elsewhere(path: Path) -> None:
    assert constants(path) <= GUARDS.get(path.name, set())
    assert compared(path) <= COUNTS


def test_every_number_has_its_words_and_is_used() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in FILES)
    for one in fields(InspectionPolicy):
        assert len(one.metadata["meaning"].split()) >= 4, one.name
        assert one.metadata["alarms"], one.name
        assert one.metadata["run"], one.name
        assert f"POLICY.{one.name}" in text, one.name


def test_every_guard_stands_where_it_is_listed() -> None:
    found = {path.name: constants(path) for path in FILES}
    assert all(names <= found[name] for name, names in GUARDS.items())


def test_a_number_of_the_diagnosis_has_its_home_here() -> None:
    here = {one.name: one for one in fields(InspectionPolicy)}
    there = {one.name: one for one in fields(STANDARD)}
    for name in SHARED:
        assert (there[name].default, there[name].metadata) == (here[name].default, here[name].metadata)


def test_a_stricter_policy_finds_fewer_spikes(monkeypatch: pytest.MonkeyPatch) -> None:
    values = np.random.default_rng(0).normal(0, 5, (1000, 3))
    values[500, 1] += 100.0
    assert spikes(values).sum() == 1
    monkeypatch.setattr(faults, "POLICY", replace(POLICY, spike_sigma=100.0))
    assert not spikes(values).any()
