"""The quadrotor's flight and its model, as the tests of the diagnosis have them."""

from __future__ import annotations

from tests.diagnosis.conftest import flight, model, own

__all__ = ["flight", "model", "own"]
