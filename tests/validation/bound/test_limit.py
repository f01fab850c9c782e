"""The limit of tilts: the standard case's figures, which others computed too, and that no motion is below it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scenarios.errors import InputError
from tests.calib import conftest as standard
from tests.validation.bound.experiments import along, of_motion
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.limit import GAP, Tilts, limit, optimal

LIMITS_NT = {
    "norm": {"full": 0.500, "pitch": 4.11, "auv": 178.0},
    "vector": {"full": 0.289, "pitch": 0.53, "auv": 4.47},
}
TILTS = {"full": Tilts(180.0, 90.0), "pitch": Tilts(5.0, 45.0), "auv": Tilts(5.0, 5.0)}


def known_of(motion: str) -> Experiment:
    return replace(of_motion(motion), field_enu_nT=np.array(standard.FIELD_ENU_NT))


@pytest.mark.parametrize("knowledge", LIMITS_NT)
@pytest.mark.parametrize("motion", TILTS)
def test_the_standard_case(motion: str, knowledge: str) -> None:
    known = known_of(motion)
    found = limit(known, knowledge, TILTS[motion])
    assert found.value == pytest.approx(LIMITS_NT[knowledge][motion], rel=0.01)
    assert found.gap <= GAP
    assert found.value <= Bound.of(known, knowledge).offset_rms_nT * (1 + GAP)


def test_the_design_flown_reaches_the_limit() -> None:
    """Its attitudes, each as often as the design says, with the information of the samples themselves."""
    known = known_of("pitch")
    found = limit(known, "norm", TILTS["pitch"])
    often = np.random.default_rng(1).multinomial(100_000, found.weights)
    flown = along(found.attitudes[np.repeat(np.arange(len(often)), often)])
    reached = Bound.of(flown, "norm").offset_rms_nT * np.sqrt(len(flown.field_nT) / len(known.field_nT))
    assert reached == pytest.approx(found.value, rel=0.03)


@pytest.mark.parametrize("seed", range(3))
def test_no_design_is_below_it(seed: int) -> None:
    """Random ones within the tilts, of few attitudes and of many."""
    rng, known, tilts = np.random.default_rng(seed), known_of("auv"), TILTS["auv"]
    least = limit(known, "norm", tilts).value
    angles = np.column_stack([rng.uniform(0, 360, 40), rng.choice([-5, 0, 5], 40), rng.choice([-5, 0, 5], 40)])
    flown = along(Rotation.from_euler("ZYX", np.repeat(angles, 90, axis=0), degrees=True))
    assert Bound.of(flown, "norm").offset_rms_nT > least * (1 - GAP)


def test_two_candidates_by_hand() -> None:
    """Rows a and b along the axes: f = 1 / (w a^2) + 1 / ((1 - w) b^2) is least at w = b / (a + b)."""
    variance, gap, weights = optimal(np.array([[[3.0, 0.0]], [[0.0, 1.0]]]), np.eye(2))
    np.testing.assert_allclose(weights, [0.25, 0.75], rtol=2 * np.sqrt(GAP))
    assert variance == pytest.approx((1 / 3 + 1) ** 2, rel=3 * GAP)
    assert gap <= GAP


def test_level_flight_tells_no_offset() -> None:
    assert limit(known_of("auv"), "norm", Tilts(0.0, 0.0)).value == np.inf


def test_pitch_alone_tells_the_offset() -> None:
    """Each attitude is there once, and no motion of the kind is below it."""
    known, tilts = known_of("pitch"), Tilts(0.0, 45.0)
    assert len(np.unique(tilts.angles_deg(), axis=0)) == len(tilts.angles_deg())
    angles = np.column_stack([np.arange(3600) * 7.0, 45.0 * np.sin(np.arange(3600)), np.zeros(3600)])
    flown = Bound.of(along(Rotation.from_euler("ZYX", angles, degrees=True)), "norm").offset_rms_nT
    assert 0 < limit(known, "norm", tilts).value < flown < np.inf


def test_what_has_no_limit_says_so() -> None:
    with pytest.raises(InputError, match="order of the samples"):
        limit(known_of("auv"), "norm+gyro+accel", Tilts(5.0, 5.0))
    with pytest.raises(InputError, match="--field-enu-nT"):
        limit(of_motion("auv"), "norm", Tilts(5.0, 5.0))
    for text in ("5", "5,x", "200,5", "-1,5", "5,nan"):
        with pytest.raises(InputError, match="no pair of tilts"):
            Tilts.parsed(text, "--tilt-limits")


@pytest.mark.parametrize("motion", ["pitch", "auv"])
def test_a_gyro_without_noise_and_bias_is_what_its_limit_counts(motion: str) -> None:
    """Below the bound of any gyro, and what a motion's own attitudes tell whose directions are all known."""
    known, tilts = known_of(motion), TILTS[motion]
    least = limit(known, "norm+gyro", tilts).value
    for std in (1e-3, 1e-6):
        assert least < Bound.of(replace(known, gyro_std_rad_s=std), "norm+gyro").offset_rms_nT
    assert least < limit(known, "norm", tilts).value
    h = known.field_nT / known.strength_nT
    rows = np.zeros((len(h), 3, 9))
    rows[:, :, :3] = np.eye(3)
    for k, (i, j) in enumerate([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]):
        rows[:, i, 3 + k], rows[:, j, 3 + k] = h[:, j], h[:, i]
    told = np.linalg.inv(np.einsum("nri,nrj->ij", rows, rows) / known.noise_std_nT**2)
    assert least < np.sqrt(np.trace(told[:3, :3]))
    assert np.sqrt(np.trace(told[:3, :3])) < Bound.of(replace(known, gyro_std_rad_s=1e-6), "norm+gyro").offset_rms_nT


def test_the_tilts_of_a_motion() -> None:
    found = Tilts.of(Rotation.from_euler("ZYX", [[170, 4, -7], [10, -9, 3]], degrees=True))
    assert (found.roll_deg, found.pitch_deg) == pytest.approx((7, 9))
