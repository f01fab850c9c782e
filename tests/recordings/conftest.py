"""One simulated-looking run, as blocks and as files."""

from __future__ import annotations

import copy
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from recordings import Column, RunWriter, columns, run_metadata, schema
from recordings.columns import ATTITUDE, TRUE_ATTITUDE

Block = dict[str, NDArray[Any]]
EFFECTS = ("soft_iron", "hard_iron", "white_noise")
SCENARIO = {"name": "small", "field": {"enu_nT": [0.0, 20_000.0, -45_000.0]}, "effects": {"hard_iron": {"x_nT": 300.0}}}


def restrained() -> bool:
    """Whether permissions of files hold this user back: not on Windows, and not the superuser."""
    return hasattr(os, "geteuid") and os.geteuid() != 0


class Run:
    """A run of n samples with k sensors and m motors whose labels sum to the measured field."""

    def __init__(self, n: int = 400, sensors: int = 1, motors: int = 2, seed: int = 3) -> None:
        self.table: tuple[Column, ...] = columns(sensors=sensors, motors=range(1, motors + 1), effects=EFFECTS)
        rng = np.random.default_rng(seed)
        self.block: Block = {c.name: rng.normal(size=n) * 1e4 for c in self.table if c.group != "phase"}
        self.block["time_s"] = np.arange(n) * 0.02
        self.block["phase"] = np.where(np.arange(n) < n // 3, "comb", "descent")
        for q in (ATTITUDE, TRUE_ATTITUDE):
            norm = np.linalg.norm([self.block[name] for name in q], axis=0)
            self.block |= {name: self.block[name] / norm for name in q}
        for k in [""] if sensors == 1 else [str(i + 1) for i in range(sensors)]:
            for axis in "xyz":
                total = self.block[f"true_field_{axis}_nT"].copy()
                for effect in EFFECTS:
                    total += self.block[f"effect{k}_{effect}_{axis}_nT"]
                self.block[f"mag{k}_{axis}_nT"] = total

    def write(self, path: Path, step: int = 150, seed: int = 7, run: int = 0) -> None:
        """Write the run in blocks of `step` samples."""
        metadata = run_metadata(SCENARIO, seed, run, {"hard_iron": {"x_nT": 300.0}})
        with RunWriter(path, schema(self.table), metadata) as writer:
            for start in range(0, len(self.block["time_s"]), step):
                writer.write({name: values[start : start + step] for name, values in self.block.items()})


@pytest.fixture
def make_run() -> type[Run]:
    """For tests that choose the size of the run."""
    return Run


@pytest.fixture
def run() -> Run:
    """One magnetometer, two motors, 400 samples."""
    return Run()


@pytest.fixture
def scenario() -> dict[str, Any]:
    """The scenario that the runs' files name."""
    return copy.deepcopy(SCENARIO)
