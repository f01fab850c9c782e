"""A bound without noise, or in no field at all, is refused in words."""

from __future__ import annotations

import pytest

import magbench
from scenarios.errors import InputError

SHORT = "turntable-twelve-stops"


def test_a_simulation_without_noise_has_no_bound() -> None:
    with pytest.raises(InputError, match="no white noise"):
        magbench.bound(SHORT, overrides=["effects.white_noise.std_nT=0"])


def test_a_zero_field_has_no_bound() -> None:
    with pytest.raises(InputError, match="the field is zero"):
        magbench.bound("standard-full", overrides=["field.enu_nT=[0,0,0]"])
