"""Whole runs of every scenario: labels that sum, truths that agree with each other, noise that is as stated."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from recordings import Recording, Truth, read_run
from scenarios.errors import InputError
from scenarios.load import catalogue
from sim.dataset_writer import generate
from sim.effects import build
from sim.effects.currents import EddyCurrent
from sim.rotation import matrix_from_q, multiply_q, to_body
from sim.simulation import plan
from sim.vehicles.quadrotor import Quadrotor
from tests.short import short

NAMES = sorted(catalogue())


@pytest.fixture(scope="module", params=NAMES)
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, Truth]:
    out = tmp_path_factory.mktemp(request.param)
    generate(short(request.param), out)
    return read_run(out)


def test_truth_and_labels_sum_to_the_measurement(run: tuple[Recording, Truth]) -> None:
    recording, truth = run
    mag = recording.mag_nT if recording.array_mag_nT is None else recording.array_mag_nT
    assert np.abs(truth.field_nT + sum(truth.effects.values()) - mag).max() < 1e-6


def test_every_effect_of_the_scenario_has_a_label(run: tuple[Recording, Truth]) -> None:
    _, truth = run
    named = {name for tables in truth.parameters["effects"] for name in tables}
    assert set(truth.effects) == named
    assert list(truth.effects) == list(truth.parameters["effect_order"])


def test_true_field_is_the_earths_turned_by_the_true_attitude(run: tuple[Recording, Truth]) -> None:
    _, truth = run
    expected = to_body(matrix_from_q(truth.q), np.array([truth.parameters["field_enu_nT"]]))
    np.testing.assert_allclose(truth.field_nT, expected, rtol=1e-12, atol=1e-9)


def test_time_is_an_even_grid_through_all_phases(run: tuple[Recording, Truth]) -> None:
    recording, _ = run
    interval = np.diff(recording.time_s)
    np.testing.assert_allclose(interval, interval[0], rtol=0, atol=1e-9)


def test_the_gyro_is_the_rate_of_the_true_attitude(run: tuple[Recording, Truth]) -> None:
    recording, truth = run
    interval = recording.time_s[1] - recording.time_s[0]
    if interval > 0.1:
        pytest.skip("sampled too coarsely to differentiate the attitude")
    R = matrix_from_q(truth.q)
    step = np.swapaxes(R[:-1], 1, 2) @ R[1:]
    turned = 0.5 * np.stack(
        [step[:, 2, 1] - step[:, 1, 2], step[:, 0, 2] - step[:, 2, 0], step[:, 1, 0] - step[:, 0, 1]], 1
    )
    assert recording.gyro_rad_s is not None
    middle = 0.5 * (recording.gyro_rad_s[1:] + recording.gyro_rad_s[:-1])
    error = middle - turned / interval
    assert np.abs(error.mean(axis=0)).max() < 2e-3  # bias of 1e-4, and the noise's mean
    assert np.sqrt((error**2).mean()) < 0.01


def test_eddy_currents_follow_the_rate_of_the_true_field(run: tuple[Recording, Truth]) -> None:
    recording, truth = run
    given = [tables[EddyCurrent.name] for tables in truth.parameters["effects"] if EddyCurrent.name in tables]
    if not given:
        pytest.skip("no eddy currents")
    rate_nT_s = np.gradient(truth.field_nT, recording.time_s, axis=0)[1:-1]
    matrix_s = np.linalg.lstsq(rate_nT_s, truth.effects[EddyCurrent.name][1:-1], rcond=None)[0].T
    np.testing.assert_allclose(matrix_s, given[0]["matrix_s"], atol=5e-4)


def test_the_accelerometer_feels_gravity_and_nothing_else_on_average(run: tuple[Recording, Truth]) -> None:
    recording, truth = run
    assert recording.accel_m_s2 is not None
    up = matrix_from_q(truth.q) @ recording.accel_m_s2[:, :, None]
    np.testing.assert_allclose(up[:, :, 0].mean(axis=0), [0.0, 0.0, 9.81], atol=0.3)


def test_navigation_is_off_by_its_stated_errors(run: tuple[Recording, Truth]) -> None:
    recording, truth = run
    assert recording.att_q is not None
    assert recording.pos_enu_m is not None
    inverse = truth.q * [1, -1, -1, -1]
    turn_deg = np.degrees(2 * np.arcsin(np.linalg.norm(multiply_q(recording.att_q, inverse)[:, 1:], axis=1)))
    spec = truth.parameters["navigation"]
    alignment = truth.parameters["effects"][0].get("attitude_misalignment", {"angles_deg": [0, 0, 0]})
    allowed_deg = 6 * np.sqrt(3) * spec["attitude_noise_std_deg"] + np.linalg.norm(alignment["angles_deg"])
    assert turn_deg.max() <= allowed_deg + 1e-9
    assert turn_deg.max() >= 0.05 * allowed_deg
    assert np.abs(recording.pos_enu_m - truth.pos_enu_m).max() <= 6 * spec["position_noise_std_m"]


def test_array_sensors_sit_where_the_scenario_says(tmp_path: Path) -> None:
    gradient = "effects.field_gradient.gradient_nT_m=[[100,0,0],[0,-50,0],[0,0,-50]]"
    generate(short("gradiometer-turntable", gradient), tmp_path)
    _, truth = read_run(tmp_path)
    R = matrix_from_q(truth.q)
    across = np.array([0.2, 0.0, 0.0]) - np.array([-0.2, 0.0, 0.0])  # sensors 1 and 3, baseline 0.4 m
    label = truth.effects["field_gradient"]
    expected = to_body(R, (R @ across) @ np.diag([100.0, -50.0, -50.0]))
    np.testing.assert_allclose(label[0] - label[2], expected, atol=1e-6)


def test_the_parameters_say_in_which_order_each_sensors_effects_act() -> None:
    """Also where the first sensor lacks an effect that comes early in the chain of the others."""
    ready = plan(short("gradiometer-turntable"))
    parameters = ready.metadata["parameters"]
    assert "misalignment" not in parameters["effects"][0]
    for tables, effects in zip(parameters["effects"], ready.effects, strict=True):
        order = [name for name in parameters["effect_order"] if name in tables]
        assert build(tables, order, "run") == effects


def test_same_seed_same_bytes_whatever_the_jobs(tmp_path: Path) -> None:
    scenario = short("auv-dive")
    for name, jobs in (("one", 1), ("two", 2), ("again", 2)):
        generate(scenario, tmp_path / name, runs=3, jobs=jobs)
    files = sorted(p.name for p in (tmp_path / "one").iterdir())
    assert files == ["dataset.json", *(f"run-{k:05d}.parquet" for k in range(3))]
    for file in files:
        assert len({(tmp_path / name / file).read_bytes() for name in ("one", "two", "again")}) == 1


def test_runs_and_seeds_differ(tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path / "a", runs=2)
    generate(short("tumble"), tmp_path / "b", seed=99)
    noise = [read_run(tmp_path / d, run=r)[1].effects["white_noise"] for d, r in (("a", 0), ("a", 1), ("b", 0))]
    correlation = np.corrcoef(np.stack([n.ravel() for n in noise]))
    assert np.abs(correlation - np.eye(3)).max() < 0.15


def test_another_effect_leaves_the_noise_as_it_was(tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path / "a")
    generate(short("tumble", "effects.spikes.rate_hz=1", "effects.spikes.amplitude_nT=100"), tmp_path / "b")
    a, b = (read_run(tmp_path / d)[1].effects["white_noise"] for d in "ab")
    np.testing.assert_array_equal(a, b)


def test_values_vary_from_run_to_run_and_are_told(tmp_path: Path) -> None:
    scenario = short("tumble", "vary.'effects.hard_iron.offset_nT'.uniform=[-500.0, 500.0]")
    generate(scenario, tmp_path, runs=3)
    offsets = []
    for run in range(3):
        _, truth = read_run(tmp_path, run=run)
        told = truth.parameters["drawn"]["effects.hard_iron.offset_nT"]
        np.testing.assert_allclose(truth.effects["hard_iron"], np.tile(told, (len(truth.q), 1)), atol=1e-9)
        offsets.append(told)
    assert np.ptp(np.array(offsets), axis=0).min() > 1.0


def test_metadata_says_how_to_make_the_run_again(tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path, seed=5)
    said = json.loads(pq.read_metadata(tmp_path / "run-00000.parquet").metadata[b"magbench"])
    assert (said["seed"], said["run"], said["scenario"]["name"]) == (5, 0, "tumble")


def test_a_vehicle_that_is_lost_is_told_and_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """The engine itself would begin again from the start, for ever, and warn in a file of the working directory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Quadrotor, "flow", lambda self, n, rng, memory: np.full((n, 3), 1e6))
    with pytest.raises(InputError, match=r"phases\.0 \(hover\): the simulated vehicle left its envelope"):
        generate(short("quad-calibration"), tmp_path / "out")
    assert {path.name for path in tmp_path.rglob("*")} == {"out", "dataset.json"}
    assert capfd.readouterr().err == ""


def test_phases_shorter_than_a_sample_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="shorter than a sample"):
        generate(short("tumble", "sampling.rate_hz=0.01", "phases.0.duration_s=40"), tmp_path)
    assert not list(tmp_path.glob("*.parquet"))
