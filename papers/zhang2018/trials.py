"""Trials of [Zhang2018], a seed each: spiral flown once, then fresh noise and fresh random searches."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from calib import Calibration, Calibrator, Reference
from calib.families.norm_search import NormSpace, PopulationCalibrator, triangular
from calib.methods.ellipsoid import EllipsoidCalibrator
from calib.methods.ellipsoid_segmented import EllipsoidSegmented
from calib.methods.ga import Ga
from calib.methods.pso import Pso
from calib.methods.psoga import PsoGa
from calib.models.quadric import design, shape_matrix
from recordings import Recording
from scenarios.arrays import Array
from scenarios.seeds import stream
from sim.chain import Chain
from sim.effects.base import Effect
from sim.effects.iron import HardIron, HardIronDrift
from sim.effects.noise import WhiteNoise
from sim.effects.offsets import SensorOffset
from sim.rotation import matrix_from_q
from sim.scenario import load
from sim.simulation import blocks, channels_of, plan
from sim.state import State
from validation.signals.amplitude import rms

METHODS = ("pso", "ga", "psoga")
POSITIONS = 30
"""One each 10 s, as printed: 300 degrees of the turn."""
SEED = 2018
LONG = 5000
DRIFT_NT_H = 17.5
"""The catalogue's drift of the hard iron: the length of (12, -8, 10) nT/h."""
DRIFTS = (0.0, 1.0, 10.0, 50.0)
"""Multiples of it."""
TURN_S = 360.0
FITS: dict[str, Calibrator] = {
    "whole": EllipsoidCalibrator(),
    "segmented": EllipsoidSegmented(),
    "by turns": EllipsoidSegmented(cuts_s=(TURN_S, 2 * TURN_S, 3 * TURN_S, 4 * TURN_S)),
}
"""The ellipsoid of the whole record, with the program's cuts, and cut at each whole turn of the half hour."""


@dataclass(frozen=True)
class Setting:
    """Settings without printed value.

    reach_nT: half width of the hard iron's bounds, 0: bounds from the data (`bounded`); c: c1 = c2 of the swarm;
    drift: multiple of the catalogue's drift.
    """

    label: str
    reach_nT: float
    c: float = 2.0
    mutation: float = 0.02
    iterations: int = 200
    drift: float = 1.0

    def method(self, name: str) -> PopulationCalibrator:
        """Return the method without polish, as in the paper."""
        if name == "pso":
            return Pso(iterations=self.iterations, c1=self.c, c2=self.c, polish=False)
        if name == "ga":
            return Ga(iterations=self.iterations, mutation=self.mutation, polish=False)
        return PsoGa(iterations=self.iterations, c1=self.c, c2=self.c, mutation=self.mutation, polish=False)


SETTINGS = (
    Setting("bounds 10 % and 1000 nT", 1000.0),
    Setting("same, c1 = c2 = 1.494", 1000.0, c=1.494),
    Setting("same, mutation a tenth", 1000.0, mutation=0.002),
    Setting("same, 50 iterations", 1000.0, iterations=50),
    Setting(f"same, {LONG} iterations", 1000.0, iterations=LONG),
    Setting("bounds from the data", 0.0),
    Setting("bounds 10 % and 1000 nT, drift ten times", 1000.0, drift=10.0),
)
MAIN, LEARNING, SHORT, LONGER = (SETTINGS[k].label for k in (0, 1, 3, 4))
PRINTED_SOFT = np.array([[1.1198, 0.0002, -0.0035], [-0.0058, 1.0097, 0.0033], [-0.0273, -0.0212, 0.9590]])
"""The example of eq. 7."""
NOISE_NT = 2.0
"""White noise of each axis in the trials of eq. 15."""


@dataclass(frozen=True)
class ZhangTrial:
    """Results of a seed on the level spiral.

    raw_nT (30,): |m| - F at the positions; by setting and method: errors_nT |h| - F at the positions (30,), rms_nT of
    the best after each iteration, offset_nT distance from the true offset.
    """

    raw_nT: Array
    errors_nT: dict[tuple[str, str], Array]
    rms_nT: dict[tuple[str, str], Array]
    offset_nT: dict[tuple[str, str], float]


def rms_nT(trials: list[ZhangTrial], setting: str, name: str) -> Array:
    """Return the rms of |h| - F of the best after each iteration: (seeds, iterations) nT."""
    return np.array([t.rms_nT[setting, name] for t in trials])


@dataclass(frozen=True)
class DriftTrial:
    """Results of a seed on the excited spiral, by fit, a value per drift.

    rms_nT: rms of |h| - F over the record; offset_nT: rms distance from the moving true offset; segments: their number.
    """

    rms_nT: dict[str, tuple[float, ...]]
    offset_nT: dict[str, tuple[float, ...]]
    segments: dict[str, tuple[int, ...]]


@lru_cache(maxsize=2)
def spiral(excited: bool) -> State:
    """Return the motion: an hour of level circles at 1 degree/s at 3000 m, a sample per 10 s; excited: per 2 s."""
    scenario = load("auv-dive", ["vehicle.depth_m=3000", "sampling.rate_hz=0.1"])
    scenario = scenario.model_copy(update={"phases": scenario.phases[1:2]})
    ready = plan(load("auv-spiral-excited", ["sampling.rate_hz=0.5"]) if excited else scenario)
    columns = list(blocks(ready))

    def take(*names: str) -> Array:
        return np.concatenate([np.column_stack([block[name] for name in names]) for block in columns])

    field, time_s = take("true_field_x_nT", "true_field_y_nT", "true_field_z_nT"), take("time_s")[:, 0]
    R_wb = matrix_from_q(take("true_qw", "true_qx", "true_qy", "true_qz"))
    position = take("true_pos_east_m", "true_pos_north_m", "true_pos_up_m")
    still = np.zeros_like(field)  # none of these effects depends on the rates
    return State(
        time_s,
        float(time_s[1] - time_s[0]),
        position,
        R_wb,
        still,
        ready.field_enu_nT,
        field,
        still,
        {name: take(name)[:, 0] for name in channels_of(scenario.vehicle.kind)},
    )


def effects(drift: float = 1.0) -> tuple[Effect, ...]:
    """Return the errors of the scenario `auv-dive`, with multiplied drift."""
    return tuple(_drifting(effect, drift) for effect in plan(load("auv-dive")).effects[0])


def _drifting(effect: Effect, drift: float) -> Effect:
    if not isinstance(effect, HardIronDrift):
        return effect
    x, y, z = effect.rate_nT_h
    return replace(effect, rate_nT_h=(drift * x, drift * y, drift * z))


def strength_nT(state: State) -> float:
    """Return F, the field strength."""
    return float(np.linalg.norm(state.field_enu_nT))


def bounded(mag_nT: Array, strength: float, reach_nT: float, width: float = 0.1) -> NormSpace:
    """Return the search problem of eq. 22; with a reach, R within `width` of identity, offsets within reach_nT of 0."""
    problem = NormSpace.of(mag_nT, strength, Pso.most_gain)
    assert problem is not None
    if not reach_nT:
        return problem
    middle, reach = -problem.middle_nT / strength, reach_nT / strength
    matrix = np.eye(3)[np.triu_indices(3)]
    return replace(
        problem,
        lower=np.concatenate((matrix - width, middle - reach)),
        upper=np.concatenate((matrix + width, middle + reach)),
    )


def true_offset_nT(chain: tuple[Effect, ...]) -> Array:
    """Return the sensor's output without field at the start: A h + h of eq. 8, to first order in the angles."""
    iron = next(np.array(e.offset_nT) for e in chain if isinstance(e, HardIron))
    return np.asarray(iron + next(np.array(e.offset_nT) for e in chain if isinstance(e, SensorOffset)))


def level_nT(seed: int, drift: float = 1.0) -> Array:
    """Return the measured field on the level spiral (n, 3)."""
    return Chain(effects(drift), SEED, seed).apply(spiral(False))[0]


def search_trial(seed: int) -> ZhangTrial:
    """Run the three methods under every setting on the level spiral."""
    strength, truth = strength_nT(spiral(False)), true_offset_nT(effects())
    measured = {drift: level_nT(seed, drift) for drift in {s.drift for s in SETTINGS}}
    trial = ZhangTrial(np.linalg.norm(measured[1.0][:POSITIONS], axis=1) - strength, {}, {}, {})
    for setting in SETTINGS:
        mag_nT = measured[setting.drift]
        problem = bounded(mag_nT, strength, setting.reach_nT)
        for name in METHODS:
            key = (setting.label, name)
            found = setting.method(name).search(problem, stream(SEED, seed, name))
            offset = problem.middle_nT + strength * found.best[6:]
            field = (mag_nT[:POSITIONS] - offset) @ triangular(found.best).T
            trial.errors_nT[key] = np.linalg.norm(field, axis=1) - strength
            trial.rms_nT[key] = problem.rmse_nT(found.costs)
            trial.offset_nT[key] = float(np.linalg.norm(offset - truth))
    return trial


def drift_trial(seed: int) -> DriftTrial:
    """Run each of FITS under every drift on the excited spiral."""
    state = spiral(True)
    trial = DriftTrial({}, {}, {})
    runs = [_fits(state, effects(drift), seed) for drift in DRIFTS]
    for name in FITS:
        of_name = [run[name] for run in runs]
        trial.rms_nT[name] = tuple(fit[0] for fit in of_name)
        trial.offset_nT[name] = tuple(fit[1] for fit in of_name)
        trial.segments[name] = tuple(fit[2] for fit in of_name)
    return trial


def quadric_trial(seed: int) -> tuple[float, float]:
    """Return the rms of |h| - F, nT, with eq. 15's triangle as printed and with the symmetric matrix, without drift.

    Excited circles, the printed example of eq. 7 and the scenario's hard iron; m^T A m + 2 p^T m = 1 by least squares,
    L0 = -A^-1 p, |h|^2 = F^2 (m - L0)^T A (m - L0) / (1 + L0^T A L0). Printed: the upper triangle of the symmetric A,
    halves included, which drops half of each mixed term.
    """
    state = spiral(True)
    strength, iron = strength_nT(state), true_offset_nT(effects())
    noise = NOISE_NT * stream(SEED, seed, "quadric").standard_normal(state.field_nT.shape)
    x = ((state.field_nT + iron) @ PRINTED_SOFT.T + iron + noise) / strength
    theta = np.asarray(np.linalg.lstsq(design(x), np.ones(len(x)), rcond=None)[0], dtype=np.float64)
    A = shape_matrix(theta)
    printed, right = (_quadric_rms(x, matrix, theta[6:]) * strength for matrix in (np.triu(A), A))
    return printed, right


def _quadric_rms(x: Array, A: Array, p: Array) -> float:
    centre = -np.linalg.solve(A, p)
    square = np.einsum("ni,ij,nj->n", x - centre, A, x - centre) / (1 + centre @ A @ centre)
    return float(np.sqrt(np.mean((np.sqrt(square) - 1) ** 2)))


def _fits(state: State, chain: tuple[Effect, ...], seed: int) -> dict[str, tuple[float, float, int]]:
    """Return rms of |h| - F, rms distance from the true offset, and number of segments, by fit."""
    recording = Recording(state.time_s, Chain(chain, SEED, seed).apply(state)[0])
    strength, truth = strength_nT(state), moving_offset_nT(state, chain)
    found = {}
    for name, calibrator in FITS.items():
        fit = calibrator.fit(recording, Reference(strength))
        error = np.linalg.norm(fit.apply(recording), axis=1) - strength
        away = np.linalg.norm(_offsets_nT(fit, state.time_s) - truth, axis=1)
        found[name] = rms(error), rms(away), max(len(fit.segments), 1)
    return found


def moving_offset_nT(state: State, chain: tuple[Effect, ...]) -> Array:
    """Return the output without field and noise at each time (n, 3): hard iron and drift."""
    nowhere = replace(state, field_nT=np.zeros_like(state.field_nT))
    return Chain(tuple(e for e in chain if not isinstance(e, WhiteNoise)), SEED).apply(nowhere)[0]


def _offsets_nT(fit: Calibration, time_s: Array) -> Array:
    if not fit.segments:
        return fit.offset_nT
    place = np.searchsorted([segment.start_s for segment in fit.segments], time_s, side="right") - 1
    return np.array([segment.offset_nT for segment in fit.segments])[place]
