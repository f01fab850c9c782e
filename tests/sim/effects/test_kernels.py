"""First-order lags against the exact response of a parabola and of a sine."""

import numpy as np
import pytest

from sim.effects.kernels import curved_lag, first_order_lag

H_S = 0.2


@pytest.mark.parametrize("tau_s", [0.02, 0.2, 3.0])
def test_a_parabola_is_answered_exactly(tau_s: float) -> None:
    t = np.arange(200) * H_S
    exact = t**2 - 2 * tau_s * t + 2 * tau_s**2  # of tau dy/dt = t^2 - y, once the start has died away
    answer = curved_lag(t[:, None] ** 2, tau_s, H_S, {})[:, 0]
    np.testing.assert_allclose(answer[150:], exact[150:], rtol=0, atol=1e-3)


@pytest.mark.parametrize("tau_s", [0.01, 0.05, 0.3])
def test_a_sine_is_followed_five_times_closer_than_by_lines(tau_s: float) -> None:
    t = np.arange(3000) * H_S
    omega = 2 * np.pi / (25 * H_S)
    exact = np.imag(np.exp(1j * omega * t) / (1 + 1j * omega * tau_s))
    answers = (lag(np.sin(omega * t)[:, None], tau_s, H_S, {})[:, 0] for lag in (curved_lag, first_order_lag))
    curved, joined = (np.abs(answer - exact)[200:].max() for answer in answers)
    assert curved < joined / 5


def test_pieces_join_without_a_seam() -> None:
    x = np.random.default_rng(4).normal(size=(90, 2))
    memory: dict[str, object] = {}
    parts = [curved_lag(part, 0.07, H_S, memory) for part in np.split(x, [10, 11, 60])]
    np.testing.assert_allclose(np.concatenate(parts), curved_lag(x, 0.07, H_S, {}), atol=1e-12)
