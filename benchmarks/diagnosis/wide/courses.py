"""Motions drawn afresh for a seed, and what an instrument records along them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from recordings import Recording
from recordings.assemble import recording_of
from scenarios.arrays import Array
from sim.rotation import matrix_from_q, to_body
from sim.scenario import Scenario
from sim.simulation import blocks, plan

STEP_S = 0.02
"""Interval of the truth, of which a recording takes every n-th sample."""
EVERY = (1, 2, 3, 4, 5, 8, 10)
"""Sample rates of 50 to 5 Hz."""
SHORTEST_S, LONGEST_S = 480.0, 1800.0
QUIET = dict.fromkeys(
    (
        "gyro_noise_std_rad_s", "gyro_bias_std_rad_s", "accel_noise_std_m_s2", "accel_bias_std_m_s2",
        "attitude_noise_std_deg", "position_noise_std_m", "temperature_noise_std_K", "current_noise_std_A",
    ),
    0.0,
)  # fmt: skip
GYRO_RAD_S, CURRENT_A, TEMPERATURE_K = 1e-3, 0.02, 0.02
"""Noise of a sample of the channels."""
Phase = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Course:
    """A motion without any error, sampled at `STEP_S`: n times, attitude, place, causes, and the field's vector."""

    time_s: Array
    q: Array
    R_wb: Array
    pos_enu_m: Array
    rate_rad_s: Array
    current_A: Array
    temperature_degC: Array
    field_enu_nT: Array
    every: int

    @cached_property
    def field_nT(self) -> Array:
        """The undisturbed field (n, 3) in the body frame."""
        return np.asarray(to_body(self.R_wb, self.field_enu_nT[None]))

    @property
    def duration_s(self) -> float:
        """Length of the run."""
        return float(self.time_s[-1])

    @property
    def has(self) -> frozenset[str]:
        """What of the causes there is beside attitude, place and temperature."""
        return frozenset({"currents"}) if self.current_A.shape[1] else frozenset()

    def recorded(self, mag_nT: Array, rng: np.random.Generator) -> Recording:
        """What is logged (every n-th sample) with a measured field (n, 3) and the channels' own noise."""
        at = slice(None, None, self.every)
        n = len(self.time_s[at])
        noisy: dict[str, Any] = {
            "gyro_rad_s": self.rate_rad_s[at] + GYRO_RAD_S * rng.normal(size=(n, 3)),
            "temperature_degC": self.temperature_degC[at] + TEMPERATURE_K * rng.normal(size=n),
            "current_A": self.current_A[at] + CURRENT_A * rng.normal(size=(n, self.current_A.shape[1])),
        }
        if rng.uniform() < 0.3:  # a log without gyro
            del noisy["gyro_rad_s"]
        if not self.has:
            del noisy["current_A"]
        time_s, mag, q, pos = (np.ascontiguousarray(v[at]) for v in (self.time_s, mag_nT, self.q, self.pos_enu_m))
        return Recording(time_s, mag, att_q=q, pos_enu_m=pos, **noisy)


@lru_cache(maxsize=4)
def course(vehicle: str, seed: int) -> Course:
    """A vehicle's motion through paths drawn for a seed, in a field and at a sample rate drawn for it."""
    rng = np.random.default_rng([seed, sorted(DRAWN).index(vehicle), 21])
    table, phases = DRAWN[vehicle](rng, rng.uniform(SHORTEST_S, LONGEST_S))
    made = _flown(_scenario(table, phases, rng), seed, rng)
    return _walked(made, rng) if vehicle == HAND else made


def circling(length_s: float, every: int) -> Course:
    """An AUV that circles and tilts for a time, of which every n-th sample is recorded."""
    rng = np.random.default_rng(0)
    circles = _circles(rng, length_s, (0.8, 3.0)) | _tilts(rng)
    return replace(_flown(_scenario({"kind": "auv", "depth_m": 120.0}, [circles], rng), 0, rng), every=every)


def _scenario(table: Phase, phases: list[Phase], rng: np.random.Generator) -> Scenario:
    """A vehicle and its phases in a field and surroundings drawn for it."""
    return Scenario.model_validate(
        {
            "name": "drawn", "summary": "drawn", "vehicle": table, "phases": phases, "navigation": QUIET,
            "sampling": {"rate_hz": 1 / STEP_S}, "field": {"enu_nT": _field_enu_nT(rng).tolist()},
            "thermal": {"time_constant_s": rng.uniform(60, 400), "scale_depth_m": rng.uniform(20, 200)},
        }
    )  # fmt: skip


def _flown(scenario: Scenario, seed: int, rng: np.random.Generator) -> Course:
    made = plan(scenario, 0, seed)
    columns: dict[str, list[Any]] = {}
    for block in blocks(made):
        for key, values in block.items():
            columns.setdefault(key, []).append(values)
    whole = {key: np.concatenate(parts) for key, parts in columns.items()}
    log = recording_of({k: v for k, v in whole.items() if not k.startswith(("true_", "effect"))})
    q = np.ascontiguousarray(np.stack([whole[f"true_q{a}"] for a in "wxyz"], axis=1))
    n = len(log)
    assert log.gyro_rad_s is not None
    assert log.temperature_degC is not None
    return Course(
        time_s=log.time_s,
        q=q,
        R_wb=matrix_from_q(q),
        pos_enu_m=np.stack([whole[f"true_pos_{a}_m"] for a in ("east", "north", "up")], axis=1),
        rate_rad_s=log.gyro_rad_s,
        current_A=np.zeros((n, 0)) if log.current_A is None else log.current_A,
        temperature_degC=log.temperature_degC,
        field_enu_nT=made.field_enu_nT,
        every=int(rng.choice(EVERY)),
    )


def _walked(made: Course, rng: np.random.Generator) -> Course:
    """The hand that turns it walks about, and the sensor warms in it."""
    n, t = len(made.time_s), made.time_s
    way = gaussian_filter1d(rng.normal(size=(n, 3)), 15.0 / STEP_S, axis=0)
    way *= np.array([6.0, 6.0, 0.4]) / way.std(axis=0)
    warm = rng.uniform(3, 12) * (1 - np.exp(-t / rng.uniform(60, 500)))
    shade = gaussian_filter1d(rng.normal(size=n), 60.0 / STEP_S)
    felt = rng.uniform(5, 25) + warm + rng.uniform(0.5, 2) * shade / shade.std()
    return replace(made, pos_enu_m=way, temperature_degC=felt, current_A=np.zeros((n, 0)))


def _field_enu_nT(rng: np.random.Generator) -> Array:
    dip, declination = np.radians(rng.uniform(20, 72)) * rng.choice([-1, 1]), np.radians(rng.uniform(-25, 25))
    level = np.cos(dip)
    unit = np.array([level * np.sin(declination), level * np.cos(declination), -np.sin(dip)])
    return np.asarray(rng.uniform(28e3, 62e3) * unit)


def _tilts(rng: np.random.Generator) -> Phase:
    return {
        "roll_amplitude_deg": rng.uniform(8, 25), "roll_period_s": rng.uniform(12, 50),
        "pitch_amplitude_deg": rng.uniform(8, 25), "pitch_period_s": rng.uniform(15, 60),
    }  # fmt: skip


def _circles(rng: np.random.Generator, length_s: float, rate: tuple[float, float]) -> Phase:
    turn = float(rng.choice([-1, 1]) * rng.uniform(*rate))
    speed = rng.uniform(0.3, 0.9) if rate[1] < 5 else rng.uniform(1.5, 5)
    radius = min(speed / np.radians(abs(turn)), 60.0)
    return {"kind": "spiral", "radius_m": radius, "turn_rate_deg_s": turn, "duration_s": length_s}


def _survey(rng: np.random.Generator, length_s: float, speed_m_s: float) -> Phase:
    line, spacing = rng.uniform(30, 70), rng.uniform(12, 25)
    lines = max(3, round(length_s * speed_m_s / (line + 2 * spacing)))
    return {
        "kind": "comb", "line_length_m": line, "line_spacing_m": spacing, "lines": lines, "speed_m_s": speed_m_s,
        "run_in_s": 10.0,
    }  # fmt: skip


def _attitudes(rng: np.random.Generator, length_s: float, tilt_deg: float, pace_s: tuple[float, float]) -> Phase:
    poses: list[Phase] = []
    passed = 0.0
    while passed < length_s and len(poses) < 900:
        move, hold = rng.uniform(*pace_s), rng.uniform(0.2, pace_s[1])
        tilts = {"pitch_deg": rng.uniform(-tilt_deg, tilt_deg) / 2, "roll_deg": rng.uniform(-tilt_deg, tilt_deg)}
        poses.append({"yaw_deg": rng.uniform(-180, 180), **tilts, "move_s": move, "hold_s": hold})
        passed += move + hold
    return {"kind": "poses", "poses": poses}


def _auv(rng: np.random.Generator, length_s: float) -> tuple[Phase, list[Phase]]:
    part = length_s / 2
    several = [
        _circles(rng, part, (0.8, 3.0)) | {"vertical_speed_m_s": rng.uniform(-0.1, 0.05)} | _tilts(rng),
        _survey(rng, part, rng.uniform(0.6, 1.1)) | _tilts(rng),
        _attitudes(rng, part, 30.0, (8.0, 20.0)),
    ]
    current = [rng.normal(0, 0.05), rng.normal(0, 0.05), 0.0]
    order = rng.permutation(3)[:2]
    return {"kind": "auv", "depth_m": 120.0, "current_enu_m_s": current}, [several[i] for i in order]


def _quadrotor(rng: np.random.Generator, length_s: float) -> tuple[Phase, list[Phase]]:
    part = length_s / 2
    sway = {
        "kind": "rotate", "duration_s": part, "turn_rate_deg_s": rng.uniform(6, 25),
        "tilt_amplitude_deg": rng.uniform(10, 25), "tilt_period_s": rng.uniform(3, 6),
    }  # fmt: skip
    several = [
        sway,
        _circles(rng, part, (6.0, 25.0)) | {"vertical_speed_m_s": rng.uniform(-0.01, 0.1), "run_in_s": 8.0},
        _survey(rng, part, rng.uniform(2, 5)),
    ]
    wind = [rng.normal(0, 1.5), rng.normal(0, 1.5), 0.0]
    table = {"kind": "quadrotor", "height_m": 40.0, "wind_enu_m_s": wind, "gust_std_m_s": rng.uniform(0.1, 0.5)}
    return table, [several[0], several[int(rng.integers(1, 3))]]


def _hand(rng: np.random.Generator, length_s: float) -> tuple[Phase, list[Phase]]:
    tumble = {
        "kind": "tumble", "duration_s": length_s / 3, "roll_period_s": rng.uniform(15, 50),
        "pitch_period_s": rng.uniform(20, 70), "yaw_rate_deg_s": rng.uniform(5, 25),
        "pitch_amplitude_deg": rng.uniform(30, 80),
    }  # fmt: skip
    return {"kind": "turntable"}, [_attitudes(rng, length_s * 2 / 3, 120.0, (1.5, 4.0)), tumble]


HAND = "hand"
DRAWN: dict[str, Callable[[np.random.Generator, float], tuple[Phase, list[Phase]]]] = {
    "auv": _auv,
    "quadrotor": _quadrotor,
    HAND: _hand,
}
"""Vehicle or hand -> (rng, length in s) -> the vehicle's table and the phases."""
