"""What others' calibrators may be and answer, and that their answers are checked but not judged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Calibration, Calibrator, Reference, Status
from calib.external import calibration_of, external_method, fit_external, needs_of
from recordings import Recording
from scenarios.errors import InputError

REFERENCE = Reference(50_000.0)
OFFSET_NT, MATRIX = np.array([100.0, -200.0, 300.0]), np.diag([1.1, 0.9, 1.0])


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Turned every way, without noise: the true matrix is I and the offset OFFSET_NT."""
    field_nT = Rotation.random(100, rng=np.random.default_rng(0)).apply([0.0, 30_000.0, -40_000.0])
    return Recording(np.arange(100.0), field_nT + OFFSET_NT)


def answer_of(answer: object, recording: Recording) -> Calibration:
    return fit_external(lambda *_: answer, recording, REFERENCE, np.random.default_rng(0), "mine")


@pytest.mark.parametrize(
    "answer",
    [
        (OFFSET_NT, MATRIX),
        [OFFSET_NT.tolist(), MATRIX.tolist()],
        {"offset_nT": OFFSET_NT.astype(np.float32), "matrix": MATRIX},
        {"offset_nT": tuple(OFFSET_NT), "matrix": MATRIX, "status": "ok", "parameters": {"rounds": np.int64(3)}},
        Calibration(name="theirs", status=Status("ok"), offset_nT=OFFSET_NT, matrix=MATRIX),
    ],
    ids=["tuple", "list", "dict", "fuller dict", "Calibration"],
)
def test_every_form_of_an_answer_is_the_same_calibration(answer: object, recording: Recording) -> None:
    found = answer_of(answer, recording)
    np.testing.assert_array_equal(found.offset_nT, OFFSET_NT)
    np.testing.assert_array_equal(found.matrix, MATRIX)
    assert (found.name, found.status.kind) == ("mine", "ok")


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (None, "NoneType"),
        (OFFSET_NT, "ndarray"),
        ((OFFSET_NT, MATRIX, 3), "tuple"),
        ((OFFSET_NT[:2], MATRIX), "3 numbers"),
        ((OFFSET_NT, MATRIX.ravel()), "3 x 3 numbers"),
        ((np.full(3, np.nan), MATRIX), "NaN"),
        ((np.full(3, np.inf), MATRIX), "Infinity"),
        ((OFFSET_NT, np.ones((3, 3))), "singular"),
        ((OFFSET_NT, np.zeros((3, 3))), "singular"),
        (({1, 2}, MATRIX), "set"),
        ((1j * OFFSET_NT, MATRIX), "complex"),
        ((1e10 * OFFSET_NT, MATRIX), "tesla"),
        ({"offset_nT": OFFSET_NT}, "matrix"),
        ({"offset": OFFSET_NT, "matrix": MATRIX}, "unknown keys offset"),
        ({"offset_nT": OFFSET_NT, "matrix": MATRIX, "covariance": -np.eye(3)}, "covariance"),
    ],
)
def test_what_is_no_calibration_is_refused_in_one_line(answer: object, told: str, recording: Recording) -> None:
    with pytest.raises(InputError, match=told) as refused:
        answer_of(answer, recording)
    assert "\n" not in str(refused.value)


@dataclass(frozen=True)
class Boastful(Calibrator):
    """Says that it knows the offset to 1 nT, whatever it is, with a matrix that the data do not bear out."""

    name: ClassVar[str] = "boastful"
    summary: ClassVar[str] = "always sure"
    scale: float = 1.5

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration:
        matrix, names = self.scale * np.eye(3), ("offset_x_nT", "offset_y_nT", "offset_z_nT")
        return Calibration(
            name=self.name, status=Status("ok"), matrix=matrix, covariance=np.eye(3), covariance_names=names
        )


def test_the_base_judges_its_own_and_leaves_an_outsiders_claim_alone(recording: Recording) -> None:
    own = Boastful().fit(recording, REFERENCE)
    theirs = fit_external(external_method(Boastful, "there"), recording, REFERENCE, np.random.default_rng(0), "mine")
    assert own.status.kind != "ok"
    assert (theirs.status.kind, theirs.name) == ("ok", "mine")
    np.testing.assert_array_equal(theirs.covariance, np.eye(3))


def test_what_it_needs_is_asked_of_the_recording(recording: Recording) -> None:
    def with_gyro(recording: Recording, reference: Reference) -> Any:
        raise AssertionError("called without a gyro")

    with_gyro.needs = ("gyro",)  # type: ignore[attr-defined]
    found = fit_external(with_gyro, recording, REFERENCE, np.random.default_rng(0), "mine")
    assert (found.status.kind, "gyro_{x,y,z}_rad_s" in found.status.reason) == ("not_applicable", True)


def test_the_recording_cannot_be_changed(recording: Recording) -> None:
    def greedy(recording: Recording, reference: Reference) -> Any:
        recording.mag_nT[:] = 0.0

    with pytest.raises(ValueError, match="read-only"):
        fit_external(greedy, recording, REFERENCE, np.random.default_rng(0), "mine")


@dataclass(frozen=True)
class Demanding(Boastful):
    """Cannot be made without an argument."""

    limit_nT: float = 0.0

    def __post_init__(self) -> None:
        raise TypeError("limit_nT is missing")


@pytest.mark.parametrize(("found", "told"), [(3, "int"), (np, "module"), (dict, "type"), (Demanding, "limit_nT")])
def test_what_is_no_calibrator_is_refused(found: object, told: str) -> None:
    with pytest.raises(InputError, match=told):
        external_method(found, "there")


def test_an_unknown_need_is_refused() -> None:
    def wishful(recording: Recording, reference: Reference) -> Any: ...

    for needs in ("gyro", ("telepathy",), 3):
        wishful.needs = needs  # type: ignore[attr-defined]
        with pytest.raises(InputError, match="needs"):
            needs_of(wishful, "there")


def test_an_answer_of_a_calibrator_with_segments_is_checked_in_each() -> None:
    segments = [{"start_s": 0.0, "offset_nT": [0, 0, 0], "matrix": np.zeros((3, 3))}]
    with pytest.raises(InputError, match="singular"):
        calibration_of({"offset_nT": OFFSET_NT, "matrix": MATRIX, "segments": segments}, "mine")
