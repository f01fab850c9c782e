"""A split dataset whose runs differ in a vector, a number of the motion, and their noise."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim.dataset_writer import generate
from tests.short import short

RUNS = 11
VARY = (
    "vary.'effects.hard_iron.offset_nT'.uniform=[-500.0, 500.0]",
    "vary.'phases.0.duration_s'.uniform=[40.0, 44.0]",
)


@pytest.fixture(scope="session")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eleven runs of a tumble, 80/10/10."""
    out = tmp_path_factory.mktemp("split") / "tumbles"
    generate(short("tumble", *VARY), out, runs=RUNS, split="80/10/10")
    return out
