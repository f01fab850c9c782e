"""Commands write pages whose figures no test here looks at."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _undrawn(undrawn: None) -> None:
    """No figures; what a module's own fixtures write before has them."""
