"""No calibrator says ok with a wrong answer: repeated and dead axes, a field that does not change, extreme values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib import CALIBRATORS, Calibration, Reference, Status, get
from calib.acceptance import CorrectedField, residual_of, unsupported, widened
from calib.result import OFFSET_NAMES
from recordings import Recording
from tests.calib.conftest import REFERENCE
from tests.calib.expected import SECONDS_A_FIT, SLOW_WITHOUT_ANSWER, expected
from tests.calib.flickering import flicker
from tests.calib.test_contract import with_all

ALL = pytest.mark.parametrize("name", list(CALIBRATORS))


def repeated(recording: Recording) -> Recording:
    """y is a copy of x, noise and all."""
    return replace(recording, mag_nT=recording.mag_nT[:, [0, 0, 2]])


def nearly_repeated(recording: Recording) -> Recording:
    """y measures what x does, with noise of its own."""
    noise_nT = np.random.default_rng(1).normal(0.0, 10.0, len(recording))
    return replace(recording, mag_nT=recording.mag_nT[:, [0, 0, 2]] + noise_nT[:, None] * [0.0, 1.0, 0.0])


def dead(recording: Recording) -> Recording:
    """z measures nothing but noise."""
    mag_nT = recording.mag_nT.copy()
    mag_nT[:, 2] = np.random.default_rng(1).normal(500.0, 10.0, len(recording))
    return replace(recording, mag_nT=mag_nT)


def still(recording: Recording) -> Recording:
    """The attitude moves and the measured field does not: noise alone."""
    noise_nT = np.random.default_rng(1).normal(0.0, 10.0, recording.mag_nT.shape)
    return replace(recording, mag_nT=recording.mag_nT[:1] + noise_nT)


def shortly_still(recording: Recording) -> Recording:
    """The same for six seconds."""
    short = {key: getattr(recording, key)[:64] for key in ("time_s", "mag_nT", "gyro_rad_s", "att_q")}
    return still(replace(recording, **short))


def huge(recording: Recording) -> Recording:
    """Values whose squares overflow."""
    return replace(recording, mag_nT=recording.mag_nT * 1e200)


def tiny(recording: Recording) -> Recording:
    """Values whose squares vanish."""
    return replace(recording, mag_nT=recording.mag_nT * 1e-200)


def far(recording: Recording) -> Recording:
    """An offset that leaves no digits for the field."""
    return replace(recording, mag_nT=recording.mag_nT + 1e21)


def spiked(recording: Recording) -> Recording:
    """A spike that is larger than all else."""
    mag_nT = recording.mag_nT.copy()
    mag_nT[17] = [1e12, -1e12, 1e12]
    return replace(recording, mag_nT=mag_nT)


CASES = (repeated, nearly_repeated, dead, still, shortly_still, huge, tiny, far, spiked)
LEFT_IN = (spiked,)
"""Cases that are fitted with wild values left in; `test_robust` has them left out."""


def marks(name, k):
    """Of a calibrator that tries for long every third case by day, taken in turn; every case of the others."""
    slow = (*SLOW_WITHOUT_ANSWER, *SECONDS_A_FIT)
    return [pytest.mark.slow] * (name in slow and (slow.index(name) + k) % 3 != 0)


@pytest.mark.parametrize(
    ("case", "name"),
    [
        pytest.param(case, name, marks=marks(name, k), id=f"{case.__name__}-{name}")
        for k, case in enumerate(CASES)
        for name in CALIBRATORS
    ],
)
def test_never_ok_where_nothing_can_be_known(name, case, standard):
    method = replace(get(name), robust=case not in LEFT_IN)
    if hasattr(method, "iterations"):
        method = replace(method, iterations=min(method.iterations, 200))
    recording = with_all(case(standard.recording("full", 2, n=300)), name, standard)
    result = method.fit(recording, standard.REFERENCE)
    if expected(name).corrects:
        assert result.status.kind != "ok", (result.offset_nT, result.matrix)
        assert result.status.reason


def answer(**changes) -> Calibration:
    return Calibration(**({"name": "x", "status": Status("ok")} | changes))


SMALL = np.full(100, 30.0)


def test_an_answer_that_all_bears_out_is_believed():
    assert unsupported(answer(), SMALL, Reference(5e4)) is None


@pytest.mark.parametrize(("stretch", "kind"), [(49.0, None), (51.0, "unobservable")])
def test_a_matrix_that_turns_noise_into_field_is_not_believed(stretch, kind):
    status = unsupported(answer(matrix=np.diag([1.0, 1.0, stretch])), SMALL, Reference(5e4))
    assert (status.kind if status else None) == kind
    assert status is None or "offset along body z" in status.reason


@pytest.mark.parametrize("stretch", [400.0, 1 / 400.0])
def test_a_matrix_that_turns_noise_into_field_is_told_before_its_own_claim(stretch):
    """Noise that is taken for motion leaves a sure offset along its axis: the claim is large along another."""
    claim = np.diag([1.0, 600.0, 1.0]) ** 2
    fit = answer(matrix=np.diag([2.0, 2.1, 2.0 * stretch]), covariance=claim, covariance_names=OFFSET_NAMES)
    status = unsupported(fit, SMALL, Reference(5e4))
    assert status is not None
    assert "offset along body z" in status.reason
    assert "roll and pitch" in status.reason


@pytest.mark.parametrize(("share", "kind"), [(0.09, None), (0.11, "not_converged")])
def test_what_is_left_must_be_a_small_part_of_the_field(share, kind):
    left_nT = np.where(np.arange(101) % 2 == 0, share * 5e4, -share * 5e4)
    for residual_nT in (left_nT, np.outer(left_nT, [0.6, 0.0, 0.8])):
        status = unsupported(answer(), residual_nT, Reference(5e4))
        assert (status.kind if status else None) == kind


def test_a_few_spikes_are_no_misfit():
    residual_nT = SMALL.copy()
    residual_nT[:40] = 1e9
    assert unsupported(answer(), residual_nT, Reference(5e4)) is None


@pytest.mark.parametrize("covariance", [np.diag([1.0, -1.0, 1.0]), 2.0 * np.ones((3, 3)) - np.eye(3)])
def test_a_covariance_that_is_none_is_not_believed(covariance):
    status = unsupported(answer(covariance=covariance, covariance_names=OFFSET_NAMES), SMALL, Reference(5e4))
    assert status is not None
    assert status.kind == "not_converged"
    assert "positive definite" in status.reason


def claimed(standard, added_nT):
    """A fit of the standard case's truth with a small claim, its recording with noise added, and what that leaves."""
    recording = standard.recording("full", 0)
    recording = replace(recording, mag_nT=recording.mag_nT + added_nT)
    matrix = np.linalg.inv(standard.SOFT)
    fit = answer(covariance=np.eye(3) * 1e-4, covariance_names=OFFSET_NAMES, matrix=matrix, offset_nT=standard.HARD_NT)
    return fit, recording, residual_of(fit, recording, standard.REFERENCE, vector=False)


def field_of(fit, recording):
    return CorrectedField(fit, recording, REFERENCE.strength_nT)


@pytest.mark.parametrize("vector", [False, True])
def test_only_the_claim_is_widened_and_flicker_noise_goes_to_the_offset(vector, standard):
    """A tone is colour and no flicker; flicker noise of 6 nT is found and adds what lasts of it to the offset."""
    tone_nT = 20.0 * np.sin(np.arange(3600) / 2.0)[:, None]
    fit, recording, left_nT = claimed(standard, tone_nT)
    widest = widened(fit, left_nT, field_of(fit, recording), standard.REFERENCE, vector=vector)
    factor = widest.parameters["covariance_inflation"]
    assert factor >= 1.0
    assert widest.parameters["flicker_nT_sqrt_hz"] == 0.0
    np.testing.assert_allclose(widest.covariance, factor * fit.covariance)
    fit, recording, left_nT = claimed(standard, 6.0 * flicker(3600, np.random.default_rng(0)))
    lasting = widened(fit, left_nT, field_of(fit, recording), standard.REFERENCE, vector=vector)
    power_nT2 = lasting.parameters["flicker_nT_sqrt_hz"] ** 2
    assert 4.0 < np.sqrt(power_nT2) < 8.0
    added_nT2 = lasting.covariance - lasting.parameters["covariance_inflation"] * fit.covariance
    lowest, highest = 7.5 * power_nT2, 1.7 * 7.5 * power_nT2  # of the power, and of what it may be
    assert 0.9 * lowest < np.diag(added_nT2).min()
    assert np.diag(added_nT2).max() < highest
    unclaimed = answer()
    field = field_of(unclaimed, recording)
    assert widened(unclaimed, left_nT, field, standard.REFERENCE, vector=vector).covariance is None
