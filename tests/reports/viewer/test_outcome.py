"""The rerun recording: valid, complete, and the same numbers when read back."""

from __future__ import annotations

import dataclasses
import resource
import time
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from reports.viewer import FULL, Detail, read_series, verify, write_recording
from reports.viewer.outcome import busiest
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.vehicles import VEHICLES
from sim.vehicles.turntable import Turntable, TurntableSpec
from tests.reports import outcome_example as example
from validation.scoring.outcome import Outcome


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    whole: Outcome = example.example_outcome(2000, sensors=2)
    mag_nT = whole.recording.mag_nT.copy()
    mag_nT[100:110] = np.nan
    corrected = whole.corrected | {"pack.mod:mine": whole.corrected["sphere"] + 1 / 3}
    calibrations = whole.calibrations | {"pack.mod:mine": dataclasses.replace(whole.calibrations["sphere"])}
    recording = dataclasses.replace(whole.recording, mag_nT=mag_nT)
    return dataclasses.replace(whole, recording=recording, corrected=corrected, calibrations=calibrations)


@pytest.fixture(scope="module")
def path(outcome: Outcome, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "recording.rrd"
    write_recording(outcome, path)
    assert [p.name for p in path.parent.iterdir()] == ["recording.rrd"]
    return path


def test_verifies(path: Path, tmp_path: Path) -> None:
    verify(path)
    cut = tmp_path / "cut.rrd"
    cut.write_bytes(path.read_bytes()[:50_000])
    with pytest.raises(InputError, match=r"cut\.rrd"):
        verify(cut)
    with pytest.raises(InputError):
        verify(tmp_path / "none.rrd")


def test_the_camera_looks_at_the_phase_that_turns_most(outcome: Outcome) -> None:
    """Two thirds of the time a descent at 0.01 rad/s, then turns at 0.1 rad/s."""
    n = len(outcome.recording)
    first = 2 * n // 3
    phase = np.where(np.arange(n) < first, "descent", "turns")
    rate_rad_s = np.where(np.arange(n) < first, 0.01, 0.1)[:, None] * [0.0, 0.0, 1.0]
    recording = dataclasses.replace(outcome.recording, phase=phase, gyro_rad_s=rate_rad_s)
    assert busiest(dataclasses.replace(outcome, recording=recording)) == slice(first, n)
    blind = dataclasses.replace(recording, gyro_rad_s=None)
    assert busiest(dataclasses.replace(outcome, recording=blind)) == slice(None)


def _expected(outcome: Outcome) -> dict[str, Array]:
    recording, truth = outcome.recording, outcome.truth
    assert recording.temperature_degC is not None
    assert recording.current_A is not None
    return {
        "mag": recording.mag_nT,
        "true_field": truth.field_nT,
        "temperature": recording.temperature_degC,
        "current": recording.current_A,
        **{f"effects/{name}": value for name, value in outcome.effects.items()},
        **{f"corrected/{name}": value for name, value in outcome.corrected.items()},
        **{f"residual/{name}": outcome.residual_nT(name) for name in outcome.corrected},
        "norm/raw": np.linalg.norm(recording.mag_nT, axis=1),
        "norm/truth": np.linalg.norm(truth.field_nT, axis=1),
    }


def test_reading_back_gives_the_same_numbers(outcome: Outcome, path: Path) -> None:
    for entity, values in _expected(outcome).items():
        time_s, back = read_series(path, entity)
        assert back.dtype == np.float64
        assert np.array_equal(back, values, equal_nan=True), entity
        assert np.max(np.abs(time_s - outcome.recording.time_s)) <= 1e-9


def test_a_thinned_series_keeps_the_extremes(outcome: Outcome, tmp_path: Path) -> None:
    write_recording(outcome, tmp_path / "thin.rrd", Detail(samples=100, poses=50))
    time_s, back = read_series(tmp_path / "thin.rrd", "mag")
    assert len(time_s) <= 100
    assert np.array_equal(np.nanmax(back, axis=0), np.nanmax(outcome.recording.mag_nT, axis=0))
    assert np.array_equal(np.nanmin(back, axis=0), np.nanmin(outcome.recording.mag_nT, axis=0))
    assert len(read_series(tmp_path / "thin.rrd", "residual/sphere")[0]) <= 100


def test_unknown_series_lists_the_others(path: Path) -> None:
    with pytest.raises(InputError, match=r"effects/hard_iron.*true_field"):
        read_series(path, "effects/hard_irno")


def test_holds_a_layout_notes_and_properties(path: Path) -> None:
    reader = RrdReader(path)
    assert len(reader.blueprints()) == 1
    assert [store.application_id for store in reader.recordings()] == ["magbench_auv-example"]
    chunks = {c.entity_path: c.to_record_batch() for c in reader.stream().to_chunks()}
    notes = chunks["/notes"].column("TextDocument:text").to_pylist()[0][0]
    assert "sphere" in notes
    assert example.FAILURE in notes
    assert "shows sensor 1" in notes
    about = chunks["/__properties/scenario"].to_pydict()
    assert any(value == [[7]] for key, value in about.items() if key.endswith("seed"))
    assert any(value == [["auv-example"]] for key, value in about.items() if key.endswith("name"))


def test_vehicle_path_and_clouds_are_there(path: Path) -> None:
    entities = {c.entity_path for c in RrdReader(path).stream().to_chunks()}
    world = ("place", "place/vehicle", "place/vehicle/hull", "place/vehicle/field/measured", "path/001_spiral")
    assert {f"/world/{name}" for name in world} <= entities
    assert {f"/cloud/{name}" for name in ("raw", "reference", "now", "corrected/sphere")} <= entities


def test_poses_are_the_true_ones(outcome: Outcome, path: Path) -> None:
    chunks = RrdReader(path).stream().filter(is_static=False).to_chunks()
    batch = {c.entity_path: c.to_record_batch() for c in chunks}
    moved = np.array(batch["/world/place"].column("Transform3D:translation").to_pylist())[:, 0]
    turned = np.array(batch["/world/place/vehicle"].column("Transform3D:quaternion").to_pylist())[:, 0]
    np.testing.assert_allclose(moved, outcome.truth.pos_enu_m, atol=1e-4)
    np.testing.assert_allclose(turned[:, [3, 0, 1, 2]], outcome.truth.q, atol=1e-6)


@pytest.mark.parametrize("name", VEHICLES)
def test_every_vehicle_is_recorded_with_its_solids(name: str, tmp_path: Path) -> None:
    vehicle = VEHICLES[name](VEHICLES[name].table(kind=name))
    write_recording(example.example_outcome(300, vehicle=name), tmp_path / "r.rrd")
    verify(tmp_path / "r.rrd")
    drawn = {c.entity_path.rpartition("/")[2] for c in RrdReader(tmp_path / "r.rrd").stream().to_chunks()}
    assert {geom.name for geom in vehicle.geoms()} <= drawn


def test_gimbals_compose_to_the_tables_attitude() -> None:
    """Outer frame: yaw alone; middle: yaw and pitch; the table differs from it by roll about its own x axis."""
    truth = example.example_outcome(500, vehicle="turntable").truth
    turns = Turntable(TurntableSpec(kind="turntable")).turns(truth.q)
    table, middle, outer = (example._matrices(q) for q in turns.values())
    np.testing.assert_allclose(outer[:, :, 2], np.tile([0, 0, 1], (500, 1)), atol=1e-12)
    np.testing.assert_allclose(middle[:, :, 0], table[:, :, 0], atol=1e-9)
    np.testing.assert_allclose(middle[:, :, 1], outer[:, :, 1], atol=1e-12)


def test_failure_leaves_nothing(outcome: Outcome, tmp_path: Path) -> None:
    broken = dataclasses.replace(outcome, corrected={"sphere": np.zeros((7, 3))})
    with pytest.raises(ValueError, match="same length"):
        write_recording(broken, tmp_path / "r.rrd")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("room", [10_000, 100_000, 0.5, 0.999])
def test_a_full_disk_is_told_and_leaves_nothing(room: float, outcome: Outcome, path: Path, tmp_path: Path) -> None:
    most = int(room * path.stat().st_size) if room < 1 else int(room)
    whole = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, whole[1]))
    try:
        with pytest.raises(InputError, match=r"recording\.rrd: file too large"):
            write_recording(outcome, tmp_path / "recording.rrd")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, whole)
    assert not list(tmp_path.iterdir())


def test_switched_off_by_the_environment(outcome: Outcome, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(InputError, match="RERUN"):
        write_recording(outcome, tmp_path / "recording.rrd")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_long_recordings_stay_workable(tmp_path: Path) -> None:
    """500 000 samples: every one in a few seconds, at most 45 bytes a sample and vector; thinned, 25 MB."""
    outcome = example.example_outcome(500_000, duration_s=10_000.0)
    began = time.perf_counter()
    write_recording(outcome, tmp_path / "r.rrd", FULL)
    assert time.perf_counter() - began < 60
    vectors = 2 + len(outcome.effects) + len(outcome.corrected) + 2
    assert (tmp_path / "r.rrd").stat().st_size < 45 * 500_000 * vectors + 60e6
    assert np.array_equal(read_series(tmp_path / "r.rrd", "mag")[1], outcome.recording.mag_nT)
    write_recording(outcome, tmp_path / "thinned.rrd")
    assert (tmp_path / "thinned.rrd").stat().st_size < 25e6
