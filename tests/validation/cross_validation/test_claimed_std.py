"""Claims against the scatter by legs: as claimed in white noise, and what is short of something is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib import Reference, get
from calib.held_out.legs import legs_of
from calib.methods.ml_geometric import MaximumLikelihoodGeometric
from recordings import read_recording
from tests.validation.cross_validation.conftest import FIELD_ENU_NT, STRENGTH_NT, Made, soft_iron
from validation.cross_validation.claimed_std import Claim, claim_of, claims_of

STRENGTH, VECTOR = Reference(STRENGTH_NT), Reference.of_vector(FIELD_ENU_NT)


@pytest.mark.parametrize(("name", "reference"), [("ml_geometric", STRENGTH), ("vector_least_squares", VECTOR)])
def test_in_white_noise_the_offset_scatters_as_claimed(name: str, reference: Reference, made: Made) -> None:
    found = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        recording = made(rng, soft_iron(0.03, rng), attitude=True)
        claim = claim_of(get(name).fit(recording, reference), recording, reference, legs_of(recording))
        assert claim is not None
        found.append(claim)
    assert np.sqrt(np.mean([one.ratio**2 for one in found])) == pytest.approx(1.0, abs=0.1)
    assert sum(one.ratio > one.limit for one in found) <= 3


def test_the_scatter_is_that_of_refits_of_the_legs_alone(made: Made) -> None:
    """Of a linear fit with legs of equal weight: each leg's own offsets scatter about their mean by as much."""
    rng = np.random.default_rng(0)
    recording = made(rng, np.eye(3), kind="tumble", n=4_000, attitude=True)
    legs = legs_of(recording)
    fit = get("vector_least_squares").fit(recording, VECTOR)
    claim = claim_of(fit, recording, VECTOR, legs)
    assert claim is not None
    slow = np.repeat(rng.standard_normal((legs.count, 3)), legs.sizes, axis=0)
    jumpy = replace(recording, mag_nT=recording.mag_nT + 20.0 * slow)
    narrow = replace(get("vector_least_squares").fit(jumpy, VECTOR), covariance=fit.covariance)
    found = claim_of(narrow, jumpy, VECTOR, legs)
    assert found is not None
    moved = [get("vector_least_squares").fit(jumpy.taken(legs.number != leg), VECTOR) for leg in range(legs.count)]
    offsets = np.array([one.offset_nT for one in moved])
    jackknife = (legs.count - 1) * offsets.var(axis=0) / np.diag(fit.offset_covariance_nT2)
    assert found.ratio == pytest.approx(float(np.sqrt(jackknife.mean())), rel=0.25)
    assert found.ratio > found.limit
    assert "multiply the claim by" in found.sentence


def test_a_sphere_in_soft_iron_is_told_to_lack_something(made: Made) -> None:
    rng = np.random.default_rng(2)
    recording = made(rng, soft_iron(0.01, rng), kind="tumble")
    fits = {name: get(name).fit(recording, STRENGTH) for name in ("sphere", "ellipsoid", "kalman", "gyro_ml")}
    found = claims_of(fits, recording, STRENGTH)
    assert set(found) <= {"sphere", "ellipsoid"}
    assert found["ellipsoid"].sentence == ""


def test_what_is_said() -> None:
    assert Claim(1.2, 1.3, 20).sentence == ""
    assert "so few" in Claim(1.6, 1.7, 6).sentence
    assert "not white" in Claim(1.7, 1.4, 20).sentence


def test_measured_compasses_and_the_glider_scatter_as_claimed(realdata: Path) -> None:
    """Within 1.5 by legs; two halves of twelve poses, nine parameters each, differ by more than that by chance."""
    for file in [*sorted((realdata / "cave-compass").glob("*.parquet")), realdata / "glider" / "five_dives.parquet"]:
        recording = read_recording(file)
        reference = Reference(float(np.median(np.linalg.norm(recording.mag_nT, axis=1))))
        fit = MaximumLikelihoodGeometric().fit(recording, reference)
        claim = claim_of(fit, recording, reference, legs_of(recording))
        assert claim is not None
        assert claim.ratio <= 1.5 or claim.sentence, file.name
