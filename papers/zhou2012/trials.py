"""Trials of [Zhou2012]'s turntable run: twelve stops, the paper's search, Cramer-Rao bound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib import Reference
from calib.methods.de_turntable import DeTurntable
from calib.models.turntable import NAMES, axes_matrix, derivatives
from papers.attitudes import state_at_attitudes
from papers.zhou2012.separate import corrections
from recordings import Recording
from scenarios.arrays import Array
from scenarios.seeds import stream
from sim.chain import Chain
from sim.effects.base import Effect
from sim.effects.noise import WhiteNoise
from sim.effects.offsets import SensorOffset
from sim.effects.papers import zhou2012
from sim.field import earth_field_enu_nT
from sim.scenario import load
from sim.state import State

PRINTED = (0.013572, 0.000115, -0.006312, -0.021201, -0.003657)
STOPS, STEP_RAD = 12, -np.radians(30.0)
NOISE_NT = 1.0
OFFSET_NT = 10.0
STABLE_AT = 100
SEED = 2012
JOINT = "jointly"


@dataclass(frozen=True)
class ZhouTrial:
    """Results of a seed: five estimates (5,), rms of the objective by iteration (nT), z before and after (12,), nT.

    error_nT: rms length of the field's error over the stops, by the way of correction.
    """

    found: Array
    claimed: Array
    history: Array
    z_nT: Array
    flat_nT: Array
    weakest: dict[str, float]
    status: str
    error_nT: dict[str, float]


@dataclass(frozen=True)
class ZhouTask:
    """Seed, and sensor offset in x outside the model."""

    seed: int
    offset_nT: float = 0.0


def stops() -> State:
    """Return twelve stops of 30 degrees clockwise of an ideal level sensor in the field of the catalogue's scenario."""
    field = earth_field_enu_nT(load("turntable-twelve-stops").field)
    yaw = STEP_RAD * np.arange(STOPS)
    R_wb = np.zeros((STOPS, 3, 3))
    R_wb[:, 0, 0] = R_wb[:, 1, 1] = np.cos(yaw)
    R_wb[:, 1, 0], R_wb[:, 0, 1] = np.sin(yaw), -np.sin(yaw)
    R_wb[:, 2, 2] = 1.0
    return state_at_attitudes(R_wb, field)


def recording(state: State, seed: int, offset_nT: float = 0.0) -> Recording:
    """Return the recording of a sensor with the printed values at the stops, with white noise and an offset in x."""
    added: tuple[Effect, ...] = (SensorOffset((offset_nT, 0.0, 0.0)), WhiteNoise((NOISE_NT, NOISE_NT, NOISE_NT)))
    effects = (*zhou2012(axes_matrix(np.array(PRINTED))), *added)
    return Recording(state.time_s, Chain(effects, SEED, seed).apply(state)[0])


def search_trial(task: ZhouTask) -> ZhouTrial:
    """Simulate twelve stops with fresh noise and run the paper's search."""
    state = stops()
    measured = recording(state, task.seed, task.offset_nT)
    fit = DeTurntable().fit(measured, reference(state), stream(SEED, task.seed, "search"))
    found = np.array([fit.parameters[name] for name in NAMES])
    assert fit.covariance is not None
    return ZhouTrial(
        found,
        np.sqrt(np.diag(fit.covariance)),
        np.array(fit.history),
        measured.mag_nT[:, 2],
        fit.apply(measured)[:, 2],
        {k: fit.parameters[k] for k in ("condition_number", "weakest_std")},
        fit.status.kind,
        {
            name: float(np.sqrt(np.mean(np.sum((field - state.field_nT) ** 2, axis=1))))
            for name, field in (corrections(measured.mag_nT) | {JOINT: fit.apply(measured)}).items()
        },
    )


def reference(state: State) -> Reference:
    """Return the known field strength."""
    return Reference(float(np.linalg.norm(state.field_enu_nT)))


def bound(state: State) -> Array:
    """Return the Cramer-Rao bound (5,) on the standard deviation, azimuths, H and V unknown.

    m_i = A (H cos p_i, H sin p_i, V): 36 measurements; unknowns: five of A, H, V and twelve p_i.
    """
    A, h = axes_matrix(np.array(PRINTED)), state.field_nT
    level = h * [1.0, 1.0, 0.0]
    columns = [(h @ step.T).ravel() for step in derivatives(np.array(PRINTED))]
    columns += [(level @ A.T).ravel(), np.tile(A[:, 2], STOPS)]  # H and the azimuths in any unit
    turned = np.cross([0.0, 0.0, 1.0], h) @ A.T
    for i in range(STOPS):
        columns.append((turned * (np.arange(STOPS) == i)[:, None]).ravel())
    J = np.array(columns).T / NOISE_NT
    scale = np.linalg.norm(J, axis=0)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv((J / scale).T @ (J / scale)))) / scale)[:5]
