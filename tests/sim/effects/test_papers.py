"""The papers' equations, evaluated directly, against the chain of effects that stands for them."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.errors import InputError
from sim.chain import Chain
from sim.effects import as_tables, build
from sim.effects.geometry import Misalignment, NonOrthogonality, Scale
from sim.effects.papers import ding2021, li2017, long2013, zhang2018, zhou2012
from sim.effects.rotation import triangular, zhang_installation

DEG = np.pi / 180


def measured(effects, state):
    return Chain(effects, seed=0).apply(state)[0]


def close(actual, expected):
    np.testing.assert_allclose(actual, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


PRINTED_M = np.array([[1, -0.0052, -0.0244], [-0.0052, 1, -0.0209], [-0.0244, -0.0209, 1]])
PRINTED_NO = np.array([[0.9998, 0.0052, 0.0209], [0, 0.9997, 0.0244], [0, 0, 1]])
PRINTED_A = np.array([[1.1198, 0.0002, -0.0035], [-0.0058, 1.0097, 0.0033], [-0.0273, -0.0212, 0.9590]])
MISPRINT = (0, 1)


def test_zhangs_printed_matrices():
    """[Zhang2018] eq. 2 and 3, to the rounding of the example."""
    np.testing.assert_allclose(zhang_installation((1.2, -1.4, 0.3)), PRINTED_M, atol=0.6e-4)
    np.testing.assert_allclose(triangular((0.3, 1.2, 1.4)), PRINTED_NO, atol=0.6e-4)


def test_zhangs_printed_product():
    """[Zhang2018] eq. 7: the order C_M C_NO C_SF gives the printed A_soft to its rounding.

    Its element xy is the exception: 0.0002 is printed, the printed factors give 0.000002.
    """
    C_SF = Scale((0.12, 0.01, -0.04)).matrix()
    gap = np.abs(PRINTED_M @ PRINTED_NO @ C_SF - PRINTED_A)
    assert gap[MISPRINT] == pytest.approx(0.000198, abs=1e-6)
    gap[MISPRINT] = 0
    assert gap.max() < 0.5e-4


def test_zhang2018(states):
    state, h = states(300), np.array([1200.0, -800, 2000])
    effects = zhang2018((1.2, -1.4, 0.3), 1.2, 1.4, 0.3, (1.12, 1.01, 0.96), tuple(h))
    A = zhang_installation((1.2, -1.4, 0.3)) @ triangular((0.3, 1.2, 1.4)) @ np.diag([1.12, 1.01, 0.96])
    close(measured(effects, state), (state.field_nT + h) @ A.T + h)


def test_zhang2018_noise_is_the_last_in_the_chain(states):
    effects = zhang2018(noise_std_nT=7.0)
    label = Chain(effects, seed=1).apply(states(20_000))[1]["white_noise"]
    assert label.std() == pytest.approx(7.0, rel=0.02)


def test_li2017_with_its_table(states):
    state, T_p = states(300), np.array([40.0, -100, 120])
    A = np.array([[0.065, 0.1, 0.26], [0.02, 0.5, 0.28], [0.2, 0.26, 0.16]])
    B = np.array([[0.1, 0.32, 0.22], [0.13, 0.16, 0.61], [0.16, 0.17, 0.02]])
    close(measured(li2017(T_p, A, B), state), state.field_nT + T_p + state.field_nT @ A.T + state.field_rate_nT_s @ B.T)


def test_long2013_with_its_simulation(states):
    state = states(300)
    C_s = np.array([[1.23, 0.23, 0.32], [0.23, 1.45, 0.45], [0.32, 0.45, 1.56]])
    b_h, b_o, C_k = np.array([700.0, 750, 800]), np.array([900.0, 850, 750]), np.diag([1, 0.9, 1.2])
    a, b, g = 1.2 * DEG, 87.6 * DEG, 87.0 * DEG
    first = [np.sqrt(1 - np.cos(b) ** 2 - np.cos(g) ** 2), np.cos(b), np.cos(g)]
    C_n = np.array([first, [0, np.cos(a), np.sin(a)], [0, 0, 1]])
    expected = (state.field_nT @ C_s.T + b_h) @ (C_k @ C_n).T + b_o
    close(measured(long2013(C_s, b_h, 1.2, 87.6, 87.0, (1, 0.9, 1.2), b_o), state), expected)


def test_zhou2012_with_its_result(states):
    state = states(300)
    a1, b1, b2, c1, c2 = 0.013572, 0.000115, -0.006312, -0.021201, -0.003657
    rows = [(np.sqrt(1 - a1**2), 0, a1), (b1, np.sqrt(1 - b1**2 - b2**2), b2), (c1, c2, np.sqrt(1 - c1**2 - c2**2))]
    effects = zhou2012(np.array(rows))
    assert [type(effect) for effect in effects] == [Misalignment, NonOrthogonality]
    close(measured(effects, state), state.field_nT @ np.array(rows).T)


def test_ding2021_is_undone_by_its_correction(states):
    """[Ding2021] eq. 6: B_r = T_gamma T_alpha T_beta (K C)^-1 (B_c - b)."""
    state, b, K = states(300), np.array([150.0, -80, 20]), np.diag([0.93, 1.08, 1.02])
    psi, phi, theta, alpha, beta, gamma = np.array([1.5, -0.8, 1.9, 1.1, -1.7, 0.6]) * DEG
    x_axis = [np.cos(phi) * np.cos(theta), np.cos(phi) * np.sin(theta), np.sin(phi)]
    C = np.array([x_axis, [0, np.cos(psi), np.sin(psi)], [0, 0, 1]])
    s, c = np.sin, np.cos
    T_alpha = np.array([[1, 0, 0], [0, c(alpha), s(alpha)], [0, -s(alpha), c(alpha)]])
    T_beta = np.array([[c(beta), 0, -s(beta)], [0, 1, 0], [s(beta), 0, c(beta)]])
    T_gamma = np.array([[c(gamma), s(gamma), 0], [-s(gamma), c(gamma), 0], [0, 0, 1]])
    B_c = measured(ding2021(b, (0.93, 1.08, 1.02), 1.5, -0.8, 1.9, (1.1, -1.7, 0.6)), state)
    close((B_c - b) @ (T_gamma @ T_alpha @ T_beta @ np.linalg.inv(K @ C)).T, state.field_nT)


def test_a_papers_chain_survives_the_way_through_a_scenario(states):
    effects = zhang2018((1.2, -1.4, 0.3), 1.2, 1.4, 0.3, (1.12, 1.01, 0.96), (1200, -800, 2000), 5.0)
    tables, order = as_tables(effects)
    assert build(tables, order, "zhang.toml") == effects
    with pytest.raises(InputError, match="does not name"):
        build(tables, order[1:], "zhang.toml")
