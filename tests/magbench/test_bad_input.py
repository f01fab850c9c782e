"""Bad input at the command line: exit status 2, one line that names the place, nothing half-written."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest

from magbench.cli import main
from recordings.files import locked_directory

SCENARIO = """
name = "mine"
summary = "a short spiral"
[field]
enu_nT = [0.0, 20000.0, -40000.0]
[vehicle]
kind = "auv"
[[phases]]
kind = "spiral"
radius_m = 20.0
turn_rate_deg_s = 1.0
duration_s = 60.0
[effects.white_noise]
std_nT = [1.0, 1.0, 1.0]
"""

BAD_SCENARIOS = {  # what to replace, by what, what the line must name
    "not TOML": ("[field]", "[field", "line"),
    "unknown key": ("radius_m", "radius", "phases.0.radius"),
    "unknown table": ("[vehicle]", "[weather]\nrain = true\n[vehicle]", "weather"),
    "out of range": ("turn_rate_deg_s = 1.0", "turn_rate_deg_s = 1e9", "phases.0.turn_rate_deg_s"),
    "negative radius": ("radius_m = 20.0", "radius_m = -20.0", "phases.0.radius_m"),
    "text for a number": ("radius_m = 20.0", 'radius_m = "wide"', "phases.0.radius_m"),
    "not a number": ("radius_m = 20.0", "radius_m = nan", "phases.0.radius_m"),
    "wrong shape": ("[0.0, 20000.0, -40000.0]", "[0.0, 20000.0]", "field.enu_nT"),
    "two fields": ("enu_nT", "latitude_deg = 10.0\nenu_nT", "field"),
    "no field": ("enu_nT = [0.0, 20000.0, -40000.0]", "", "field"),
    "unknown vehicle": ('kind = "auv"', 'kind = "submarine"', "vehicle"),
    "unknown phase": ('kind = "spiral"', 'kind = "loop"', "phases.0"),
    "phase that the vehicle cannot do": ('kind = "auv"', 'kind = "turntable"', "phases.0"),
    "bad name": ('name = "mine"', 'name = "My Scenario!"', "name"),
    "unknown effect": ("effects.white_noise", "effects.whitenoise", "white_noise"),
    "unknown parameter of an effect": ("std_nT", "std_uT", "std_nT"),
    "wrong shape in an effect": ("[1.0, 1.0, 1.0]", "[1.0, 1.0]", "effects.white_noise.std_nT"),
    "negative noise": ("[1.0, 1.0, 1.0]", "[1.0, 1.0, -1.0]", "effects.white_noise.std_nT"),
    "text in an effect": ("[1.0, 1.0, 1.0]", '"loud"', "effects.white_noise.std_nT"),
    "an effect that is no table": ("[effects.white_noise]\nstd_nT", "[effects]\nwhite_noise", "effects.white_noise"),
    "incomplete order": ('name = "mine"', 'name = "mine"\neffect_order = ["hard_iron"]', "effect_order"),
    "unknown calibrator": ('name = "mine"', 'name = "mine"\ncalibrators = ["magic"]', "magic"),
    "sample rate that is no whole step": ("[vehicle]", "[sampling]\nrate_hz = 13.0\n[vehicle]", "rate_hz"),
    "vary names nothing": ("[vehicle]", "[vary]\n'effects.x.y'.uniform = [0.0, 1.0]\n[vehicle]", "effects.x.y"),
    "depth that is never reached": (
        'kind = "spiral"\nradius_m = 20.0\nturn_rate_deg_s = 1.0\nduration_s = 60.0',
        'kind = "descent"\nto_depth_m = 3000.0\nmax_duration_s = 30.0',
        "max_duration_s",
    ),
}

BAD_OVERRIDES = {
    "radius_m": "radius_m",
    "phases.0.nothing=1": "phases.0.nothing",
    "phases.7.radius_m=1": "phases.7.radius_m",
    "phases.0.radius_m=[": "phases.0.radius_m",
    "phases.0.radius_m=-1": "phases.0.radius_m",
    "effects.white_noise.std_nT=loud": "effects.white_noise.std_nT",
    "seed=-1": "seed",
}

BAD_COMMANDS = {
    "no command": ("calibrat",),
    "no scenario": ("run",),
    "no such scenario": ("run", "auv-dve"),
    "no such option": ("run", "tumble", "--fast"),
    "no runs": ("simulate", "tumble", "--runs", "0"),
    "negative seed": ("simulate", "tumble", "--seed", "-1"),
    "jobs in words": ("simulate", "tumble", "--jobs", "many"),
    "nothing of that kind to list": ("list", "planets"),
    "no such log": ("calibrate", "nowhere.csv"),
    "no recording": ("show", "nowhere"),
    "a run of a scenario": ("bound", "standard-full", "--run", "0"),
    "the field of a scenario": ("bound", "standard-full", "--field-strength-nT", "50000"),
    "a plan for no log with columns": ("plan", "auv", "--map", "mag_x_nT=bx"),
    "a plan for no vehicle": ("plan", "submarine"),
    "a plan for no figure": ("plan", "auv", "--target", "speed=2"),
    "a plan after no log": ("plan", "auv", "--after", "nowhere.csv"),
    "a strength unknown and known": ("bound", "standard-full", "--knowledge", "vector", "--strength-unknown"),
}


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line that the command line answers with."""
    status = main(list(arguments))
    out, err = capsys.readouterr()
    lines = [line for line in err.splitlines() if not line.startswith(("simulating", "running", "planning"))]
    assert status == 2, err
    assert out == ""
    assert len(lines) == 1, err
    assert lines[0].startswith("magbench: ")
    assert "Traceback" not in err
    return lines[0]


@pytest.mark.parametrize("kind", BAD_SCENARIOS)
@pytest.mark.parametrize("command", ["run", "simulate"])
def test_bad_scenario(kind: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old, new, named = BAD_SCENARIOS[kind]
    if command == "simulate" and kind == "unknown calibrator":
        pytest.skip("simulate needs no calibrator")
    assert old in SCENARIO
    file = tmp_path / "mine.toml"
    file.write_text(SCENARIO.replace(old, new, 1))
    line = refused(capsys, command, str(file), "-o", str(tmp_path / "out"))
    assert named in line
    assert not list(tmp_path.glob("out/run-*"))
    assert not list(tmp_path.glob("out/*.magbench-part"))


@pytest.mark.parametrize("override", BAD_OVERRIDES)
def test_bad_override(override: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(SCENARIO)
    line = refused(capsys, "simulate", str(file), "-o", str(tmp_path / "out"), "--set", override)
    assert BAD_OVERRIDES[override] in line
    assert not list(tmp_path.glob("out/*.parquet"))


@pytest.mark.parametrize("kind", BAD_COMMANDS)
def test_bad_command(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    refused(capsys, *BAD_COMMANDS[kind])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "option"),
    [(("diagnose", "nowhere.csv", "--model", "tumble", "--model=auv-dive"), "--model"),
     (("run", "nowhere.toml", "-o", "here", "--out", "there"), "--out")],
)  # fmt: skip
def test_of_two_values_for_one_option_none_is_taken(
    arguments: tuple[str, ...], option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert f"{option}: takes one value, and 2 are given" in refused(capsys, *arguments)


@pytest.mark.parametrize(
    ("number", "line"),
    [("alhpa=0.1", "'alhpa' is no number of the policy"), ("alpha=much", "'much' is no float"), ("alpha=-1", "alpha")],
)
def test_a_number_of_the_policy_that_is_none_is_told_before_the_log_is_read(
    number: str, line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert line in refused(capsys, "diagnose", log(tmp_path / "log.csv"), "--set", number)
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


MICROTESLA = {f"mag_{a}_nT": 30 * np.sin(np.arange(200) + k) for k, a in enumerate("xyz")}


def log(path: Path, **columns: object) -> str:
    """A good measured log with changed columns."""
    angle = np.linspace(0.0, 12.0, 200)
    x, y, z = 3e4 * np.cos(angle), 3e4 * np.sin(angle), 1e4 + 2e4 * np.sin(angle / 3)
    good: dict[str, object] = {"time_s": 0.1 * np.arange(200), "mag_x_nT": x, "mag_y_nT": y, "mag_z_nT": z}
    table = {**good, **columns}
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        writer.writerows(zip(*table.values(), strict=True))  # type: ignore[call-overload]
    return str(path)


@pytest.mark.parametrize(
    ("columns", "options", "named"),
    [
        ({}, (), "--field-strength-nT"),
        ({}, ("--field-strength-nT", "-5"), "strength"),
        ({}, ("--field-strength-nT", "48.2"), "it looks like uT"),
        ({}, ("--field-strength-nT", "nan"), "nan"),
        ({}, ("--field-enu-nT", "0,1e300,0"), "--field-enu-nT"),
        ({}, ("--field-strength-nT", "4e4", "--with", ","), "names no calibrator"),
        ({}, ("--field-strength-nT", "4e4", "--export", "c,"), "choose among c"),
        ({}, ("--field-enu-nT", "1,2"), "--field-enu-nT"),
        ({}, ("--field-strength-nT", "4e4", "--with", "elipsoid"), "ellipsoid"),
        ({}, ("--field-strength-nT", "4e4", "--map", "mag_x_nT=bx"), "bx"),
        ({}, ("--field-strength-nT", "4e4", "--map", "mag_x_nT=mag_x_nT,unit=furlong"), "furlong"),
        ({"mag_x_nT": np.zeros(200)}, ("--field-strength-nT", "4e4"), "mag_x_nT"),
        ({"mag_x_nT": ["?"] * 200}, ("--field-strength-nT", "4e4"), "mag_x_nT"),
        ({"mag_y_nT": [float("nan")] * 200}, ("--field-strength-nT", "4e4"), "mag_y_nT"),
        (
            {f"mag_{a}_nT": 30 * np.sin(np.arange(200) + k) for k, a in enumerate("xyz")},
            ("--field-strength-nT", "4e4"),
            "uT",
        ),
    ],
)
def test_bad_log(
    columns: dict[str, object],
    options: tuple[str, ...],
    named: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = refused(capsys, "calibrate", log(tmp_path / "log.csv", **columns), *options, "-o", str(tmp_path / "out"))
    assert named in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("device", ["pipe", "/dev/zero"])
@pytest.mark.parametrize("command", ["run", "simulate", "calibrate", "apply", "apply to", "show"])
def test_a_pipe_or_a_device_is_refused_and_not_read_for_ever(
    command: str, device: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if device == "pipe":
        device = str(tmp_path / "pipe.csv")
        os.mkfifo(device)
    (tmp_path / "c.json").write_text(
        '{"name": "mine", "offset_nT": [0, 0, 0], "matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}'
    )
    out = ("-o", str(tmp_path / "out.csv"))
    arguments = {
        "show": ("show", device),
        "apply": ("apply", device, log(tmp_path / "log.csv"), *out),
        "apply to": ("apply", str(tmp_path / "c.json"), device, *out),
    }.get(command, (command, device, *out))
    assert device in refused(capsys, *arguments)
    assert not (tmp_path / "out.csv").exists()


def test_a_text_that_is_too_long(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with (tmp_path / "long.toml").open("wb") as file:
        file.truncate(10**12)
    assert "longer than" in refused(capsys, "run", str(tmp_path / "long.toml"), "-o", str(tmp_path / "out"))


@pytest.mark.parametrize("command", [("calibrate", "--field-strength-nT", "4e4"), ("inspect",), ("inspect", "--json")])
def test_a_name_that_is_not_utf8(command: tuple[str, ...], tmp_path: Path) -> None:
    name = os.fsdecode(bytes(tmp_path) + b"/l\xff.csv")
    log(Path(name))
    assert main([*command, name]) == 0


def test_rows_with_the_newest_first_are_reversed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = log(tmp_path / "log.csv", time_s=np.arange(200)[::-1])
    assert main(["calibrate", file, "--field-strength-nT", "4e4"]) == 0
    assert "the rows were reversed" in capsys.readouterr().err


def test_output_that_is_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("mine")
    assert "taken" in refused(capsys, "simulate", "tumble", "-o", str(tmp_path / "taken"))
    assert (tmp_path / "taken").read_text() == "mine"


@pytest.mark.parametrize("command", ["calibrate", "inspect", "reproduce"])
def test_output_that_another_process_writes_to(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    field = ("--field-strength-nT", "4e4") if command == "calibrate" else ()
    what = "zhou2012" if command == "reproduce" else log(tmp_path / "log.csv")
    with locked_directory(tmp_path / "out"):
        line = refused(capsys, command, what, *field, "-o", str(tmp_path / "out"))
    assert "another magbench is writing here" in line
    assert not (tmp_path / "out").exists()


def test_a_log_has_no_values_to_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log(tmp_path / "log.csv")
    assert "--set" in refused(capsys, "bound", str(tmp_path / "log.csv"), "--set", "seed=1")


def test_an_export_is_checked_before_anything_is_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("no log")
    arguments = ("calibrate", str(tmp_path / "log.csv"), "-o", str(tmp_path / "out"), "--export", "c,")
    assert "choose among c" in refused(capsys, *arguments)


def test_output_that_holds_another_dataset(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "turntable-twelve-stops", "-o", str(tmp_path / "out")]) == 0
    capsys.readouterr()
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    assert "seed" in refused(capsys, "simulate", "turntable-twelve-stops", "--seed", "5", "-o", str(tmp_path / "out"))
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


def test_full_disk(tmp_path: Path, cli) -> None:  # type: ignore[no-untyped-def]
    import resource

    small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))  # noqa: E731
    whole = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}  # bytecode would be cut short too, and stay so
    done = cli("simulate", "tumble", "-o", str(tmp_path / "out"), "--jobs", "1", preexec_fn=small, env=whole)
    assert done.returncode == 2
    assert len([line for line in done.stderr.splitlines() if line.startswith("magbench: ")]) == 1
    assert "Traceback" not in done.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["dataset.json"]
