"""In a checkout `magbench.sim` and `sim` are one module."""

from __future__ import annotations

import importlib
import sys

import pytest

from magbench.checkout import CheckoutFinder


@pytest.mark.parametrize("name", ["sim", "recordings.units", "calib.result", "validation.scoring", "scenarios.errors"])
def test_a_module_has_two_names_and_is_loaded_once(name: str) -> None:
    inside, plain = importlib.import_module(f"magbench.{name}"), importlib.import_module(name)
    assert inside is plain is sys.modules[name]
    assert plain.__spec__ is not None
    assert (plain.__name__, plain.__spec__.name) == (name, name)


@pytest.mark.parametrize("name", ["magbench.nowhere", "magbench.sim.nowhere", "magbench.json", "numpy.linalg", "sim"])
def test_nothing_else_is_found(name: str) -> None:
    assert CheckoutFinder().find_spec(name, None) is None
