"""How far each vehicle is from its reference: the rows of a table in docs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.paths import Ability
from scenarios.seeds import stream
from sim.motion import Motion, drive
from sim.scenario import Scenario, load
from sim.vehicles import VEHICLES
from validation.signals.quaternion_conventions import euler_deg

SCENARIOS = (
    *("auv-spiral", "auv-spiral-excited", "auv-comb"),
    *("quad-spiral", "quad-comb", "quad-calibration"),
    *("turntable-twelve-stops", "turntable-three-turns", "tumble"),
)


def rows(names: Iterable[str]) -> Iterable[tuple[str, ...]]:
    """A row a phase, after its run-in."""
    return (row for name in names for row in _tracked(load(name)))


def _tracked(scenario: Scenario) -> Iterable[tuple[str, ...]]:
    parts: dict[int, list[Motion]] = {}
    for motion in drive(scenario, stream(scenario.seed, 0, "flow")):
        parts.setdefault(motion.phase, []).append(motion)
    for index, motions in parts.items():
        settled = np.concatenate([m.phase_time_s for m in motions]) > scenario.phases[index].settle_s
        phase, tilts = scenario.phases[index], Ability.SWAY not in VEHICLES[scenario.vehicle.kind].abilities
        figures = np.concatenate([_errors(tilts, m) for m in motions])[settled]
        yield (f"`{scenario.name}`", phase.kind, *_cells(phase.tracked, figures))


def _errors(tilts: bool, motion: Motion) -> Any:
    """Rows (n, 4): distance from the reference in m, angle from it in degrees, pitch and roll in degrees."""
    apart_m = np.linalg.norm(motion.reference[:, :3] - motion.kinematics.pos_enu_m, axis=1)
    wanted = Rotation.from_euler("ZYX", motion.reference[:, 9:12])
    apart_deg = np.degrees((wanted.inv() * Rotation.from_matrix(motion.R_wb)).magnitude())
    yaw_deg, pitch_deg, roll_deg = euler_deg(motion.kinematics.q).T
    if not tilts:  # its tilt follows from its acceleration: only the heading is commanded
        apart_deg = (yaw_deg - np.degrees(motion.reference[:, 9]) + 180.0) % 360.0 - 180.0
    return np.column_stack([apart_m, apart_deg, pitch_deg, roll_deg])


def _cells(tracked: bool, figures: Any) -> tuple[str, ...]:
    rms = np.sqrt(np.mean(figures[:, :2] ** 2, axis=0))
    distance = (_length(rms[0]), _length(figures[:, 0].max())) if tracked else ("–", "–")
    low, high = np.round(figures[:, 2:], 1).min(axis=0) + 0.0, np.round(figures[:, 2:], 1).max(axis=0) + 0.0
    turns = (f"{a:.1f} to {b:.1f}°" for a, b in zip(low, high, strict=True))
    return (*distance, "< 0.001°" if rms[1] < 1e-3 else f"{rms[1]:.2g}°", *turns)


def _length(metres: float) -> str:
    return f"{1e3 * metres:.2g} mm" if metres < 0.0995 else f"{metres:.2g} m"
