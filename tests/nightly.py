"""Values of a test of which the test run takes the first, and the nightly run all."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def first_daily(values: Iterable[Any], daily: int = 1) -> list[Any]:
    """The values as parameters, all but the first few marked slow: further seeds of what the first already shows."""
    return [pytest.param(value, marks=[pytest.mark.slow] * (k >= daily)) for k, value in enumerate(values)]
