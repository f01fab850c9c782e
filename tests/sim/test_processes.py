"""First-order processes: statistics against theory, and nothing depends on how a run is cut into blocks."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.spec import ThermalSpec
from sim.processes import GaussMarkov
from sim.thermal import Thermometer


def process(std: float = 2.0, correlation_s: float = 5.0) -> GaussMarkov:
    return GaussMarkov(std, correlation_s, 0.1, 3, np.random.default_rng(1))


def test_gauss_markov_has_the_stated_deviation_and_correlation() -> None:
    x = process().draw(400_000)
    lag = 50  # one correlation time
    correlation = (x[:-lag] * x[lag:]).mean() / (x * x).mean()
    assert x.std() == pytest.approx(2.0, rel=0.03)
    assert correlation == pytest.approx(np.exp(-1.0), abs=0.03)


def test_gauss_markov_starts_stationary() -> None:
    first = [GaussMarkov(1.0, 100.0, 0.1, 1, np.random.default_rng(k)).draw(1)[0, 0] for k in range(2000)]
    assert np.std(first) == pytest.approx(1.0, rel=0.06)


def test_blocks_do_not_matter() -> None:
    whole, cut = process().draw(1000), process()
    parts = np.concatenate([cut.draw(n) for n in (1, 7, 492, 500)])
    np.testing.assert_allclose(parts, whole, rtol=0, atol=1e-12)


def test_temperature_rises_with_the_time_constant_and_settles_at_the_motors_heat() -> None:
    spec = ThermalSpec(surface_degC=10.0, deep_degC=10.0, heating_K_W=2.0, time_constant_s=50.0)
    thermometer = Thermometer(spec, 0.1, resistance_ohm=0.5)
    current = np.full((5000, 2), 3.0)  # 2 K/W x 0.5 ohm x 18 A^2 = 18 K
    t = 0.1 * np.arange(1, 5001)
    expected = 10.0 + 18.0 * (1.0 - np.exp(-t / 50.0))
    np.testing.assert_allclose(thermometer.temperature_degC(np.zeros(5000), current), expected, atol=1e-9)


def test_temperature_follows_the_depth() -> None:
    spec = ThermalSpec(surface_degC=20.0, deep_degC=2.0, scale_depth_m=500.0, time_constant_s=1.0)
    deep = Thermometer(spec, 0.1).temperature_degC(np.full(200, 500.0), np.zeros((200, 0)))
    assert deep[-1] == pytest.approx(2.0 + 18.0 * np.exp(-1.0))
