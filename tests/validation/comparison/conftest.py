"""A comparison that is done in a second: a turntable's stops, two calibrators, two noises."""

from __future__ import annotations

import pytest

from scenarios.sweep import parse_sweep
from tests.short import short
from validation.calibrating.calibrator_entry import CalibratorEntry
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design


def small(*names: str, chosen: tuple[CalibratorEntry, ...] = ()) -> Design:
    """Calibrators, by default sphere and ellipsoid, on a short turn on the turntable at noises of 5 and 50 nT."""
    scenario = short("turntable-twelve-stops")
    sweep = parse_sweep("noise_std_nT=5,50", scenario)
    return Design.of(scenario, chosen or select_calibrators(names or ("sphere", "ellipsoid")), [sweep], seed=5)


@pytest.fixture
def design() -> Design:
    """The small comparison."""
    return small()
