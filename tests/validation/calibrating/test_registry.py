"""Objects registered in this process: found by name here, and in other processes only where those can find them."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import magbench
from calib import Calibration, Reference
from calib.methods.sphere import SphereCalibrator
from recordings import Recording
from scenarios.errors import InputError
from tests.validation.calibrating.conftest import OFFSET_NT
from validation.calibrating import registry
from validation.calibrating.selection import known_names, select_calibrators


@pytest.fixture(autouse=True)
def _nothing_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "REGISTERED", registered := {})
    monkeypatch.setattr("validation.calibrating.selection.REGISTERED", registered)


def exact(recording: Recording, reference: Reference) -> tuple[object, object]:
    return OFFSET_NT, np.eye(3)


def test_a_function_is_known_by_its_name(recording: Recording, reference: Reference) -> None:
    assert magbench.register(exact) is exact
    (candidate,) = select_calibrators(["exact"])
    np.testing.assert_array_equal(candidate.fit(recording, reference).offset_nT, OFFSET_NT)
    assert known_names()["exact"] == "registered in this process"
    assert list(magbench.calibrate(recording, 50_000.0, with_=["exact", "sphere"])) == ["exact", "sphere"]


def test_decorators_and_instances(recording: Recording, reference: Reference) -> None:
    @magbench.register(name="mine")
    def fit(recording: Recording, reference: Reference) -> Calibration:
        raise ValueError("no pivot")

    magbench.register(SphereCalibrator(attitude_std_rad=0.1), name="my-sphere")
    mine, sphere = select_calibrators(["mine", "my-sphere"])
    assert mine.fit(recording, reference).status.reason == "ValueError: no pivot"
    assert sphere.fit(recording, reference).status.kind == "ok"


def test_what_another_process_would_not_find_is_refused() -> None:
    magbench.register(lambda recording, reference: None, name="nameless")
    magbench.register(SphereCalibrator(), name="my-sphere")
    nameless, sphere = select_calibrators(["nameless", "my-sphere"])
    assert pickle.loads(pickle.dumps(sphere)) == sphere
    with pytest.raises(InputError, match="module:object"):
        pickle.dumps(nameless)


@pytest.mark.parametrize(
    ("found", "name", "told"),
    [(exact, "ellipsoid", "magbench's own"), (3, "three", "int"), (exact, "a b", "no name"), (3, None, "no name")],
)
def test_what_cannot_be_registered(found: object, name: str | None, told: str) -> None:
    with pytest.raises(InputError, match=told):
        magbench.register(found, name=name)


def test_two_of_one_name_are_refused() -> None:
    magbench.register(exact, name="true")
    with pytest.raises(InputError, match="two calibrators are called 'true'"):
        select_calibrators(["true"], ["true {recording} {result}"])
