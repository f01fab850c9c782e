"""The AUV's control laws, without compilation, against vector algebra."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim.vehicles.free_body_control import ARM, DRAG, MASS, _inverse_dynamics, _turn


@pytest.mark.parametrize("seed", range(3))
def test_the_wrench_moves_the_momenta(seed: int) -> None:
    """tau = M nu' + [w x p, w x L + v x p] + D |nu| nu, with (p, L) = M nu."""
    rng = np.random.default_rng(seed)
    M, D = (root @ root.T for root in rng.normal(size=(2, 6, 6)))
    nu, rate, wrench = rng.normal(size=6), rng.normal(size=6), np.zeros(6)
    gains = np.zeros(max(ARM + 3, MASS + 36, DRAG + 36))
    gains[MASS : MASS + 36], gains[DRAG : DRAG + 36] = M.ravel(), D.ravel()
    _inverse_dynamics.py_func(nu, rate, np.array([0.0, 0.0, 1.0]), gains, wrench)
    (p, L), (v, w) = np.split(M @ nu, 2), np.split(nu, 2)
    turned = np.concatenate([np.cross(w, p), np.cross(w, L) + np.cross(v, p)])
    np.testing.assert_allclose(wrench, M @ rate + turned + D @ (np.abs(nu) * nu), rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_at_rest_the_wrench_balances_the_moment_of_lift_and_weight(seed: int) -> None:
    """Forces along the vertical `up` at some places have the moment sum of r x f up; the wrench takes it away."""
    rng = np.random.default_rng(seed)
    up = Rotation.random(rng=rng).inv().apply([0.0, 0.0, 1.0])
    lift_N, places_m = rng.normal(size=4), rng.normal(size=(4, 3))
    gains, wrench = np.zeros(max(ARM + 3, MASS + 36, DRAG + 36)), np.zeros(6)
    gains[ARM : ARM + 3] = lift_N @ places_m
    _inverse_dynamics.py_func(np.zeros(6), np.zeros(6), up, gains, wrench)
    moment = np.cross(places_m, lift_N[:, None] * up).sum(axis=0)
    np.testing.assert_allclose(wrench, np.concatenate([np.zeros(3), -moment]), atol=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_the_wanted_turn_is_the_target_s_seen_from_the_body(seed: int) -> None:
    """w' = R_e w_d' - w x R_e w_d + k e + k_w (R_e w_d - w) + k_i int e, with R_e = R^T R_d."""
    rng = np.random.default_rng(seed)
    body = Rotation.random(rng=rng)
    error = Rotation.from_rotvec(rng.normal(scale=0.3, size=3))  # R_e
    w, w_d, turn_d, integral = rng.normal(size=(4, 3))
    g, scratch, rate = np.r_[np.zeros(3), 4.0, 3.0, 0.5], np.zeros(9), np.zeros(3)
    target = np.concatenate([(body * error).as_quat(scalar_first=True), w_d, turn_d])
    found = _turn.py_func(body.as_quat(scalar_first=True), w, target, integral, g, scratch, rate)
    _, *vector = error.as_quat(scalar_first=True, canonical=True)
    np.testing.assert_allclose(found, 2 * np.array(vector), atol=1e-14)
    ahead = error.apply(w_d)
    expected = error.apply(turn_d) - np.cross(w, ahead) + 4.0 * np.array(found) + 3.0 * (ahead - w) + 0.5 * integral
    np.testing.assert_allclose(rate, expected, rtol=1e-12, atol=1e-13)
