"""Exports give back the calibration when they are used as the flight controllers use them."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib import Calibration, Status
from calib.input_terms import InputTerm
from recordings import Recording
from scenarios.errors import InputError
from validation.calibrating.export import FORMATS, exported, known_forms

MATRIX = np.array([[0.95, 0.02, -0.01], [0.02, 1.05, 0.03], [-0.01, 0.03, 1.01]])
OFFSET_NT = np.array([1200.0, -800.0, 2000.0])
GOOD = Calibration(name="ellipsoid", status=Status("ok"), offset_nT=OFFSET_NT, matrix=MATRIX)
MEASURED_FLU_NT = np.array([21_000.0, -9_000.0, -40_000.0])
TRUE_FLU_NT = MATRIX @ (MEASURED_FLU_NT - OFFSET_NT)
FRD = np.array([1.0, -1.0, -1.0])


def parameters(form: str) -> dict[str, float]:
    text = exported(GOOD, form)[1]
    return {name: float(value) for name, value in re.findall(r"([A-Z0-9_]+)[,\t](-?[0-9.]+)", text)}


def symmetric(diagonal: list[float], xy: float, xz: float, yz: float) -> np.ndarray:
    return np.diag(diagonal) + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])


def test_px4_scales_after_taking_the_offset_in_gauss() -> None:
    p = parameters("px4")
    scale = symmetric([p[f"CAL_MAG0_{a}SCALE"] for a in "XYZ"], *(p[f"CAL_MAG0_{a}ODIAG"] for a in "XYZ"))
    offset = np.array([p[f"CAL_MAG0_{a}OFF"] for a in "XYZ"])
    corrected = scale @ (FRD * MEASURED_FLU_NT / 1e5 - offset)
    np.testing.assert_allclose(1e5 * FRD * corrected, TRUE_FLU_NT, atol=0.01)


def test_ardupilot_adds_the_offset_in_milligauss() -> None:
    p = parameters("ardupilot")
    matrix = symmetric([p[f"COMPASS_DIA_{a}"] for a in "XYZ"], *(p[f"COMPASS_ODI_{a}"] for a in "XYZ"))
    offset = np.array([p[f"COMPASS_OFS_{a}"] for a in "XYZ"])
    corrected = matrix @ (p["COMPASS_SCALE"] * (FRD * MEASURED_FLU_NT / 100.0 + offset))
    np.testing.assert_allclose(100.0 * FRD * corrected, TRUE_FLU_NT, atol=0.1)


def test_ros_is_in_tesla() -> None:
    text = exported(GOOD, "ros")[1]
    rows = [[float(v) for v in row.split(",")] for row in re.findall(r"\[(.*)\]", text)]
    np.testing.assert_allclose(1e9 * np.array(rows[1:4]) @ (1e-9 * MEASURED_FLU_NT - rows[0]), TRUE_FLU_NT, atol=1e-3)


def test_c_header_holds_the_numbers() -> None:
    numbers = [float(v) for v in re.findall(r"(-?[0-9.]+(?:e[+-][0-9]+)?)f", exported(GOOD, "c")[1])]
    np.testing.assert_allclose(numbers, [*OFFSET_NT, *MATRIX.ravel()], rtol=1e-8)


@pytest.mark.parametrize("form", ["c", "ros", "px4", "ardupilot"])
def test_eddy_currents_that_no_format_holds_are_told(form: str) -> None:
    eddy = replace(GOOD, eddy_s=0.02 * np.eye(3))
    assert "the eddy currents' term is left out" in exported(eddy, form)[1].splitlines()[0]
    assert "eddy" not in exported(GOOD, form)[1]


PROGRAM = """
#include <stdio.h>
#include "mag_calibration.h"

int main(void) {
    float m[3], h[3];
    while (scanf("%f %f %f", &m[0], &m[1], &m[2]) == 3) {
        for (int i = 0; i < 3; i++) {
            h[i] = 0.0f;
            for (int j = 0; j < 3; j++) h[i] += MAG_MATRIX[i][j] * (m[j] - MAG_OFFSET_NT[j]);
        }
        printf("%.9g %.9g %.9g\\n", h[0], h[1], h[2]);
    }
    return 0;
}
"""


@pytest.mark.parametrize(("compiler", "standard"), [("gcc", "-std=c99"), ("g++", "-std=c++11")])
def test_firmware_with_the_c_header_corrects_as_apply_does(compiler: str, standard: str, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"there is no {compiler}")
    name, text = exported(GOOD, "c")
    (tmp_path / name).write_text(text)
    source = tmp_path / ("main.c" if compiler == "gcc" else "main.cpp")
    source.write_text(PROGRAM)
    flags = ["-Wall", "-Wextra", "-pedantic", "-Werror", standard]
    subprocess.run([compiler, *flags, str(source), "-o", str(tmp_path / "main")], check=True)
    measured_nT = np.random.default_rng(0).uniform(-60_000, 60_000, (100, 3))
    lines = "".join(f"{x} {y} {z}\n" for x, y, z in measured_nT)
    told = subprocess.run([str(tmp_path / "main")], input=lines, capture_output=True, text=True, check=True).stdout
    corrected_nT = np.array([line.split() for line in told.splitlines()], float)
    expected_nT = GOOD.apply(Recording(np.arange(100.0), measured_nT))
    np.testing.assert_allclose(corrected_nT, expected_nT, atol=0.05)  # single precision: 2^-24 of 60,000 nT, ten times


WITH_INPUTS = PROGRAM.replace("float m[3], h[3];", "float m[3], h[3], p;").replace(
    'scanf("%f %f %f", &m[0], &m[1], &m[2]) == 3) {',
    'scanf("%f %f %f %f", &m[0], &m[1], &m[2], &p) == 4) {\n'
    "        for (int j = 0; j < 3; j++) m[j] -= MAG_INPUT_GAINS_NT[0][j] * (p - MAG_INPUT_REFERENCES[0]);\n"
    "        if (MAG_INPUTS != 1 || MAG_INPUT_LAGS_S[0] != 0.0f) return 1;",
)


def test_firmware_with_the_c_header_takes_off_the_field_of_the_throttle(tmp_path: Path) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    term = InputTerm("throttle", np.array([900.0, -400.0, 1200.0]), 0.4)
    powered = replace(GOOD, inputs=(term,))
    name, text = exported(powered, "c")
    (tmp_path / name).write_text(text)
    (tmp_path / "main.c").write_text(WITH_INPUTS)
    flags = ["-Wall", "-Wextra", "-pedantic", "-Werror", "-std=c99"]
    subprocess.run(["gcc", *flags, str(tmp_path / "main.c"), "-o", str(tmp_path / "main")], check=True)
    rng = np.random.default_rng(1)
    measured_nT, throttle = rng.uniform(-60_000, 60_000, (100, 3)), rng.random(100)
    lines = "".join(f"{x} {y} {z} {p}\n" for (x, y, z), p in zip(measured_nT, throttle, strict=True))
    told = subprocess.run([str(tmp_path / "main")], input=lines, capture_output=True, text=True, check=True).stdout
    log = Recording(np.arange(100.0), measured_nT, channels={"throttle": throttle})
    corrected_nT = np.array([line.split() for line in told.splitlines()], float)
    np.testing.assert_allclose(corrected_nT, powered.apply(log), atol=0.1)


@pytest.mark.parametrize("form", ["px4", "ardupilot"])
def test_a_turned_matrix_does_not_fit_six_numbers(form: str) -> None:
    turn = [[1, 0.05, 0], [-0.05, 1, 0], [0, 0, 1]]
    turned = Calibration(name="vector", status=Status("ok"), offset_nT=OFFSET_NT, matrix=MATRIX @ turn)
    with pytest.raises(InputError, match="not symmetric"):
        exported(turned, form)


DOUBTED = replace(GOOD, status=Status("unobservable", "the motion */ is\nflat"))
COMMENT = {"c": r"/\* (.*) \*/", "px4": "# (.*)", "ardupilot": "# (.*)", "ros": "# (.*)"}


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("form", FORMATS)
def test_nothing_is_exported_without_an_estimate(form: str, force: bool) -> None:
    for kind in ("not_converged", "unobservable", "not_applicable"):
        with pytest.raises(InputError, match=r"no estimate .*too flat"):
            exported(Calibration(name="ellipsoid", status=Status(kind, "too flat")), form, force=force)  # type: ignore[arg-type]


@pytest.mark.parametrize("form", FORMATS)
def test_a_doubted_estimate_is_exported_by_force_alone_and_says_so(form: str) -> None:
    with pytest.raises(InputError, match=r"unobservable: the motion .* flat.*--force"):
        exported(DOUBTED, form)
    first, rest = exported(DOUBTED, form, force=True)[1].split("\n", 1)
    told = re.fullmatch(COMMENT[form], first)
    assert told is not None
    assert told[1] == "status unobservable: the motion * / is flat"
    assert "*/" not in told[1]
    assert rest == exported(GOOD, form)[1]


@pytest.mark.parametrize(
    ("form", "changed", "named"),
    [
        ("ardupilot", {"offset_nT": np.array([0.0, 185_000.0, 0.0])}, r"COMPASS_OFS_Y 1850 is outside -1800 to 1800"),
        ("ardupilot", {"matrix": np.diag([1.0, 0.19, 1.0])}, r"COMPASS_DIA_Y 0.19 is outside 0.2 to 5"),
        ("px4", {"matrix": np.diag([1.0, 1.0, 14.6])}, r"CAL_MAG0_ZSCALE 14.6 is outside 0.1 to 3"),
    ],
)
def test_what_the_flight_controller_does_not_take_is_refused(
    form: str, changed: dict[str, np.ndarray], named: str
) -> None:
    beyond = replace(GOOD, **changed)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=named):
        exported(beyond, form)
    assert re.match("# " + named, exported(beyond, form, force=True)[1])
    assert exported(beyond, "ros")


def test_terms_of_a_scalar_magnetometer_are_no_offset_and_matrix() -> None:
    scalar = Calibration(name="tolles_lawson", status=Status("ok"), parameters={"permanent_x_nT": 3.0})
    assert not scalar.has_estimate
    with pytest.raises(InputError, match="scalar magnetometer"):
        exported(scalar, "c")


def test_unknown_form_lists_the_others() -> None:
    with pytest.raises(InputError, match="ardupilot"):
        known_forms("c, betaflight")
    assert known_forms("c, ros") == ("c", "ros")
