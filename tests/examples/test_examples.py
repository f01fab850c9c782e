"""The examples are calibrators as the page says: they find the sphere and the ellipsoid that were put in."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference
from recordings import Recording
from tests.conftest import ROOT
from validation.calibrating.selection import select_calibrators

STRENGTH_NT = 50_000.0
OFFSET_NT = np.array([4_000.0, -6_000.0, 9_000.0])
SOFT = np.array([[1.10, 0.03, -0.02], [0.03, 0.92, 0.04], [-0.02, 0.04, 1.05]])
EXAMPLES = ROOT / "examples"
Measured = Callable[[np.ndarray], Recording]


def turns_of(times: np.ndarray) -> Rotation:
    """Attitudes that turn every way."""
    angles = np.column_stack([0.9 * np.sin(0.31 * times) + 0.31 * times, 0.9 * np.sin(0.23 * times), 0.17 * times])
    return Rotation.from_euler("xyz", angles)


@pytest.fixture
def measured() -> Measured:
    """A recording whose sensor has OFFSET_NT and a matrix, and turns every way, without noise; one word a row."""
    times = 0.1 * np.arange(1000.0)
    attitude = turns_of(times)
    field_nT = attitude.inv().apply([0.0, 0.6 * STRENGTH_NT, -0.8 * STRENGTH_NT])
    step = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / 0.1
    rate = np.vstack([step, step[-1:]])

    def of(matrix: np.ndarray) -> Recording:
        words = np.array(["turn"] * len(times))
        return Recording(times, field_nT @ matrix.T + OFFSET_NT, gyro_rad_s=rate, phase=words)

    return of


def error_of(found: Calibration, soft: np.ndarray) -> tuple[float, float]:
    """Error of the offset, nT, and of the matrix (Frobenius)."""
    assert found.status.kind == "ok", found.status.reason
    offset_nT = float(np.linalg.norm(found.offset_nT - OFFSET_NT))
    return offset_nT, float(np.linalg.norm(found.matrix @ soft - np.eye(3)))


@pytest.mark.usefixtures("here")
def test_the_joint_map_of_field_force_and_rate(measured: Measured) -> None:
    """The paper's equations solved: without noise what is left is that of rates which are half a step early."""
    one = measured(SOFT)
    attitude = turns_of(one.time_s)
    recording = replace(one, accel_m_s2=attitude.inv().apply([0.0, 0.0, 9.81]) + np.array([0.1, -0.2, 0.05]))
    command = f"{sys.executable} examples/peers/with_huang.py joint_map {{recording.csv}} {{result}}"
    offset_nT, matrix = error_of(answer(command, recording), SOFT)
    assert offset_nT < 20.0
    assert matrix < 0.01


def answer(command: str, recording: Recording) -> Calibration:
    (candidate,) = select_calibrators((), [command])
    return candidate.fit(recording, Reference(STRENGTH_NT))


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """The repository's root, where the page's commands are given."""
    monkeypatch.chdir(ROOT)


@pytest.mark.usefixtures("here")
def test_ten_lines_of_numpy(measured: Measured) -> None:
    (candidate,) = select_calibrators(["examples.ellipsoid_numpy:fit"])
    offset_nT, matrix = error_of(candidate.fit(measured(SOFT), Reference(STRENGTH_NT)), SOFT)
    assert offset_nT < 1e-4
    assert matrix < 1e-8


@pytest.mark.usefixtures("here")
def test_a_sphere_in_c(measured: Measured, tmp_path: Path) -> None:
    if shutil.which("cc") is None:
        pytest.skip("no C compiler is installed")
    build = ["cc", "-O2", "-Wall", "-Wextra", "-Werror", "-o", tmp_path / "sphere-c", "examples/sphere.c", "-lm"]
    subprocess.run(build, check=True)
    command = f"{tmp_path / 'sphere-c'} {{recording.csv}} {{result}} {{field_strength_nT}}"
    offset_nT, matrix = error_of(answer(command, measured(1.07 * np.eye(3))), 1.07 * np.eye(3))
    assert offset_nT < 1e-4
    assert matrix < 1e-8
    level = measured(np.diag([1.0, 1.0, 0.0]))
    assert "the measurements lie in a plane" in answer(command, level).status.reason


@pytest.mark.usefixtures("here")
def test_an_ellipsoid_in_octave(measured: Measured) -> None:
    program = shutil.which("octave-cli")
    if program is None:
        pytest.skip("octave-cli is not installed")
    command = f"mine={program} -qf examples/ellipsoid.m {{recording.csv}} {{result}}"
    offset_nT, matrix = error_of(answer(command, measured(SOFT)), SOFT)
    assert offset_nT < 1e-3
    assert matrix < 1e-6


@pytest.fixture
def peer(here: None) -> Callable[[str, Recording], Calibration]:
    """What a method of a public package answers; the packages are in an environment of their own."""
    python = os.environ.get("MAGBENCH_PEERS")
    if not python:
        pytest.skip("MAGBENCH_PEERS does not name the Python of an environment with magyc and magcal")

    def of(words: str, recording: Recording) -> Calibration:
        return answer(f"mine={python} examples/peers/{words} {{recording.csv}} {{result}}", recording)

    return of


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "soft", "offset_nT", "matrix"),
    [
        ("ellipsoid_fit_fang", SOFT, (0.0, 1e-3), (0.0, 1e-6)),
        ("magyc_ls", SOFT, (0.0, 100.0), (0.0, 0.01)),
        ("ellipsoid_fit", SOFT, (0.0, 1e-3), (0.1, 1.0)),
        ("sar_kf", np.eye(3), (10_000.0, np.inf), (0.0, 1e-9)),
        ("sar_aid", np.eye(3), (10_000.0, np.inf), (0.0, 1e-9)),
    ],
)
def test_magyc_is_right_and_wrong_where_it_is(
    method: str,
    soft: np.ndarray,
    offset_nT: tuple[float, float],
    matrix: tuple[float, float],
    measured: Measured,
    peer: Callable[[str, Recording], Calibration],
) -> None:
    """The first two are right but for numerical derivatives, and so are units and frames; the errors are its own."""
    found = error_of(peer(f"with_magyc.py {method}", measured(soft)), soft)
    assert offset_nT[0] <= found[0] < offset_nT[1]
    assert matrix[0] <= found[1] < matrix[1]


@pytest.mark.slow
def test_magcal_takes_the_mean_of_the_samples_for_the_centre(
    measured: Measured, peer: Callable[[str, Recording], Calibration]
) -> None:
    """Where the samples' mean is the centre it is exact, so that units and form are."""
    recording = measured(SOFT)
    there_and_back = np.vstack([recording.mag_nT, 2 * OFFSET_NT - recording.mag_nT])
    even = Recording(np.arange(2000.0), there_and_back)
    assert max(error_of(peer("with_magcal.py ellipsoid", even), SOFT)) < 1e-3
    found = peer("with_magcal.py ellipsoid", recording)
    np.testing.assert_allclose(found.offset_nT, recording.mag_nT.mean(axis=0), atol=1e-3)
    assert error_of(found, SOFT)[0] > 1_000.0
