"""The command line as users and scripts meet it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

import magbench.app
from magbench.cli import main
from recordings import read_run
from reports.viewer import read_series, verify
from scenarios.load import catalogue
from sim.effects import BY_NAME
from tests.nightly import first_daily
from tests.short import cuts
from validation.scoring.evaluation import UNCORRECTED


def run_json(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, object]:
    assert main([*arguments, "--json"]) == 0
    return dict(json.loads(capsys.readouterr().out))


@pytest.mark.parametrize(
    ("kind", "some"),
    [
        ("scenarios", {"auv-dive", "quad-comb", "gradiometer-turntable", "tumble"}),
        ("effects", {"hard_iron", "eddy_current", "attitude_misalignment", "dropouts"}),
        ("calibrators", {"sphere", "ellipsoid", "vector_least_squares"}),
        ("vehicles", {"auv", "quadrotor", "turntable"}),
    ],
)
def test_list(kind: str, some: set[str], capsys: pytest.CaptureFixture[str]) -> None:
    items = run_json(capsys, "list", kind)["items"]
    assert isinstance(items, list)
    assert some <= {item["name"] for item in items}
    assert all(item["summary"] and "\n" not in item["summary"] for item in items)


def test_every_effect_of_the_table_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    items = run_json(capsys, "list", "effects")["items"]
    assert isinstance(items, list)
    assert [item["name"] for item in items] == list(BY_NAME)


def test_schema_knows_every_effect_and_phase(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "scenario"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert {"white_noise", "local_dipole"} <= set(schema["$defs"]["Effects"]["properties"])
    assert schema["additionalProperties"] is False


@pytest.fixture(
    scope="module",
    params=[
        "auv-dive",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("quad-comb", "gradiometer-turntable")),
    ],
)
def place(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp(request.param)
    options = [text for cut in cuts(request.param) for text in ("--set", cut)]
    assert main(["run", request.param, "-o", str(out), *options]) == 0
    return out


def test_run_writes_all_of_it(place: Path) -> None:
    names = {path.name for path in place.iterdir()}
    assert names == {
        *("dataset.json", "run-00000.parquet", "scores.json", "calibration.json"),
        *("report.html", "recording.rrd"),
    }


def test_the_recording_is_sound_and_holds_the_datasets_arrays(place: Path) -> None:
    file = place / "recording.rrd"
    verify(file)
    recording, truth = read_run(place)
    first = {name: label if label.ndim == 2 else label[0] for name, label in truth.effects.items()}
    for entity, expected in {
        "mag": recording.mag_nT,
        "true_field": truth.field_nT,
        **{f"effects/{name}": label for name, label in first.items()},
    }.items():
        time_s, values = read_series(file, entity)
        np.testing.assert_allclose(time_s, recording.time_s, rtol=0, atol=1e-9)
        np.testing.assert_array_equal(values, expected)


def test_scores_are_per_calibrator_and_mark_what_is_in_sample(place: Path) -> None:
    told = json.loads((place / "scores.json").read_text())
    fitted = {name for name in told["scores"] if name.split("@")[0] != UNCORRECTED}
    assert fitted == set(told["calibrations"]) == set(told["ranking"])
    assert told["answer"]["use"] in {None, *(name.split("@")[0] for name in told["ranking"])}
    for scores in told["scores"].values():
        assert {s["score"] for s in scores if s["in_sample"]} <= {"in_sample_norm_rms"}


def test_calibrate_a_simulated_run(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = run_json(capsys, "calibrate", str(place), "--with", "sphere,vector_least_squares")["calibrations"]
    assert isinstance(result, dict)
    keys = {"status", "reason", "offset_nT", "matrix", "eddy_s", "parameters", "covariance", "wall_s"}
    assert all(keys <= set(c) for c in result.values())


def test_calibrate_a_measured_log_in_other_units(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng(0)
    direction = rng.standard_normal((500, 3))
    field = 48.0 * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    mag = field * [1.1, 0.9, 1.0] + [3.0, -2.0, 5.0] + 0.01 * rng.standard_normal((500, 3))
    lines = [",".join(f"{v:.6f}" for v in (0.1 * k, *row)) for k, row in enumerate(mag)]
    (tmp_path / "log.csv").write_text("\n".join(["t,bx,by,bz", *lines]) + "\n")
    maps = [f"--map=mag_{a}_nT=b{a},unit=uT" for a in "xyz"]
    result = run_json(
        capsys,
        *("calibrate", str(tmp_path / "log.csv"), "--map=time_s=t", *maps),
        *("--with", "ellipsoid", "--field-strength-nT", "48000", "-o", str(tmp_path / "out")),
    )["calibrations"]
    assert isinstance(result, dict)
    np.testing.assert_allclose(result["ellipsoid"]["offset_nT"], [3000, -2000, 5000], atol=5)
    np.testing.assert_allclose(result["ellipsoid"]["matrix"], np.diag(1 / np.array([1.1, 0.9, 1.0])), atol=2e-4)
    assert json.loads((tmp_path / "out" / "calibration.json").read_text())["ellipsoid"]["status"] == "ok"


def test_calibrate_tells_what_is_worth_its_parameters(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = run_json(capsys, "calibrate", str(place), "--worth")
    assert isinstance(told["worth"], list)
    assert {"sensor", "knowledge", "legs", "legs_by", "comparisons"} <= set(told["worth"][0])
    assert "worth" not in run_json(capsys, "calibrate", str(place))
    assert main(["calibrate", str(place), "--worth"]) == 0
    assert "Held out in turn" in capsys.readouterr().out


def test_every_scenario_is_listed_with_its_summary(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "scenarios"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in catalogue())


def test_json_alone_is_on_standard_output(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "turntable-twelve-stops", "-o", str(tmp_path / "out"), "--jobs", "1", "--json"]) == 0
    told, beside = capfd.readouterr()
    assert json.loads(told)["runs"] == 1
    assert "simulating" in beside
    assert ": 1 run, " in beside


@pytest.mark.parametrize("arguments", first_daily([("list", "effects"), ("--help",), ("schema",)]))
def test_a_reader_that_has_gone_is_no_error(arguments: tuple[str, ...]) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "magbench", *arguments]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_closed_output_is_no_error() -> None:
    command = f"{sys.executable} -m magbench --version >&-"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


SENT_AT_AN_IMPORT = """
import os, sys
from magbench.cli import main
sent, left = int(sys.argv[1]), int(sys.argv[2])
def count(event, _):
    global left
    left -= event == "import"
    if event == "import" and left == 0:
        os.kill(os.getpid(), sent)
sys.addaudithook(count)
sys.argv = ["magbench", *sys.argv[3:]]
sys.exit(main())
"""
INTERRUPTED = "magbench: interrupted; the same command resumes"


@pytest.mark.parametrize("sent", first_daily([signal.SIGINT, signal.SIGTERM]))
@pytest.mark.parametrize("at", first_daily([1, 100, 800, 10, 400], daily=3))
def test_a_signal_while_modules_are_imported_ends_in_one_line(sent: signal.Signals, at: int, tmp_path: Path) -> None:
    command = ["simulate", "auv-dive", "-o", str(tmp_path / "out")]
    start = [sys.executable, "-c", SENT_AT_AN_IMPORT, str(sent.value), str(at)]
    done = subprocess.run([*start, *command], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.splitlines()) == (128 + sent, [INTERRUPTED])


@pytest.mark.parametrize("sent", first_daily([signal.SIGINT, signal.SIGTERM]))
def test_a_signal_during_the_work_ends_in_one_line(sent: signal.Signals, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "magbench", "simulate", "auv-dive", "-o", str(tmp_path / "out")]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    assert process.stderr.readline().startswith("simulating")
    process.send_signal(sent)
    told = process.communicate(timeout=60)[1].splitlines()
    assert process.returncode == 128 + sent
    assert [line for line in told if not line.startswith("simulating")] == [INTERRUPTED]


@pytest.mark.parametrize(
    ("command", "what_next"), [("simulate", "resumes"), ("run", "resumes"), ("diagnose", "starts anew")]
)
def test_interrupted_it_says_whether_the_work_is_of_use(
    command: str, what_next: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(magbench.app, "call", mock.Mock(side_effect=KeyboardInterrupt))
    assert main([command, "anything"]) == 128 + signal.SIGINT
    assert capsys.readouterr().err == f"magbench: interrupted; the same command {what_next}\n"


def test_an_ignored_signal_stays_ignored() -> None:
    command = (
        f"trap '' HUP; {sys.executable} -c 'from magbench.cli import main; main([\"--version\"]); import signal;"
        + (" print(signal.getsignal(signal.SIGHUP).name)'")
    )
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "SIG_IGN"


def test_processes_that_are_ended_are_told_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for cause in (BrokenProcessPool(), MemoryError()):
        monkeypatch.setattr(magbench.app, "program", mock.Mock(return_value=mock.Mock(side_effect=cause)))
        assert main([]) == 2
        assert "memory" in capsys.readouterr().err
