"""Logs of the simulator: scenarios of the catalogue, shortened, with drawn iron and drawn disturbances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.assessment.level_truth import LevelTruth, headings_rad
from calib import Reference
from recordings import Recording, Truth
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.memory_run import run_in_memory
from sim.scenario import load
from sim.simulation import PreparedRun, plan
from validation.scoring.hold_out import Environment, simulate_motion, uniform_attitudes

TEN_HZ, FIVE_HZ = "sampling.rate_hz=10", "sampling.rate_hz=5"
SCENARIOS: dict[str, tuple[str, ...]] = {
    "quad-calibration": ("phases.0.duration_s=5", "phases.1.duration_s=100", "phases.2.duration_s=5", TEN_HZ),
    "quad-fleet": ("phases.0.duration_s=5", "phases.1.duration_s=100", TEN_HZ),
    "quad-spiral": ("phases.0.duration_s=120", TEN_HZ),
    "quad-comb": ("phases.0.lines=3", TEN_HZ),
    "auv-fleet": ("phases.0.duration_s=300", FIVE_HZ),
    "auv-spiral-excited": ("phases.0.duration_s=300", FIVE_HZ),
    "auv-spiral": ("phases.0.duration_s=300", FIVE_HZ),
    "auv-comb": ("phases.0.lines=2", FIVE_HZ),
    "turntable-fleet": ("phases.0.duration_s=150",),
    "tumble": ("phases.0.duration_s=150",),
    "standard-full": ("phases.0.duration_s=200",),
    "standard-pitch": ("phases.0.duration_s=200",),
    "standard-auv": ("phases.0.duration_s=200",),
    "turntable-three-turns": (),
    "turntable-twelve-stops": ("phases.0.dwell_s=5",),
}
"""Scenarios of one magnetometer, with changes that make them short."""
FLEETS = ("quad-fleet", "auv-fleet", "turntable-fleet")
"""Scenarios that draw iron, sensor and place themselves."""
SHARE = 0.12
"""Probability of each disturbance in a log."""
KNOWS_VECTOR, HAS_ATTITUDE = 0.5, 0.5
"""Probability that a log's field vector is stated, and that navigation's attitude is recorded."""
DRIVEN = ("motor_current", "temperature_offset")
"""Effects whose field follows an input and is the same in every attitude."""
WANDERING = ("offset_random_walk", "flicker_noise", "offset_jump", "hard_iron_drift")
"""Effects whose mean over the log is a part of the offset."""
SOFT_SIZES = (0.001, 0.03)
Draw = Callable[[np.random.Generator], tuple[str, ...]]


@dataclass(frozen=True, eq=False)
class CatalogueLog:
    """A simulated recording, what it is calibrated by, and its truth."""

    recording: Recording
    reference: Reference
    motion: str
    disturbances: tuple[str, ...]
    run: PreparedRun
    truth: Truth

    def level(self, dip_rad: float | None = None) -> LevelTruth:
        """Return the sensor's truth in level flight at the log's dip or another, at the mean conditions of the log."""
        strength = float(np.linalg.norm(self.run.field_enu_nT))
        dip_rad = float(np.arcsin(-self.run.field_enu_nT[2] / strength)) if dip_rad is None else dip_rad
        field = strength * np.array([0.0, np.cos(dip_rad), -np.sin(dip_rad)])
        environment = Environment.of(self.recording, field)
        effects = [one for one in self.run.effects[0] if _counts(one)]
        turned = Rotation.from_euler("Z", (np.pi / 2 - headings_rad())[:, None])
        level = simulate_motion(effects, environment, turned)
        sphere = simulate_motion(effects, environment, uniform_attitudes(200))
        rows = np.column_stack((sphere.true_nT / strength, np.ones(len(sphere.true_nT))))
        soft = np.linalg.lstsq(rows, sphere.measured_nT, rcond=None)[0][:3].T / strength
        measured_nT = np.asarray(level.measured_nT + self._of(WANDERING).mean(axis=0))
        return LevelTruth(measured_nT, np.asarray(soft), self._of(DRIVEN))

    def _of(self, names: tuple[str, ...]) -> Array:
        """Return the field (n, 3) of some effects in the log."""
        parts = [field for name, field in self.truth.effects.items() if name in names]
        return np.asarray(np.sum(parts, axis=0)) if parts else np.zeros_like(self.recording.mag_nT)


def _counts(effect: Effect) -> bool:
    """Whether an effect is of the sensor in every attitude, and not counted by its mean."""
    return effect.static and effect.stage != "field" and effect.name not in WANDERING


def catalogue_log(seed: int, bank: int, only: str | None = None) -> CatalogueLog:
    """Return the log of a seed; `only`: with this disturbance alone, or with none for ""."""
    rng = np.random.default_rng([bank, seed, 2])
    scenario = str(rng.choice(tuple(SCENARIOS)))
    drawn = tuple(name for name in DISTURB if rng.random() < SHARE)
    chosen = drawn if only is None else tuple(name for name in DISTURB if name == only)
    chosen = tuple(name for name in chosen if name not in MOVING or scenario.startswith(MOVING[name]))
    changes = [*SCENARIOS[scenario], *(() if scenario in FLEETS else _iron(rng))]
    for name in chosen:
        changes += DISTURB[name](rng)
    run = plan(load(scenario, changes), int(rng.integers(1_000_000)))
    recording, truth = run_in_memory(run)
    reference = Reference.of_vector(tuple(run.field_enu_nT.tolist()))
    if rng.random() > KNOWS_VECTOR:
        reference = Reference(reference.strength_nT)
    recording = recording if rng.random() < HAS_ATTITUDE else replace(recording, att_q=None)
    return CatalogueLog(recording, reference, scenario, chosen, run, truth)


def _vector(rng: np.random.Generator, low: float, high: float) -> list[float]:
    """Return a vector of any direction, its length log-uniform."""
    unit = rng.normal(size=3)
    size = np.exp(rng.uniform(np.log(low), np.log(high)))
    return [float(x) for x in size * unit / np.linalg.norm(unit)]


def _iron(rng: np.random.Generator) -> tuple[str, ...]:
    lean = rng.normal(0, float(rng.choice(SOFT_SIZES)), (3, 3))
    soft = ((lean + lean.T) / 2).tolist()
    return f"effects.soft_iron.matrix={soft}", f"effects.hard_iron.offset_nT={_vector(rng, 200, 20_000)}"


def _warming(rng: np.random.Generator) -> tuple[str, ...]:
    start, surface = rng.uniform(15, 40), rng.uniform(5, 25)
    return (
        f"thermal.initial_degC={start:.3f}",
        f"thermal.surface_degC={surface:.3f}",
        f"thermal.time_constant_s={rng.uniform(30, 300):.3f}",
    )


def _of(key: str, low: float, high: float) -> Draw:
    """Return the draw of a vector for a key, its length between two ends."""
    return lambda rng: (f"{key}={_vector(rng, low, high)}",)


def _number(key: str, low: float, high: float) -> Draw:
    """Return the draw of a log-uniform number for a key."""
    return lambda rng: (f"{key}={np.exp(rng.uniform(np.log(low), np.log(high))):.6g}",)


def _eddy(rng: np.random.Generator) -> tuple[str, ...]:
    return (f"effects.eddy_current.matrix_s={rng.normal(0, 0.02, (3, 3)).tolist()}",)


def _temperature(rng: np.random.Generator) -> tuple[str, ...]:
    return *_warming(rng), f"effects.temperature_offset.slope_nT_K={_vector(rng, 2, 40)}"


def _warm_scale(rng: np.random.Generator) -> tuple[str, ...]:
    return *_warming(rng), f"effects.temperature_scale.slope_1_K={_vector(rng, 1e-5, 4e-4)}"


def _jump(rng: np.random.Generator) -> tuple[str, ...]:
    return (
        f"effects.offset_jump.time_s={rng.uniform(20, 80):.3f}",
        f"effects.offset_jump.step_nT={_vector(rng, 20, 500)}",
    )


def _spikes(rng: np.random.Generator) -> tuple[str, ...]:
    return (
        f"effects.spikes.rate_hz={rng.uniform(0.005, 0.1):.4f}",
        f"effects.spikes.amplitude_nT={rng.uniform(500, 2e4):.1f}",
    )


def _dropouts(rng: np.random.Generator) -> tuple[str, ...]:
    return f"effects.dropouts.rate_hz={rng.uniform(0.01, 0.1):.4f}", "effects.dropouts.mean_duration_s=0.5"


def _curved(rng: np.random.Generator) -> tuple[str, ...]:
    second, third = _vector(rng, 1e-4, 3e-3), _vector(rng, 1e-4, 3e-3)
    reference = "effects.nonlinearity.reference_nT=50000.0"
    return f"effects.nonlinearity.second_order={second}", f"effects.nonlinearity.third_order={third}", reference


def _hysteresis(rng: np.random.Generator) -> tuple[str, ...]:
    gain = np.abs(_vector(rng, 5e-4, 5e-3)).tolist()
    return f"effects.hysteresis.gain={gain}", f"effects.hysteresis.threshold_nT={rng.uniform(500, 5000):.1f}"


def _gradient(rng: np.random.Generator) -> tuple[str, ...]:
    one = rng.uniform(0.05, 1.0) * rng.choice([-1, 1])
    return (f"effects.field_gradient.gradient_nT_m={np.diag([one, one, -2 * one]).tolist()}",)


def _body(rng: np.random.Generator) -> tuple[str, ...]:
    east, north, down = rng.uniform(0, 60), rng.uniform(0, 60), -rng.uniform(15, 40)
    place = f"effects.local_dipole.position_enu_m=[{east:.2f}, {north:.2f}, {down - 100:.2f}]"
    return place, f"effects.local_dipole.moment_A_m2={_vector(rng, 500, 20_000)}"


def _attitude(rng: np.random.Generator) -> tuple[str, ...]:
    noise = f"navigation.attitude_noise_std_deg={np.exp(rng.uniform(np.log(0.1), np.log(2.0))):.4f}"
    return noise, f"effects.attitude_misalignment.angles_deg={_vector(rng, 0.05, 0.5)}"


DISTURB: dict[str, Draw] = {
    "motors": _of("effects.motor_current.gain_nT_A", 1.0, 60.0),
    "ripple": _of("effects.current_ripple.amplitude_nT_A", 0.1, 10.0),
    "eddy currents": _eddy,
    "temperature": _temperature,
    "temperature scale": _warm_scale,
    "flicker": _number("effects.flicker_noise.density_nT_sqrt_hz", 2.0, 100.0),
    "random walk": _number("effects.offset_random_walk.std_nT_sqrt_s", 0.3, 10.0),
    "drift": _of("effects.hard_iron_drift.rate_nT_h", 50.0, 5000.0),
    "jump": _jump,
    "white noise": _number("effects.white_noise.std_nT", 3.0, 500.0),
    "spikes": _spikes,
    "dropouts": _dropouts,
    "quantisation": _number("effects.quantisation.step_nT", 5.0, 400.0),
    "nonlinearity": _curved,
    "hysteresis": _hysteresis,
    "bandwidth": _number("effects.bandwidth.cutoff_hz", 1.0, 5.0),
    "latency": _number("effects.latency.delay_s", 0.01, 0.2),
    "regional field": _of("effects.regional_field.error_enu_nT", 30.0, 500.0),
    "day's change": _of("effects.diurnal_drift.amplitude_enu_nT", 5.0, 60.0),
    "gradient": _gradient,
    "body": _body,
    "attitude": _attitude,
}
"""Changes of a scenario that make each disturbance."""
MOVING = {
    "motors": ("quad", "auv"),
    "ripple": ("quad", "auv"),
    "gradient": ("quad", "auv"),
    "body": ("auv-fleet", "auv-spiral"),
}
"""Scenarios, by the beginnings of their names, that a disturbance needs: with motors, or that move."""
