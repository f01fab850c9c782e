"""Python objects of others, in a process of their own: a hang, a crash and an exception cost one fit each."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from calib import Reference
from recordings import Recording
from scenarios.errors import InputError
from tests.validation.calibrating.conftest import OFFSET_NT
from validation.calibrating.calibrator_entry import CalibratorEntry
from validation.calibrating.object_server import load_object
from validation.calibrating.selection import select_calibrators

MODULE = """
import os, time
from pathlib import Path
import numpy as np

def sphere(recording, reference):
    match int(reference.strength_nT):
        case 50_001:
            time.sleep(60)
        case 50_002:
            print("out of luck")
            os._exit(3)
        case 50_003:
            raise ValueError("no pivot")
        case 50_004:
            return np.zeros(3), np.zeros((3, 3))
    mag = recording.mag_nT / reference.strength_nT
    found = np.linalg.lstsq(np.c_[2 * mag, np.ones(len(mag))], (mag**2).sum(1), rcond=None)[0]
    return reference.strength_nT * found[:3], np.eye(3)

class Needy:
    needs = ("attitude",)
    whole_array = True
    def __call__(self, recording, reference): ...

needy = Needy()
number = 3
"""


@pytest.fixture(scope="module", autouse=True)
def here(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A directory with a module of somebody's, where the program is started."""
    place = tmp_path_factory.mktemp("theirs")
    (place / "somebodys.py").write_text(MODULE, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        yield place


@pytest.fixture(scope="module")
def sphere() -> CalibratorEntry:
    return select_calibrators(["mine=somebodys:sphere"], time_limit_s=0.5)[0]


def test_an_object_of_this_directory_fits(sphere: CalibratorEntry, recording: Recording, reference: Reference) -> None:
    found = sphere.fit_timed(recording, reference)
    assert (sphere.name, sphere.attitude_free, sphere.whole_array) == ("mine", True, False)
    assert (found.calibration.name, found.calibration.status.kind) == ("mine", "ok")
    np.testing.assert_allclose(found.calibration.offset_nT, OFFSET_NT, atol=1.0)
    assert 0.0 < found.cpu_s < 10.0
    assert 0.0 < found.calibration.wall_s < 10.0


@pytest.mark.parametrize(
    ("strength_nT", "told"),
    [
        (50_001.0, "stopped at the time limit"),
        (50_002.0, "exit status 3; it said: out of luck"),
        (50_003.0, "ValueError: no pivot (somebodys.py:14)"),
        (50_004.0, "singular"),
    ],
)
def test_what_goes_wrong_costs_one_fit(
    sphere: CalibratorEntry, recording: Recording, reference: Reference, strength_nT: float, told: str
) -> None:
    begun_s = time.monotonic()
    found = sphere.fit(recording, Reference(strength_nT))
    assert (found.status.kind, told in found.status.reason) == ("not_converged", True), found.status.reason
    assert time.monotonic() - begun_s < 30.0
    assert sphere.fit(recording, reference).status.kind == "ok"


def test_what_an_object_says_of_itself_is_heard_also_when_it_has_changed(here: Path) -> None:
    (here / "changing.py").write_text(MODULE, encoding="utf-8")
    (needy,) = select_calibrators(["changing:needy"])
    assert (needy.name, needy.attitude_free, needy.whole_array) == ("needy", False, True)
    (here / "changing.py").write_text(MODULE.replace('"attitude"', '"gyro"'), encoding="utf-8")
    (other,) = select_calibrators(["changing:needy"])
    assert (other.attitude_free, repr(other) == repr(needy)) == (True, False)


@pytest.mark.parametrize(
    ("spec", "told"),
    [
        ("nobodys:fit", "No module named 'nobodys'"),
        ("somebodys:fit", "has no fit"),
        ("somebodys:needy.fit", "has no needy.fit"),
        ("somebodys:number", "is of type int"),
    ],
)
def test_what_cannot_be_loaded_says_why(spec: str, told: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(here)
    with pytest.raises(InputError, match=told):
        load_object(spec)


@pytest.mark.parametrize(
    ("spec", "told"),
    [
        ("somebodys:number", "somebodys:number: is of type int"),
        ("somebodys", "no calibrator is called 'somebodys'"),
        ("./somebodys.py:sphere", "no calibrator is called"),
    ],
)
def test_what_cannot_be_had_is_refused(spec: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        select_calibrators([spec])
