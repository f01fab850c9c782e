"""How many damaged files of each format are tried."""

from __future__ import annotations

import pytest

DAMAGED_FILES = pytest.mark.parametrize("files", [60, pytest.param(300, marks=pytest.mark.slow)])
"""A fifth of them in each run, all in the nightly run."""
