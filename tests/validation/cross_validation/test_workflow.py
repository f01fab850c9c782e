"""The answer against the true error on another motion, over many simulated recordings."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib import Reference
from calib.held_out.models import Model
from recordings import read_recording
from scenarios.errors import InputError
from tests.validation.cross_validation.conftest import FIELD_ENU_NT, STRENGTH_NT, Made, soft_iron
from validation.cross_validation.summary import headline, summary
from validation.cross_validation.workflow import CrossValidation, cross_validate

PASSED_FOR_IRON = (6, 8, 12, 13, 15, 19)
STRENGTH, VECTOR = Reference(STRENGTH_NT), Reference.of_vector(FIELD_ENU_NT)


def first(found: tuple[CrossValidation, ...]) -> CrossValidation:
    (one,) = found
    return one


def verdicts(made: Made, size: float, trials: int) -> Counter[tuple[str, bool]]:
    """How often each verdict on the ellipsoid was given, and whether its true error on another motion is smaller."""
    found: Counter[tuple[str, bool]] = Counter()
    for seed in range(trials):
        rng = np.random.default_rng(seed)
        matrix = soft_iron(size, rng)
        (pair,) = first(cross_validate(made(rng, matrix), STRENGTH)).pairs
        elsewhere = made(rng, matrix, noise_nT=0.0).mag_nT / STRENGTH_NT
        simpler, richer = (true_error(one.model, elsewhere) for one in (pair.simpler, pair.richer))
        found[pair.verdict, richer < simpler] += 1
    return found


def true_error(model: Model, elsewhere: np.ndarray) -> float:
    moved = replace(model, mag=elsewhere, more=np.zeros((len(elsewhere), 3, 0)))
    return float(np.sum(moved.misfit() ** 2))


def test_without_soft_iron_the_ellipsoid_is_not_worth_it(made: Made) -> None:
    found = verdicts(made, 0.0, 60)
    assert sum(n for (verdict, _), n in found.items() if verdict == "worth_it") <= 3
    assert sum(n for (verdict, _), n in found.items() if verdict in {"as_well", "worse"}) >= 45


@pytest.mark.parametrize(("size", "least"), [(3e-4, 12), (0.05, 20)])
def test_worth_it_is_said_where_the_true_error_is_smaller(made: Made, size: float, least: int) -> None:
    found = verdicts(made, size, 20)
    assert found["worth_it", True] >= least
    assert found["worth_it", False] == 0


@pytest.mark.slow
def test_false_worth_it_stays_below_five_in_a_hundred(made: Made) -> None:
    found = verdicts(made, 0.0, 400)
    assert sum(n for (verdict, _), n in found.items() if verdict == "worth_it") <= 20


def test_a_temperature_that_moves_the_offset_is_worth_it(made: Made) -> None:
    rng = np.random.default_rng(1)
    warmth = 15.0 + 5.0 * np.sin(np.linspace(0.0, 20.0, 600))
    recording = made(rng, np.eye(3), kind="tumble", warmth=warmth, added=warmth[:, None] * [3.0, -2.0, 1.0])
    found = first(cross_validate(recording, STRENGTH))
    pair = found.pairs[1]
    assert (pair.richer.model.name, pair.verdict) == ("offset with temperature", "worth_it")
    assert found.keep == "offset with temperature"
    assert pair.richer.typical_nT == pytest.approx(5.0 * np.sqrt(2.0 / np.pi) * 1.25, rel=0.1)


def test_a_temperature_that_is_left_out_does_not_pass_for_soft_iron_in_the_end(made: Made) -> None:
    """It does at first, in these of the first twenty; asked again beside the temperature soft iron is not taken."""
    warmth, kept = 15.0 + 5.0 * np.sin(np.linspace(0.0, 18.85, 600)), Counter[str]()
    drift = warmth[:, None] * [10.0, -5.0, 3.0]
    for seed in PASSED_FOR_IRON:
        recording = made(np.random.default_rng(seed), np.eye(3), kind="tumble", warmth=warmth, added=drift)
        kept[first(cross_validate(recording, STRENGTH)).keep] += 1
    assert kept == {"offset with temperature": len(PASSED_FOR_IRON)}


def test_a_drift_is_seldom_taken_for_the_temperature(made: Made) -> None:
    """A random walk, and a sensor that cools down beside it: half of the time the temperature fits the drift."""
    cooling, said = 10.0 + 8.0 * np.exp(-np.linspace(0.0, 3.0, 600)), Counter[str]()
    for seed in range(20):
        rng = np.random.default_rng(seed)
        drift = 100.0 / np.sqrt(600.0) * np.cumsum(rng.standard_normal((600, 3)), axis=0)
        recording = made(rng, np.eye(3), kind="tumble", warmth=cooling, added=drift)
        said[first(cross_validate(recording, STRENGTH)).pairs[1].verdict] += 1
    assert said["worth_it"] <= 2


def test_eddy_currents_are_found_with_the_vector_known(made: Made) -> None:
    """B dh/dt of an iron hull, from the difference of true fields; in a tumble without it they only add noise."""
    clean = made(np.random.default_rng(3), np.eye(3), kind="tumble", noise_nT=0.0).mag_nT
    eddy = np.gradient(clean, 0.5, axis=0) @ np.array([[0.02, 0.0, 0.01], [0.0, 0.03, 0.0], [-0.01, 0.0, 0.02]])
    for added, verdict in ((eddy, "worth_it"), (0.0, "as_well")):
        recording = made(np.random.default_rng(3), np.eye(3), kind="tumble", attitude=True, added=added)
        found = first(cross_validate(recording, VECTOR))
        assert found.knowledge == "vector"
        assert found.pairs[1].richer.model.count - found.pairs[1].simpler.model.count == 9
        assert found.pairs[1].verdict == verdict or (added is not eddy and found.pairs[1].verdict == "worse")


def test_the_answer_in_words_and_as_json(made: Made) -> None:
    rng = np.random.default_rng(0)
    found = first(cross_validate(made(rng, soft_iron(0.02, rng)), STRENGTH))
    plain = summary(found)
    assert plain["comparisons"][0]["verdict"] == "worth_it"
    assert plain["comparisons"][0]["low_nT"] < plain["comparisons"][0]["better_nT"] < plain["comparisons"][0]["high_nT"]
    assert "The ellipsoid predicts held-out legs" in headline(found)
    assert headline(found).splitlines()[0].endswith("use the ellipsoid.")


def test_an_ellipsoid_that_the_motion_does_not_tell_is_not_recommended(made: Made) -> None:
    """Level circles: soft iron shows in the plane, and nothing tells the vertical offset."""
    time_s = 0.5 * np.arange(600)
    field = np.column_stack([19_000 * np.cos(0.1 * time_s), -19_000 * np.sin(0.1 * time_s), np.full(600, -44_000.0)])
    recording = made(np.random.default_rng(0), np.eye(3))
    mag = field * [1.1, 0.9, 1.0] + 5.0 * np.random.default_rng(1).standard_normal((600, 3))
    found = first(cross_validate(replace(recording, mag_nT=mag), STRENGTH))
    assert found.pairs[0].verdict != "worth_it"
    assert found.keep == ""
    assert "Use none of these models: this motion does not determine the offset." in headline(found)


@pytest.mark.parametrize("seed", range(3))
def test_eddy_currents_that_explain_a_hundredth_of_the_noise_are_not_recommended(made: Made, seed: int) -> None:
    """Noise of 150 nT beside 10 nT rms that follows the field's rate of change, in 20,000 samples."""
    rng = np.random.default_rng(seed)
    recording = made(rng, np.eye(3), kind="tumble", n=20_000, noise_nT=150.0, attitude=True)
    clean = made(np.random.default_rng(seed), np.eye(3), kind="tumble", n=20_000, noise_nT=0.0).mag_nT
    change = np.gradient(clean, 0.5, axis=0)
    added = 10.0 * np.sqrt(3.0) * change / np.sqrt(np.mean(np.sum(change**2, axis=1)))
    found = first(cross_validate(replace(recording, mag_nT=recording.mag_nT + added), VECTOR))
    eddy = next(pair for pair in found.pairs if "eddy" in pair.richer.model.name)
    assert eddy.verdict == "as_well"
    assert eddy.interval_nT[0] > 0
    assert "too little to matter" in headline(found)
    assert "eddy" not in found.keep


@pytest.mark.parametrize("attitude", [False, True])
def test_rounding_is_no_gain(made: Made, attitude: bool) -> None:
    """A field that never changes, and a sphere without noise."""
    recording = made(np.random.default_rng(0), np.eye(3), kind="tumble", noise_nT=0.0, attitude=attitude)
    still = replace(recording, mag_nT=np.tile([2e4, 3e4, 1e4], (600, 1)), gyro_rad_s=np.zeros((600, 3)))
    reference = VECTOR if attitude else STRENGTH
    exact, eddy = first(cross_validate(recording, reference)), first(cross_validate(still, reference)).pairs[1]
    assert all(pair.verdict != "worth_it" for pair in exact.pairs)
    assert eddy.verdict == "as_well"


def test_too_short_a_recording_is_refused(made: Made) -> None:
    recording = made(np.random.default_rng(0), np.eye(3), n=20)
    with pytest.raises(InputError, match="too few"):
        cross_validate(recording, STRENGTH)


def test_measured_compasses_and_the_glider_need_the_ellipsoid(realdata: Path) -> None:
    files = [*sorted((realdata / "cave-compass").glob("*.parquet")), realdata / "glider" / "five_dives.parquet"]
    assert len(files) == 8
    for file in files:
        recording = read_recording(file)
        strength_nT = float(np.median(np.linalg.norm(recording.mag_nT, axis=1)))
        pair = first(cross_validate(recording, Reference(strength_nT))).pairs[0]
        assert (file.name, pair.verdict) == (file.name, "worth_it")
        assert pair.richer.typical_nT < 0.4 * pair.simpler.typical_nT
