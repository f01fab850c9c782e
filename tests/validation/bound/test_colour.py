"""The bound in noise that lasts, against generalised least squares with the dense covariance of its spectrum."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad

from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.chain import Chain
from sim.effects.noise import FLICKER_LOW_HZ, FlickerNoise, WhiteNoise
from sim.effects.offsets import OffsetRandomWalk
from sim.scenario import load
from sim.state import State
from tests.validation.bound.experiments import of_motion
from validation.bound.bound import Bound
from validation.bound.colour import Colour
from validation.bound.information import norm_rows, vector_rows
from validation.bound.limit import Tilts, limit
from validation.bound.query import BoundQuery
from validation.bound.sensor_noise import stated_colour
from validation.bound.summary import headline, summary

SAMPLES = 400
FLICKER, WALK, BOTH = Colour(20.0, 0.0), Colour(0.0, 5.0), Colour(20.0, 5.0)


@cache
def flicker_lags(interval_s: float) -> Array:
    """Covariance (n,) over each lag of the density 1 / f, flat below FLICKER_LOW_HZ."""
    top = 0.5 / interval_s
    return np.array(
        [
            FLICKER_LOW_HZ * 1.0 / FLICKER_LOW_HZ
            + quad(lambda u, t=t: np.cos(2 * np.pi * np.exp(u) * t), np.log(FLICKER_LOW_HZ), np.log(top), limit=2000)[0]
            for t in interval_s * np.arange(SAMPLES)
        ]
    )


def covariance(colour: Colour, interval_s: float) -> Array:
    """C (n, n) of one axis without its white noise: the density d^2 / f, flat below FLICKER_LOW_HZ; min(t, t')."""
    times = interval_s * np.arange(SAMPLES)
    flicker = flicker_lags(interval_s)[np.abs(np.subtract.outer(np.arange(SAMPLES), np.arange(SAMPLES)))]
    walk = np.minimum.outer(times, times)
    return np.asarray(colour.flicker_nT_sqrt_hz**2 * flicker + colour.walk_nT_sqrt_s**2 * walk)


@pytest.mark.filterwarnings("ignore::scipy.integrate.IntegrationWarning")
@pytest.mark.parametrize("colour", [FLICKER, WALK, BOTH], ids=["flicker", "walk", "both"])
@pytest.mark.parametrize("knowledge", ["vector", "norm"])
def test_the_bound_is_that_of_generalised_least_squares(knowledge: str, colour: Colour) -> None:
    known = replace(of_motion("full", SAMPLES), colour=colour)
    C = covariance(colour, float(known.step_s[0]))
    rows = {"vector": vector_rows, "norm": norm_rows}[knowledge](known.field_nT / known.strength_nT, known.matrix)
    toward = rows[:, :, :3]
    K = np.einsum("iak,ij,jbk->iajb", toward, C, toward).reshape(toward.shape[0] * toward.shape[1], -1)
    K += known.noise_std_nT**2 * np.eye(len(K))
    flat = rows.reshape(len(K), -1)
    dense = np.sqrt(np.diag(np.linalg.inv(flat.T @ np.linalg.solve(K, flat))))
    found = np.sqrt(np.diag(Bound.of(known, knowledge).covariance))
    np.testing.assert_allclose(found, dense, rtol=0.03 if colour.flicker_nT_sqrt_hz else 1e-6)


def test_the_simulated_noise_reaches_it() -> None:
    """Least squares weighted by the dense covariance, on what the simulator's own effects give."""
    known = replace(of_motion("full", SAMPLES), colour=BOTH)
    interval_s, n = float(known.step_s[0]), SAMPLES
    effects = (
        OffsetRandomWalk(std_nT_sqrt_s=(5.0, 5.0, 5.0)),
        FlickerNoise(density_nT_sqrt_hz=(20.0, 20.0, 20.0)),
        WhiteNoise(std_nT=(10.0, 10.0, 10.0)),
    )
    assert stated_colour(effects) == BOTH
    still = State(
        time_s=interval_s * np.arange(n),
        interval_s=interval_s,
        pos_enu_m=np.zeros((n, 3)),
        R_wb=np.tile(np.eye(3), (n, 1, 1)),
        rate_rad_s=np.zeros((n, 3)),
        field_enu_nT=np.zeros(3),
        field_nT=np.zeros((n, 3)),
        field_rate_nT_s=np.zeros((n, 3)),
        channels={},
    )
    x = np.column_stack([np.ones(n), known.field_nT / known.strength_nT])
    noise = np.concatenate([Chain(effects, seed).apply(still)[0] for seed in range(150)], axis=1)
    K = covariance(BOTH, interval_s) + known.noise_std_nT**2 * np.eye(n)
    weighted = np.linalg.solve(K, x)
    offsets = np.linalg.solve(x.T @ weighted, weighted.T @ noise)[0]
    bound = Bound.of(known, "vector").offset_std_nT[0]
    assert np.sqrt(np.mean(offsets**2)) == pytest.approx(bound, rel=0.12)


def test_without_colour_it_is_the_white_bound_and_more_noise_is_never_better() -> None:
    known = of_motion("pitch", 600)
    white = Bound.of(known, "norm").offset_std_nT
    np.testing.assert_allclose(
        Bound.of(replace(known, colour=Colour(0.0, 1e-9)), "norm").offset_std_nT, white, rtol=1e-6
    )
    assert (Bound.of(replace(known, colour=FLICKER), "norm").offset_std_nT > white).all()


def test_of_a_scenario_as_it_states_them_in_words_and_as_json() -> None:
    scenario = load("tumble")
    found = BoundQuery("vector", coloured=True).of_scenario(scenario)
    assert found.bound.offset_rms_nT > 3.0 * BoundQuery("vector").of_scenario(scenario).bound.offset_rms_nT
    assert "of flicker noise" in headline(found).splitlines()[0]
    assert summary(found)["flicker_nT_sqrt_hz"] > 0


def test_what_counts_white_noise_alone_says_so() -> None:
    known = replace(of_motion("full", 100), colour=FLICKER, field_enu_nT=np.array([0.0, 2e4, -4e4]))
    with pytest.raises(InputError, match="only white noise"):
        Bound.of(known, "norm+gyro")
    with pytest.raises(InputError, match="order of the samples"):
        limit(known, "norm", Tilts(5.0, 5.0))
