"""Trials of [Long2013]'s simulation: motion, errors, calibration, and attitude from a magnetometer with known yaw."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference
from calib.methods.ml_newton import MaximumLikelihoodNewton
from calib.methods.twostep import TwoStep
from calib.models.quadric import design, shape_matrix
from papers.attitudes import state_at_attitudes
from recordings import Recording
from scenarios.arrays import Array
from sim.chain import Chain
from sim.effects.base import Effect
from sim.effects.papers import long2013
from sim.effects.parameters import Mat3, Vec3
from sim.state import State

SEED = 2013
STRENGTH_NT, DECLINATION_DEG, INCLINATION_DEG = 48_152.0, -4.57, 44.57
SOFT_IRON: Mat3 = ((1.23, 0.23, 0.32), (0.23, 1.45, 0.45), (0.32, 0.45, 1.56))
SCALE: Vec3 = (1.0, 0.9, 1.2)
AXES_DEG = (1.2, 87.6, 87.0)
HARD_IRON_NT: Vec3 = (700.0, 750.0, 800.0)
OFFSET_NT: Vec3 = (900.0, 850.0, 750.0)
TEST_YAW_DEG, TEST_PITCH_DEG = 90.0, -33.1
FLIP = np.diag([1.0, -1.0, -1.0])
"""Forward-right-down to forward-left-up."""
NED_TO_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def field_ned_nT() -> Array:
    """Return the field (3,), north, east, down."""
    declination, inclination = np.radians([DECLINATION_DEG, INCLINATION_DEG])
    level = np.cos(inclination)
    return STRENGTH_NT * np.array([level * np.cos(declination), level * np.sin(declination), np.sin(inclination)])


def effects(share: float = 1.0, noise_std_nT: float = 0.0) -> tuple[Effect, ...]:
    """Return the printed errors (eq. 1 to 5), nT for the printed nG, scaled by `share` towards a perfect sensor."""
    soft = np.eye(3) + share * (np.array(SOFT_IRON) - np.eye(3))
    a, b, c = ((float(x), float(y), float(z)) for x, y, z in soft)
    alpha, beta, gamma = AXES_DEG
    return long2013(
        (a, b, c),
        _scaled(HARD_IRON_NT, share),
        share * alpha,
        90 - share * (90 - beta),
        90 - share * (90 - gamma),
        _scaled(SCALE, share, 1.0),
        _scaled(OFFSET_NT, share),
        noise_std_nT,
    )


def _scaled(values: Vec3, share: float, ideal: float = 0.0) -> Vec3:
    x, y, z = (ideal + share * (value - ideal) for value in values)
    return x, y, z


def calibration_turns() -> Array:
    """Return yaw, pitch, roll (1440, 3), degrees: a turn about each body axis from level north, then all three."""
    turn = np.arange(360.0)
    none = np.zeros(360)
    return np.concatenate(
        [
            np.column_stack(angles)
            for angles in ((none, none, turn), (none, turn, none), (turn, none, none), (turn, turn, turn))
        ]
    )


def rolling() -> Array:
    """Return yaw, pitch, roll (360, 3), degrees, of the turntable test: yaw 90, pitch -33.1, roll a whole turn."""
    turn = np.arange(360.0)
    return np.column_stack((np.full(360, TEST_YAW_DEG), np.full(360, TEST_PITCH_DEG), turn))


def state_of(angles_deg: Array, axes: Array = FLIP) -> State:
    """Return the kinematic motion as a State, a sample per second: the paper's sensor has no dynamics.

    axes : (3, 3), forward-right-down to the body's axes; the identity leaves the errors in the paper's axes.
    """
    turned = Rotation.from_euler("ZYX", angles_deg, degrees=True).as_matrix()
    return state_at_attitudes(NED_TO_ENU @ turned @ axes, NED_TO_ENU @ field_ned_nT())


def measured(state: State, chain: tuple[Effect, ...], run: int) -> Recording:
    """Return the sensor's recording along a motion, with the turntable's attitude."""
    att_q = Rotation.from_matrix(state.R_wb).as_quat(scalar_first=True)
    return Recording(state.time_s, Chain(chain, SEED, run).apply(state)[0], att_q=att_q)


def roll_pitch_deg(field_nT: Array, yaw_deg: float, near_pitch_deg: float) -> tuple[Array, Array]:
    """Return roll and pitch (n,), degrees, from fields (n, 3) in the body frame (FLU), known yaw and known Earth field.

    h = Rx(roll)^T Ry(pitch)^T g,  g = Rz(yaw)^T F  (forward-right-down; directions only):
    h_x = |(g_x, g_z)| cos(pitch + atan2(g_z, g_x)),  roll = arg(g_y, g_x sin pitch + g_z cos pitch) - arg(h_y, h_z)

    Of two pitches, the nearer to `near_pitch_deg` is returned; a component beyond the range of any pitch is clipped.
    """
    h = (field_nT / np.linalg.norm(field_nT, axis=1)[:, None]) @ FLIP
    g = Rotation.from_euler("Z", yaw_deg, degrees=True).inv().apply(field_ned_nT() / STRENGTH_NT)
    half = np.arccos(np.clip(h[:, 0] / np.hypot(g[0], g[2]), -1.0, 1.0))
    both = np.stack((half, -half)) - np.arctan2(g[2], g[0])
    off = np.angle(np.exp(1j * (both - np.radians(near_pitch_deg))))
    pitch = np.take_along_axis(off, np.abs(off).argmin(axis=0)[None], axis=0)[0] + np.radians(near_pitch_deg)
    across = g[0] * np.sin(pitch) + g[2] * np.cos(pitch)
    roll = np.arctan2(across, g[1]) - np.arctan2(h[:, 2], h[:, 1])
    return np.degrees(roll), np.degrees(pitch)


def attitude_errors_deg(field_nT: Array) -> Array:
    """Return roll and pitch errors (360, 2), degrees, of fields along `rolling`."""
    roll, pitch = roll_pitch_deg(field_nT, TEST_YAW_DEG, TEST_PITCH_DEG)
    roll_error = np.degrees(np.angle(np.exp(1j * np.radians(roll - rolling()[:, 2]))))
    return np.column_stack((roll_error, pitch - TEST_PITCH_DEG))


@dataclass(frozen=True)
class LongTask:
    """Seed, noise of a component, and share of the printed errors."""

    seed: int
    noise_std_nT: float
    share: float = 1.0


@dataclass(frozen=True)
class LongTrial:
    """Results of a seed.

    before_nT, after_nT: strengths (1440,); raw_deg, corrected_deg, unaligned_deg: roll and pitch errors (360, 2)
    before, after, and after without eq. 12; ..._error_nT: errors of the hard iron by Newton's method, by the bench's
    two-step and by an algebraic two-step; down_nT: by Newton and by the bench's two-step with the errors in the paper's
    axes, forward, right, down.
    """

    status: str
    iterations: int
    before_nT: Array
    after_nT: Array
    raw_deg: Array
    corrected_deg: Array
    unaligned_deg: Array
    offset_error_nT: float
    twostep_error_nT: float
    algebraic_error_nT: float
    down_nT: tuple[float, float]
    roll_alone: str

    @property
    def worst_share(self) -> float:
        """Return the largest deviation of the corrected field's strength, as a fraction of the field."""
        return float(np.abs(self.after_nT / STRENGTH_NT - 1).max())


def calibration_trial(task: LongTask) -> LongTrial:
    """Calibrate on the turns, then roll on the turntable with fresh noise."""
    chain = effects(task.share, task.noise_std_nT)
    turns = measured(state_of(calibration_turns()), chain, 2 * task.seed)
    test = measured(state_of(rolling()), chain, 2 * task.seed + 1)
    reference = Reference.of_vector(tuple((NED_TO_ENU @ field_ned_nT()).tolist()))
    fit = MaximumLikelihoodNewton().fit(turns, reference)
    bare = MaximumLikelihoodNewton(align=False).fit(turns, reference)
    truth_nT = offset_nT(task.share)
    return LongTrial(
        fit.status.kind,
        len(fit.history),
        np.linalg.norm(turns.mag_nT, axis=1),
        _strength(fit, turns),
        attitude_errors_deg(test.mag_nT),
        attitude_errors_deg(fit.apply(test)),
        attitude_errors_deg(bare.apply(test)),
        float(np.linalg.norm(fit.offset_nT - truth_nT)),
        float(np.linalg.norm(TwoStep().fit(turns, reference).offset_nT - truth_nT)),
        float(np.linalg.norm(algebraic_offset_nT(turns.mag_nT) - truth_nT)),
        _down(task, chain, reference),
        MaximumLikelihoodNewton().fit(test, reference).status.kind,
    )


def algebraic_offset_nT(mag_nT: Array) -> Array:
    """Return the centre (3,) by the plain two-step: a linear least-squares quadric, then its centre, unweighted.

    m^T A m + 2 p^T m = 1,  b = -A^-1 p  (the start that the paper cites, without weights and iterations)
    """
    x = mag_nT / STRENGTH_NT
    theta = np.asarray(np.linalg.lstsq(design(x), np.ones(len(x)), rcond=None)[0], dtype=np.float64)
    return np.asarray(-STRENGTH_NT * np.linalg.solve(shape_matrix(theta), theta[6:]))


def _down(task: LongTask, chain: tuple[Effect, ...], reference: Reference) -> tuple[float, float]:
    """Return hard-iron errors by Newton and by the bench's two-step, with the errors in forward-right-down axes."""
    turns = measured(state_of(calibration_turns(), np.eye(3)), chain, 2 * task.seed)
    fits = (method.fit(turns, reference) for method in (MaximumLikelihoodNewton(align=False), TwoStep()))
    newton, weighted = (float(np.linalg.norm(fit.offset_nT - offset_nT(task.share))) for fit in fits)
    return newton, weighted


def offset_nT(share: float = 1.0) -> Array:
    """Return b = C_k C_n b_h + b_o (3,): output of the chain without field."""
    state = state_of(rolling()[:1])
    still = replace(state, field_nT=np.zeros((1, 3)), field_enu_nT=np.zeros(3))
    return np.asarray(Chain(effects(share), SEED).apply(still)[0][0])


def _strength(fit: Calibration, recording: Recording) -> Array:
    return np.asarray(np.linalg.norm(fit.apply(recording), axis=1))
