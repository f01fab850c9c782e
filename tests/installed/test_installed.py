"""magbench in another project's environment, whose own packages have the names of ours (`make installed`)."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from nesting import PARTS
from tests.conftest import ROOT

pytestmark = pytest.mark.slow
SCENARIO = "turntable-twelve-stops"
OWN_TEST = """
import magbench
import numpy as np
import sim.calibrator
from sim import THEIRS

def test_both_packages():
    direction = np.random.default_rng(0).standard_normal((300, 3))
    mag_nT = 48_000 * direction / np.linalg.norm(direction, axis=1, keepdims=True) + 100
    found = magbench.calibrate(mag_nT, 48_000, with_="sphere")
    assert THEIRS == "the user's"
    assert abs(found.offset_nT - 100).max() < 1e-6

def test_a_calibrator_of_the_package_called_sim(assert_accuracy):
    keys = dict(score="offset_error", ratio=0.9, reference="uncorrected")
    assert_accuracy(sim.calibrator.centred, "tumble", **keys)
    assert_accuracy("sim.calibrator:centred", "tumble", **keys)
"""
OWN_CALIBRATOR = """
import numpy as np

def centred(recording, reference):
    return (recording.mag_nT.max(axis=0) + recording.mag_nT.min(axis=0)) / 2, np.eye(3)
"""


TYPED = """
import magbench
import numpy as np
from magbench.testing import assert_accuracy

def own(recording: magbench.Recording, reference: magbench.Reference) -> object:
    return recording.mag_nT[0], np.eye(3)

found = magbench.calibrate(np.zeros((10, 3)), 48_000)
reveal_type(found)
reveal_type(found.offset_nT)
reveal_type(found.plot())
reveal_type(magbench.calibrate("log.csv", with_=["sphere", "ellipsoid"]))
reveal_type(magbench.apply(found, "log.csv"))
reveal_type(magbench.inspect("log.csv").warnings)
reveal_type(magbench.diagnose("log.csv", "auv-dive").verdict)
reveal_type(magbench.simulate("auv-dive"))
reveal_type(magbench.run("auv-dive").ranking())
reveal_type(magbench.load("auv-dive").seed)
reveal_type(assert_accuracy(own, "tumble", score="heading_rms", limit=2.0).measured)
reveal_type(assert_accuracy(magbench.Calibrator, "tumble", score="heading_rms", limit=2.0))
assert_accuracy("ellipsoid", "tumble", score="heading_rms", limit="2.0")
magbench.calibrate(5)
magbench.calibrat
"""
REVEALED = """
magbench.api.calibration_results.CalibrationResult
ndarray[ numpy.float64
matplotlib.figure.Figure
magbench.api.calibration_results.Calibrations
ndarray[ numpy.float64
list[magbench.validation.inspection.finding.Finding]
magbench.diagnosis
tuple[magbench.recordings.recording.Recording, magbench.recordings.recording.Truth]
tuple[list[str], str]
int
float
magbench.validation.gates.gate_outcome.GateOutcome
"""
"""What a type checker says to each reveal_type in TYPED, in parts."""


PROCESSES = """
import multiprocessing
import pickle
from magbench.calib.reference import Reference

if __name__ == "__main__":
    assert pickle.loads(pickle.dumps(Reference(48_000.0))) == Reference(48_000.0)
    for method in ("spawn", "forkserver"):
        with multiprocessing.get_context(method).Pool(1) as pool:
            print(pool.apply(Reference, (48_000.0,)).strength_nT)
"""
FAILING = """
import inspect, sys, traceback
import magbench
from magbench.calib import reference

steps = set()
def trace(frame, event, argument):
    steps.add((frame.f_code.co_filename, frame.f_lineno))
    return trace

sys.settrace(trace)
try:
    reference.Reference(-1.0)
except Exception as error:
    sys.settrace(None)
    last = traceback.extract_tb(error.__traceback__)[-1]
print(reference.__file__, last.filename, (last.filename, last.lineno) in steps)
print(inspect.getsource(reference) == open(reference.__file__).read())
"""


@pytest.fixture(scope="module", params=["wheel", "editable"])
def python(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of a new environment with magbench installed, and the rest as it is in this one."""
    place = tmp_path_factory.mktemp(request.param)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", place / "venv"], check=True)
    site = next((place / "venv").glob("lib/python*/site-packages"))
    (site / "dependencies.pth").write_text("\n".join(dependencies()), encoding="utf-8")
    interpreter = place / "venv" / "bin" / "python"
    source = ["-e", str(ROOT)] if request.param == "editable" else [str(ROOT)]
    pip = [sys.executable, "-m", "pip", "--python", str(interpreter), "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "--no-deps", *source], check=True)
    return interpreter


def dependencies() -> Iterator[str]:
    """This environment's packages, and the folders that they put on the path; not magbench."""
    site = Path(sysconfig.get_path("purelib"))
    yield str(site)
    for file in site.glob("*.pth"):
        if "magbench" not in file.name:
            lines = file.read_text(encoding="utf-8").splitlines()
            yield from (str(site / line) for line in lines if (site / line).is_dir())


@pytest.fixture(params=["packages", "folders"])
def project(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A user's project: its own packages, or folders of data with these names."""
    for name in PARTS:
        (tmp_path / name).mkdir()
        if request.param == "packages":
            (tmp_path / name / "__init__.py").write_text('THEIRS = "the user\'s"\n')
    (tmp_path / "test_own.py").write_text(OWN_TEST)
    (tmp_path / "sim" / "calibrator.py").write_text(OWN_CALIBRATOR)
    return tmp_path


@pytest.fixture
def run(python: Path, project: Path) -> Callable[..., str]:
    """Run the environment's Python in the user's project; what it prints."""

    def call(*arguments: str) -> str:
        done = subprocess.run([python, *arguments], cwd=project, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr + done.stdout
        return done.stdout

    return call


def test_commands_workers_and_python_run_beside_the_users_packages(
    run: Callable[..., str], python: Path, project: Path
) -> None:
    program = str(python.with_name("magbench"))
    assert SCENARIO in run(program, "list", "scenarios")
    if not (project / "sim" / "__init__.py").exists():
        return  # the folders of data are another way of importing, not of working
    told = run("-m", "magbench", "simulate", SCENARIO, "-o", "data", "--runs", "2", "--jobs", "2", "--json")
    assert json.loads(told)["runs"] == 2
    assert "sphere" in json.loads(run(program, "calibrate", "data", "--json"))["calibrations"]
    assert "accuracy gates: 2 passed" in run("-m", "pytest", "-q", "-p", "no:cacheprovider")


def test_the_users_packages_are_the_users(run: Callable[..., str], project: Path) -> None:
    code = f"import sys, magbench.app, {', '.join(PARTS)}; print(*sim.__path__); print(*sys.modules)"
    place, modules = run("-c", code).splitlines()
    assert place == str(project / "sim")
    assert {name for name in modules.split() if name.split(".")[0] in PARTS} == set(PARTS)
    assert "magbench.scenarios.errors" in modules.split()


def test_results_go_to_other_processes(run: Callable[..., str], project: Path) -> None:
    (project / "program.py").write_text(PROCESSES)
    assert run("program.py").split() == ["48000.0", "48000.0"]


def test_an_error_and_a_debugger_show_the_file_itself(run: Callable[..., str], python: Path) -> None:
    """The checkout's own file, where the installation is editable."""
    files, source = run("-c", FAILING).splitlines()
    module, last, stepped = files.split()
    assert module == last
    assert (stepped, source) == ("True", "True")
    assert (Path(module) == ROOT / "calib" / "reference.py") == (not list(python.parents[1].rglob("magbench/calib")))


def test_nothing_but_magbench_is_installed(python: Path) -> None:
    code = f"from importlib.util import find_spec; print([name for name in {PARTS} if find_spec(name)])"
    done = subprocess.run([python, "-I", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_type_checker_sees_the_types(python: Path, tmp_path: Path) -> None:
    (tmp_path / "user.py").write_text(TYPED)
    command = [python, "-m", "mypy", "--strict", "--hide-error-context", "user.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    told = [line.split('"')[1] for line in done.stdout.splitlines() if "Revealed type" in line]
    wanted = REVEALED.strip().splitlines()
    assert len(told) == len(wanted), done.stdout + done.stderr
    assert all(part in line for line, parts in zip(told, wanted, strict=True) for part in parts.split(" ")), told
    assert "No overload variant" in done.stdout
    assert 'no attribute "calibrat"' in done.stdout
    assert 'Argument "limit" to "assert_accuracy" has incompatible type "str"' in done.stdout


def test_the_wheel_is_as_large_as_the_readme_says(tmp_path: Path) -> None:
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", tmp_path, str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("*.whl")
    told = re.search(r"The wheel has (\d+) MB", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert told
    assert round(wheel.stat().st_size / 1e6) == int(told[1])
