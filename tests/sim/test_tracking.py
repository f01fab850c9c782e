"""Whether a vehicle follows its path is measured, kept with the run and told when it does not."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from magbench.cli import main
from recordings import read_manifest, read_run, run_file, run_path
from recordings.manifest import MANIFEST
from recordings.metadata import Tracking
from scenarios.load import catalogue
from sim.dataset_writer import generate
from sim.tracking import LIMIT_M, together, warning
from tests.short import cuts, short

STORM = "vehicle.wind_enu_m_s=[100,0,0]"


def test_it_is_the_distance_from_the_circle_at_the_same_time(tmp_path: Path) -> None:
    """Hovering after its run-in, the reference is a point: the distance is seen in the true position alone."""
    scenario = short("quad-spiral", STORM, 'phases.0={kind="hover",duration_s=20,run_in_s=2}')
    tracking = generate(scenario, tmp_path).files[0].tracking
    assert tracking is not None
    recording, truth = read_run(tmp_path)
    settled = recording.time_s > 2.0
    apart_m = np.linalg.norm(truth.pos_enu_m - truth.pos_enu_m[0], axis=1)[settled]
    np.testing.assert_allclose([tracking.rms_m, tracking.max_m], [np.sqrt(np.mean(apart_m**2)), apart_m.max()])
    assert warning([tracking])


@pytest.mark.parametrize("name", catalogue())
def test_every_vehicle_of_the_catalogue_follows_its_path(name: str, tmp_path: Path) -> None:
    tracking = generate(short(name), tmp_path).files[0].tracking
    assert (tracking is None) == (short(name).vehicle.kind == "turntable")
    assert not warning([tracking])


def test_an_unpowered_dive_follows_no_path(tmp_path: Path) -> None:
    dive = short("auv-dive", 'phases=[{kind="descent",to_depth_m=8}]')
    assert generate(dive, tmp_path).files[0].tracking is None


def test_file_and_manifest_say_the_same_and_so_does_a_dataset_that_is_resumed(tmp_path: Path) -> None:
    scenario = short("quad-spiral")
    told = generate(scenario, tmp_path, runs=2).files
    assert told == read_manifest(tmp_path).files == tuple(run_file(run_path(tmp_path, run), run) for run in (0, 1))
    (tmp_path / "run-00001.parquet").unlink()
    assert generate(scenario, tmp_path, runs=2).files == told


def test_a_manifest_without_it_is_read(tmp_path: Path) -> None:
    generate(short("quad-spiral"), tmp_path)
    manifest = json.loads((tmp_path / MANIFEST).read_text())
    del manifest["files"][0]["tracking"]
    (tmp_path / MANIFEST).write_text(json.dumps(manifest))
    assert read_manifest(tmp_path).files[0].tracking is None


def test_several_runs_together() -> None:
    assert together([None, Tracking(3.0, 5.0), Tracking(4.0, 4.5)]) == Tracking(np.sqrt(12.5), 5.0)
    assert together([None]) is None
    assert "in 1 of 3 runs" in warning([None, Tracking(0.5 * LIMIT_M, LIMIT_M), Tracking(1.0, 1.1 * LIMIT_M)])


@pytest.mark.parametrize("command", ["simulate", "run"])
def test_one_line_and_json_tell_of_a_vehicle_that_is_blown_away(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sets = [text for cut in (*cuts("quad-spiral"), STORM) for text in ("--set", cut)]
    assert main([command, "quad-spiral", "-o", str(tmp_path), "--json", *sets]) == 0
    out, err = capsys.readouterr()
    (told,) = [line for line in err.splitlines() if line.startswith("magbench: ")]
    assert "does not follow its path" in told
    tracking = read_manifest(tmp_path).files[0].tracking
    assert tracking is not None
    assert json.loads(out)["tracking"] == asdict(tracking)
    if command == "run":
        assert "does not follow its path" in (tmp_path / "report.html").read_text()
