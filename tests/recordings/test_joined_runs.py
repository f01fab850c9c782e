"""Runs taken out of a file that they share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from recordings import read_recording, read_run
from recordings.joined_runs import separate_run
from recordings.manifest import file_of
from scenarios.errors import InputError
from sim.dataset_writer import generate
from sim.scenario import load

RUNS = 3


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """One dataset with a run a file, and again with two runs a file."""
    scenario = load("auv-fleet", ["phases.0.duration_s=60"])
    alone, joined = tmp_path_factory.mktemp("alone"), tmp_path_factory.mktemp("joined")
    generate(scenario, alone, runs=RUNS, seed=3)
    generate(scenario, joined, runs=RUNS, seed=3, runs_per_file=2)
    return alone, joined


@pytest.mark.parametrize("run", range(RUNS))
def test_a_separated_run_has_the_bytes_of_a_run_alone(places: tuple[Path, Path], run: int) -> None:
    alone, joined = places
    assert file_of(joined, run).read_bytes() == (alone / f"run-{run:05d}.parquet").read_bytes()


def test_recording_and_truth_are_those_of_the_run_alone(places: tuple[Path, Path]) -> None:
    alone, joined = places
    (recording, truth), (mag_nT, known) = read_run(joined, run=1), read_run(alone, run=1)
    np.testing.assert_array_equal(recording.mag_nT, mag_nT.mag_nT)
    assert truth.parameters == known.parameters
    assert not np.array_equal(recording.mag_nT, read_recording(joined, run=0).mag_nT)


def test_a_file_without_the_run_is_refused(places: tuple[Path, Path]) -> None:
    with pytest.raises(InputError, match="no run 2"):
        separate_run(places[1] / "runs-00000.parquet", 2)
