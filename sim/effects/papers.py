"""The measurement models of the five papers as chains of effects, in the order of each paper."""

from __future__ import annotations

import math

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import ZERO3, Effect
from sim.effects.currents import EddyCurrent
from sim.effects.geometry import Misalignment, NonOrthogonality, Scale
from sim.effects.iron import HardIron, SoftIron
from sim.effects.noise import WhiteNoise
from sim.effects.offsets import SensorOffset
from sim.effects.parameters import Mat3, Vec3
from sim.effects.rotation import axes_and_turn, rotation_about, rotation_angles_deg, triangular_angles_deg
from sim.portable_arithmetic import product

Chained = tuple[Effect, ...]


def zhang2018(
    installation_deg: Vec3 = ZERO3,
    alpha_deg: float = 0.0,
    beta_deg: float = 0.0,
    gamma_deg: float = 0.0,
    scale: Vec3 = (1.0, 1.0, 1.0),
    hard_iron_nT: Vec3 = ZERO3,
    noise_std_nT: float = 0.0,
) -> Chained:
    """``H_m = A_soft (H_e + h) + h + w,  A_soft = C_M C_NO C_SF`` ([Zhang2018] eq. 1 to 7).

    The hard iron h acts twice: as hard iron of the vehicle before the matrix, as sensor offset behind the matrix.
    """
    return (
        HardIron(hard_iron_nT),
        _scale(scale),
        NonOrthogonality((gamma_deg, alpha_deg, beta_deg)),
        Misalignment(installation_deg, form="zhang2018"),
        SensorOffset(hard_iron_nT),
        *_noise(noise_std_nT),
    )


def li2017(permanent_nT: Vec3, induced: Mat3, eddy_s: Mat3, noise_std_nT: float = 0.0) -> Chained:
    """``T_m = T + T_p + A T + B dT/dt`` ([Li2017] eq. 1), dT/dt in nT/s and B in seconds."""
    return SoftIron(induced), HardIron(permanent_nT), EddyCurrent(eddy_s), *_noise(noise_std_nT)


def long2013(
    soft_iron: Mat3,
    hard_iron_nT: Vec3,
    alpha_deg: float,
    beta_deg: float,
    gamma_deg: float,
    scale: Vec3,
    offset_nT: Vec3,
    noise_std_nT: float = 0.0,
) -> Chained:
    """``H_m = C_k C_n (C_s H + b_h) + b_o`` ([Long2013] eq. 1 to 3).

    ``C_n = [[sqrt(1 - cos^2 beta - cos^2 gamma), cos beta, cos gamma], [0, cos alpha, sin alpha], [0, 0, 1]]``: beta
    and gamma are angles between axes, 90 degrees when square; alpha is a lean, 0 when square.
    """
    lean = math.asin(math.cos(math.radians(gamma_deg)) / math.sin(math.radians(beta_deg)))
    return (
        SoftIron(_mat3(np.array(soft_iron) - np.eye(3))),
        HardIron(hard_iron_nT),
        NonOrthogonality((90.0 - beta_deg, math.degrees(lean), alpha_deg)),
        _scale(scale),
        SensorOffset(offset_nT),
        *_noise(noise_std_nT),
    )


def zhou2012(axes: Array) -> Chained:
    """``B = A B_t``, the rows of A (3, 3) the sensor's unit axes in the level frame ([Zhou2012]).

    A = N Q: the turn Q of a square sensor, then the axes' leaning N (RQ decomposition).
    """
    N, Q = axes_and_turn(axes)
    return Misalignment(rotation_angles_deg(Q)), NonOrthogonality(triangular_angles_deg(N))


def ding2021(
    offset_nT: Vec3 = ZERO3,
    scale: Vec3 = (1.0, 1.0, 1.0),
    psi_deg: float = 0.0,
    phi_deg: float = 0.0,
    theta_deg: float = 0.0,
    euler_deg: Vec3 = ZERO3,
    noise_std_nT: float = 0.0,
) -> Chained:
    """A sensor of the array: ``B_c = K C B + b,  B_r = T_gamma T_alpha T_beta B`` ([Ding2021] eq. 3, 5, 6).

    B_r is the field in the array's frame: ``B_c = K C Q B_r + b``, Q = (T_gamma T_alpha T_beta)^-1. The T turn the
    frame (components change by the inverse turn) by `euler_deg` = (alpha about x, beta about y, gamma about z),
    y first. For C see `ding2021_axes`.
    """
    N = ding2021_axes(psi_deg, phi_deg, theta_deg)
    return (
        Misalignment(rotation_angles_deg(ding2021_turn(euler_deg).T)),
        NonOrthogonality(triangular_angles_deg(N)),
        _scale(scale),
        SensorOffset(offset_nT),
        *_noise(noise_std_nT),
    )


def ding2021_axes(psi_deg: float, phi_deg: float, theta_deg: float) -> Array:
    """C (3, 3) from the text to figure 2 of [Ding2021], rows the axes of the sensor in the ideal frame.

    z is shared; y leans by psi toward z in the plane of ideal y and z; x rises by phi from the plane of ideal x
    and y, with a projection turned by theta toward y.
    """
    psi, phi, theta = (math.radians(angle) for angle in (psi_deg, phi_deg, theta_deg))
    x = (math.cos(phi) * math.cos(theta), math.cos(phi) * math.sin(theta), math.sin(phi))
    return np.array([x, (0.0, math.cos(psi), math.sin(psi)), (0.0, 0.0, 1.0)])


def ding2021_turn(euler_deg: Vec3) -> Array:
    """T_gamma T_alpha T_beta (3, 3), from a sensor's frame to the array's ([Ding2021] eq. 5)."""
    alpha, beta, gamma = euler_deg
    return product(product(rotation_about(2, -gamma), rotation_about(0, -alpha)), rotation_about(1, -beta))


def _scale(factors: Vec3) -> Scale:
    x, y, z = factors
    return Scale((x - 1.0, y - 1.0, z - 1.0))


def _noise(std_nT: float) -> Chained:
    return (WhiteNoise((std_nT, std_nT, std_nT)),) if std_nT > 0 else ()


def _mat3(matrix: Array) -> Mat3:
    a, b, c = ((float(x), float(y), float(z)) for x, y, z in matrix)
    return (a, b, c)
