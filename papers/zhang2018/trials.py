"""[Zhang2018]'s experiments, one seed at a time: the spiral once, then fresh noise and fresh random searches."""

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
    """What the paper leaves open.

    reach_nT: bounds of the hard iron, 0: all that the data allow, see `bounded`; drift: multiple of the catalogue's.
    """

    label: str
    reach_nT: float
    c: float = 2.0
    mutation: float = 0.02
    iterations: int = 200
    drift: float = 1.0

    def method(self, name: str) -> PopulationCalibrator:
        """The method of that name without the polish: the paper's."""
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
MAIN, SHORT, LONGER = (SETTINGS[k].label for k in (0, 3, 4))


@dataclass(frozen=True)
class ZhangTrial:
    """One seed on the level spiral: raw_nT (30,) the raw |m| - F at the positions; by setting and method: |h| - F there
    (30,), the rms of the best after each iteration, and the offset's distance from the truth."""

    raw_nT: Array
    errors_nT: dict[tuple[str, str], Array]
    rms_nT: dict[tuple[str, str], Array]
    offset_nT: dict[tuple[str, str], float]


def rms_nT(trials: list[ZhangTrial], setting: str, name: str) -> Array:
    """The rms of |h| - F of the best after each iteration: (seeds, iterations) nT."""
    return np.array([t.rms_nT[setting, name] for t in trials])


@dataclass(frozen=True)
class DriftTrial:
    """One seed on the excited spiral, a value a drift for each of FITS: rms of |h| - F over the record, rms distance of
    the offset from the true one at that time, nT, and the number of segments."""

    rms_nT: dict[str, tuple[float, ...]]
    offset_nT: dict[str, tuple[float, ...]]
    segments: dict[str, tuple[int, ...]]


@lru_cache(maxsize=2)
def spiral(excited: bool) -> State:
    """The motion: an hour of level circles at 1 degree/s at 3000 m, a sample each 10 s; or with roll and pitch, 2 s."""
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
    """The catalogue's errors of `auv-dive`, its drift multiplied."""
    return tuple(_drifting(effect, drift) for effect in plan(load("auv-dive")).effects[0])


def _drifting(effect: Effect, drift: float) -> Effect:
    if not isinstance(effect, HardIronDrift):
        return effect
    x, y, z = effect.rate_nT_h
    return replace(effect, rate_nT_h=(drift * x, drift * y, drift * z))


def strength_nT(state: State) -> float:
    """F."""
    return float(np.linalg.norm(state.field_enu_nT))


def bounded(mag_nT: Array, strength: float, reach_nT: float) -> NormSpace:
    """The search problem; with a reach, R within 0.1 of the identity and each offset within reach_nT of zero."""
    problem = NormSpace.of(mag_nT, strength, Pso.most_gain)
    assert problem is not None
    if not reach_nT:
        return problem
    middle, reach = -problem.middle_nT / strength, reach_nT / strength
    matrix = np.eye(3)[np.triu_indices(3)]
    return replace(
        problem,
        lower=np.concatenate((matrix - 0.1, middle - reach)),
        upper=np.concatenate((matrix + 0.1, middle + reach)),
    )


def true_offset_nT(chain: tuple[Effect, ...]) -> Array:
    """What a sensor in no field measures, at the start: A h + h of [Zhang2018] eq. 8, to the angles' first order."""
    iron = next(np.array(e.offset_nT) for e in chain if isinstance(e, HardIron))
    return np.asarray(iron + next(np.array(e.offset_nT) for e in chain if isinstance(e, SensorOffset)))


def level_nT(seed: int, drift: float = 1.0) -> Array:
    """What the sensor measures on the level spiral (n, 3)."""
    return Chain(effects(drift), SEED, seed).apply(spiral(False))[0]


def search_trial(seed: int) -> ZhangTrial:
    """The three methods under every setting, on the level spiral."""
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
    """Each of FITS under every drift, on the excited spiral."""
    state = spiral(True)
    trial = DriftTrial({}, {}, {})
    runs = [_fits(state, effects(drift), seed) for drift in DRIFTS]
    for name in FITS:
        of_name = [run[name] for run in runs]
        trial.rms_nT[name] = tuple(fit[0] for fit in of_name)
        trial.offset_nT[name] = tuple(fit[1] for fit in of_name)
        trial.segments[name] = tuple(fit[2] for fit in of_name)
    return trial


def _fits(state: State, chain: tuple[Effect, ...], seed: int) -> dict[str, tuple[float, float, int]]:
    """Rms of |h| - F, rms distance from the true offset, segments."""
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
    """What the sensor measures in no field and without noise at each time (n, 3): the hard iron and all that drifts."""
    nowhere = replace(state, field_nT=np.zeros_like(state.field_nT))
    return Chain(tuple(e for e in chain if not isinstance(e, WhiteNoise)), SEED).apply(nowhere)[0]


def _offsets_nT(fit: Calibration, time_s: Array) -> Array:
    if not fit.segments:
        return fit.offset_nT
    place = np.searchsorted([segment.start_s for segment in fit.segments], time_s, side="right") - 1
    return np.array([segment.offset_nT for segment in fit.segments])[place]
