"""To and fro against a drag: the push and with it the tilt are what is asked for, and it comes back to rest."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from scenarios.paths import PHASES, Start
from scenarios.paths.swaying import Swaying

DRAG_1_M = 0.02


def sampled(sway: Swaying, times: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    t = np.arange(0.0, sway.lasts_s(times), 0.002)
    jet = sway.way(t, times)
    return t, jet.x, jet.dx, jet.ddx


@pytest.mark.parametrize(("push", "half_s", "times"), [(17.0, 1.5, 1), (9.81, 4.0, 2), (1.0, 1.5, 3)])
def test_the_push_is_constant_but_for_the_switches(push: float, half_s: float, times: int) -> None:
    t, x, dx, ddx = sampled(Swaying(push, DRAG_1_M, half_s, 0.6), times)
    felt = ddx + DRAG_1_M * np.abs(dx) * dx
    assert np.abs(felt).max() < push * (1 + 1e-6)
    switching = np.mean(np.abs(felt) < 0.999 * push)
    assert switching < 1.1 * (2 * times + 2) * 0.6 / t[-1]
    assert abs(np.mean(felt)) < 0.01 * push
    assert abs(x[-1]) < 0.01
    assert abs(dx[-1]) < 0.05


def test_it_is_the_motion_that_this_push_makes() -> None:
    """The push itself, as it is told, integrated by another method from rest."""
    t, x, dx, ddx = sampled(Swaying(9.81, DRAG_1_M, 2.5, 0.6), 2)
    felt = ddx + DRAG_1_M * np.abs(dx) * dx
    free = solve_ivp(
        lambda at, s: (s[1], np.interp(at, t, felt) - DRAG_1_M * abs(s[1]) * s[1]),
        (0.0, t[-1]),
        (0.0, 0.0),
        t_eval=t,
        max_step=0.02,
        rtol=1e-8,
    )
    np.testing.assert_allclose(free.y[0], x, atol=0.02)
    np.testing.assert_allclose(free.y[1], dx, atol=0.01)


def test_long_pushes_end_at_terminal_speed() -> None:
    speed = sampled(Swaying(9.81, DRAG_1_M, 10.0, 0.6), 1)[2]
    assert np.abs(speed).max() == pytest.approx(np.sqrt(9.81 / DRAG_1_M), rel=0.01)


def test_hardly_any_drag_is_none() -> None:
    said = {"kind": "pushes", "pushes": [{"yaw_deg": 100, "pitch_deg": 20, "roll_deg": -15, "times": 2}]}
    none, hardly = (PHASES["pushes"].model_validate(said | {"drag_1_m": drag}) for drag in (0.0, 1e-7))
    t = np.linspace(0.0, none.duration_s, 500)
    one, other = (phase.reference(Start((0, 0, 0), 0.0), t) for phase in (none, hardly))
    assert hardly.duration_s == pytest.approx(none.duration_s, abs=1e-3)
    np.testing.assert_allclose(other[:, :9], one[:, :9], atol=5e-3)
