"""What a candidate says of itself, in this process and in another, and that it answers whatever happens."""

from __future__ import annotations

import pickle
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import CALIBRATORS, Reference, get
from recordings import Recording
from scenarios.errors import InputError
from validation.calibrating.calibrator_entry import CalibratorEntry, TimedCalibration
from validation.calibrating.selection import calibrators_of_scenario, select_calibrators

REFERENCE = Reference(50_000.0)


@pytest.fixture(scope="module")
def recording() -> Recording:
    """A sensor with an offset of (100, -200, 300) nT, turned every way."""
    rng = np.random.default_rng(0)
    field_nT = Rotation.random(200, rng=rng).apply([0.0, 30_000.0, -40_000.0])
    noise_nT = rng.normal((100.0, -200.0, 300.0), 2.0, (200, 3))
    return Recording(np.arange(200.0), field_nT + noise_nT)


def test_every_built_in_calibrator_is_a_candidate_that_can_be_sent() -> None:
    found = select_calibrators(list(CALIBRATORS))
    assert [candidate.name for candidate in found] == list(CALIBRATORS)
    assert pickle.loads(pickle.dumps(found)) == found
    facts = {candidate.name: (candidate.attitude_free, candidate.whole_array) for candidate in found}
    assert facts["ellipsoid"] == (True, False)
    assert facts["vector_least_squares"] == (False, False)
    assert facts["least_squares_gradiometer"] == (True, True)


def test_a_built_in_candidate_fits_as_its_calibrator_does(recording: Recording) -> None:
    (candidate,) = select_calibrators(["pso"])
    there = candidate.fit(recording, REFERENCE, np.random.default_rng(3))
    here = get("pso").fit(recording, REFERENCE, np.random.default_rng(3))
    np.testing.assert_array_equal(there.offset_nT, here.offset_nT)


def test_a_name_with_options_is_a_candidate_of_its_own(recording: Recording) -> None:
    plain, limited = select_calibrators(["ml_geometric", "ml_geometric:huber=0.5"])
    assert (limited.name, limited.needs, limited.attitude_free) == ("ml_geometric:huber=0.5", (), True)
    assert pickle.loads(pickle.dumps(limited)) == limited
    found = limited.fit(recording, REFERENCE)
    assert found.name == "ml_geometric:huber=0.5"
    np.testing.assert_array_equal(
        found.offset_nT, replace(get("ml_geometric"), huber=0.5).fit(recording, REFERENCE).offset_nT
    )
    assert np.any(found.offset_nT != plain.fit(recording, REFERENCE).offset_nT)
    with pytest.raises(InputError, match="ml_geometric has no option 'hubber'"):
        select_calibrators(["ml_geometric:hubber"])


def test_a_name_given_twice_is_one_candidate_and_an_unknown_one_is_refused() -> None:
    assert len(select_calibrators(["sphere", "sphere"])) == 1
    with pytest.raises(InputError, match=r"'cube'.*twostep.*module:object"):
        select_calibrators(["sphere", "cube"])


@dataclass(frozen=True)
class Broken:
    def fit(self, *_: object) -> TimedCalibration:
        raise ValueError("no pivot")


def test_an_exception_becomes_the_reason(recording: Recording) -> None:
    fitted = CalibratorEntry("broken", Broken(), attitude_free=True).fit_timed(recording, REFERENCE)
    assert fitted.calibration.status.kind == "not_converged"
    assert fitted.calibration.status.reason == "ValueError: no pivot"
    assert fitted.calibration.name == "broken"


def test_a_scenario_imports_no_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever wrote the scenario does not run code of the directory; the user's own option does."""
    (tmp_path / "own_module.py").write_text("open('ran', 'a').close()\ndef fit(recording, reference): return None\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"calibrators: 'own_module:fit' .* \(give --with own_module:fit\)"):
        calibrators_of_scenario(["sphere", "own_module:fit"])
    assert not (tmp_path / "ran").exists()
    assert [one.name for one in calibrators_of_scenario(["sphere", "ml_geometric:huber"])] == [
        "sphere",
        "ml_geometric:huber",
    ]
