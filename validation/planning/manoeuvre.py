"""Manoeuvres that present attitudes to the sensor: attitudes held, or tilts by thrust in alternating directions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.names import closest
from scenarios.paths import PhaseBase, Start
from scenarios.paths.hover import GRAVITY_M_S2
from scenarios.paths.poses import Poses, Pushes, nearest
from sim.vehicles import VEHICLES
from validation.bound.limit import Tilts

PEAK = 1.875
"""Peak rate of a smoothstep over its mean rate."""
LEAST_MOVE_S = 1.0
"""Shortest time of a turn between attitudes."""
PUSHES_S = (1.5, 2.5, 4.0)
"""Half the times of a tilt. At 45 degrees a quadrotor reaches 13, 18 and 21 m/s."""
RUN_IN_S = 1.0
"""Time before the first push: a planned flight begins at rest."""
MOST_PUSH_S, FILLINGS, SPARE_S = 10.0, 3, 0.01
"""Longest push of a phase; steps in which pushes are stretched (time is nearly linear in length); spare time for
rounding."""
LEAST_SWITCH_S, MOST_SLOPE_M_S3 = 0.6, 40.0
"""Shortest time between opposite tilts, and largest jerk: with more, a quadrotor's controller overshoots a tilt of
30 degrees by 12 degrees."""
YAW, PITCH, ROLL = range(3)


@dataclass(frozen=True)
class Leg:
    """Attitude Rz(yaw) Ry(pitch) Rx(roll) in degrees, with amount: seconds of holding, or number of pushes."""

    yaw_deg: float
    pitch_deg: float
    roll_deg: float
    amount: float

    @classmethod
    def at(cls, angles_deg: Array, amount: float) -> Leg:
        """Return a leg at yaw, pitch and roll (3,)."""
        yaw, pitch, roll = (float(angle) for angle in angles_deg)
        return cls(yaw, pitch, roll, amount)

    @property
    def angles_deg(self) -> tuple[float, float, float]:
        """Return yaw, pitch, roll."""
        return self.yaw_deg, self.pitch_deg, self.roll_deg


@dataclass(frozen=True)
class Manoeuvre(ABC):
    """Conversion of legs to a phase of a scenario, with predicted attitudes of the vehicle, without physics.

    turning_deg_s : peak rate of turns between legs; yaw_deg : heading at the start; drag_1_m : drag of the vehicle over
    mass and squared speed
    least, whole : lower limit of a leg's amount, and whether amounts are integers; most_deg : largest roll and pitch
    stays : whether the vehicle tilts only by thrust, so that every tilt needs an opposite tilt
    """

    turning_deg_s: float
    yaw_deg: float = 0.0
    drag_1_m: float = 0.0
    path: ClassVar[type[PhaseBase]]
    least: ClassVar[float]
    whole: ClassVar[bool]
    most_deg: ClassVar[float] = 180.0
    stays: ClassVar[bool] = False

    @property
    @abstractmethod
    def ways(self) -> tuple[Manoeuvre, ...]:
        """Return variants of the manoeuvre, tried in order until the error is near the limit."""

    @abstractmethod
    def within(self, tilts: Tilts) -> Manoeuvre:
        """Return the manoeuvre for legs within tilts."""

    @abstractmethod
    def halves(self, attitudes: Rotation) -> tuple[Rotation, ...]:
        """Return the attitudes (m), in equal parts, that legs at given attitudes consist of."""

    def filling(self, legs: Sequence[Leg], time_s: float) -> Manoeuvre:
        """Return the manoeuvre stretched so that integer amounts fill a time."""
        return self

    @abstractmethod
    def phase(self, legs: Sequence[Leg]) -> PhaseBase:
        """Return the phase with the legs."""

    @abstractmethod
    def unit(self, leg: Leg) -> tuple[PhaseBase, float, float]:
        """Return a phase, and the times between which a unit of the leg is flown."""

    @abstractmethod
    def times_s(self, phase: Any) -> list[tuple[float, float]]:
        """Return start and duration of each leg of a phase."""

    @abstractmethod
    def seen(self, reference: Array) -> Rotation:
        """Return the attitudes (n) of a reference (n, 18)."""

    def attitudes(self, phase: PhaseBase, from_s: float, to_s: float, interval_s: float) -> Rotation:
        """Return the attitudes at the samples between two times of a phase."""
        time_s = np.arange(from_s, to_s - interval_s / 2, interval_s)
        return self.seen(phase.reference(Start((0.0, 0.0, 0.0), np.radians(self.yaw_deg)), time_s))

    def move_s(self, before: Sequence[float], after: Sequence[float]) -> float:
        """Return the time of a turn between two attitudes."""
        turns = (nearest(after[YAW] - before[YAW]), after[PITCH] - before[PITCH], after[ROLL] - before[ROLL])
        return max(LEAST_MOVE_S, PEAK * max(map(abs, turns)) / self.turning_deg_s)


class Held(Manoeuvre):
    """Manoeuvre of a vehicle that can hold any attitude; amounts in seconds."""

    path: ClassVar[type[PhaseBase]] = Poses
    least: ClassVar[float] = 0.0
    whole: ClassVar[bool] = False
    hastes: ClassVar[tuple[float, ...]] = (1.0, 1.5, 2.0)

    @property
    def ways(self) -> tuple[Held, ...]:
        """Return faster turns, which are less accurate."""
        return tuple(replace(self, turning_deg_s=haste * self.turning_deg_s) for haste in self.hastes)

    def within(self, tilts: Tilts) -> Held:
        """Return the manoeuvre unchanged."""
        return self

    def halves(self, attitudes: Rotation) -> tuple[Rotation, ...]:
        """Return the attitudes unchanged."""
        return (attitudes,)

    def phase(self, legs: Sequence[Leg]) -> Poses:
        """Return the phase with all attitudes in order, at the least turning times."""
        poses, before = [], (self.yaw_deg, 0.0, 0.0)
        for leg in legs:
            move_s = round(self.move_s(before, leg.angles_deg), 1)
            poses.append(_named(leg) | {"move_s": move_s, "hold_s": round(leg.amount, 1)})
            before = leg.angles_deg
        home_s = round(self.move_s(before, (before[YAW], 0.0, 0.0)), 1)
        return Poses.model_validate({"kind": "poses", "poses": poses, "home_s": home_s})

    def unit(self, leg: Leg) -> tuple[PhaseBase, float, float]:
        """Return a phase with one second of holding."""
        phase = self.phase([Leg(*leg.angles_deg, 1.0)])
        at_s = phase.poses[0].move_s
        return phase, at_s, at_s + 1.0

    def times_s(self, phase: Poses) -> list[tuple[float, float]]:
        """Return the holds."""
        ends = np.cumsum([pose.move_s + pose.hold_s for pose in phase.poses])
        return [(float(end - pose.hold_s), pose.hold_s) for end, pose in zip(ends, phase.poses, strict=True)]

    def seen(self, reference: Array) -> Rotation:
        """Return the commanded attitudes."""
        return Rotation.from_euler("ZYX", reference[:, 9:12])


class HandHeld(Held):
    """Manoeuvre of a person with the vehicle in the hands; each attitude held long enough to come to rest."""

    least: ClassVar[float] = 3.0
    hastes: ClassVar[tuple[float, ...]] = (1.0,)


@dataclass(frozen=True)
class Pushed(Manoeuvre):
    """Manoeuvre of a vehicle that tilts by thrust; amounts are pairs of opposite pushes."""

    push_s: float = PUSHES_S[0]
    switch_s: float = LEAST_SWITCH_S

    path: ClassVar[type[PhaseBase]] = Pushes
    least: ClassVar[float] = 1.0
    whole: ClassVar[bool] = True
    most_deg: ClassVar[float] = 45.0
    stays: ClassVar[bool] = True

    @property
    def ways(self) -> tuple[Pushed, ...]:
        """Return longer pushes: less time between tilts, but more space."""
        return tuple(replace(self, push_s=push_s) for push_s in PUSHES_S)

    def within(self, tilts: Tilts) -> Pushed:
        """Return the manoeuvre with slower changes between wide tilts, so that the vehicle can follow."""
        upright = float(np.prod(np.cos(np.radians([tilts.roll_deg, tilts.pitch_deg]))))
        most_m_s2 = GRAVITY_M_S2 * np.sqrt(1.0 - upright**2) / upright
        return replace(self, switch_s=max(LEAST_SWITCH_S, round(2.0 * PEAK * most_m_s2 / MOST_SLOPE_M_S3, 2)))

    def filling(self, legs: Sequence[Leg], time_s: float) -> Pushed:
        """Return the manoeuvre with pushes stretched to fill a time."""
        found, times = self, sum(round(leg.amount) for leg in legs)
        for _ in range(FILLINGS):
            more_s = (time_s - SPARE_S - found.phase(legs).duration_s) / (4.0 * times)
            found = replace(found, push_s=float(np.clip(found.push_s + more_s, self.push_s, MOST_PUSH_S)))
        return found if found.phase(legs).duration_s <= time_s else self

    def halves(self, attitudes: Rotation) -> tuple[Rotation, ...]:
        """Return the attitudes, and attitudes of opposite acceleration at equal heading."""
        up = attitudes.as_matrix()[:, :, 2] * np.array([-1.0, -1.0, 1.0])
        return attitudes, _level_but(up, attitudes.as_euler("ZYX")[:, YAW])

    def phase(self, legs: Sequence[Leg]) -> Pushes:
        """Return the phase with all attitudes in order, at the least turning times."""
        pushes, before = [], self.yaw_deg
        for leg in legs:
            turn_s = round(self.move_s((before, 0.0, 0.0), (leg.yaw_deg, 0.0, 0.0)), 1)
            pushes.append(_named(leg) | {"times": round(leg.amount), "turn_s": turn_s})
            before = leg.yaw_deg
        how = {"push_s": self.push_s, "switch_s": self.switch_s, "drag_1_m": self.drag_1_m, "run_in_s": RUN_IN_S}
        return Pushes.model_validate({"kind": "pushes", "pushes": pushes, **how})

    def unit(self, leg: Leg) -> tuple[PhaseBase, float, float]:
        """Return a phase, and the times from the middle of a push to the middle of the next but one."""
        phase = self.phase([Leg(*leg.angles_deg, 2.0)])
        at_s = phase.run_in_s + phase.turning_s(phase.pushes[0]) + 2.0 * phase.push_s
        return phase, at_s, at_s + 4.0 * phase.push_s

    def times_s(self, phase: Pushes) -> list[tuple[float, float]]:
        """Return the pushes, without preceding turns."""
        lengths = [phase.length_s(push) for push in phase.pushes]
        begins = phase.run_in_s + np.cumsum([0.0, *lengths[:-1]])
        turns = [phase.turning_s(push) for push in phase.pushes]
        return [(float(at + turn), length - turn) for at, turn, length in zip(begins, turns, lengths, strict=True)]

    def seen(self, reference: Array) -> Rotation:
        """Return attitudes with z along the specific force (acceleration, gravity, drag) and x on the heading."""
        speed = reference[:, 3:6]
        drag = self.drag_1_m * np.linalg.norm(speed, axis=1)[:, None] * speed
        return _level_but(reference[:, 6:9] + drag + np.array([0.0, 0.0, GRAVITY_M_S2]), reference[:, 9])


MANOEUVRES: tuple[type[Manoeuvre], ...] = (Held, Pushed)


def manoeuvre_of(vehicle: str, yaw_deg: float = 0.0) -> Manoeuvre:
    """Return the manoeuvre of a vehicle; InputError for a vehicle without any."""
    if vehicle not in VEHICLES:
        raise InputError(f"no vehicle is called {vehicle!r}", where="VEHICLE", do=closest(vehicle, VEHICLES))
    cls = VEHICLES[vehicle]
    for kind in MANOEUVRES:
        if cls.can(kind.path):
            return kind(cls.turning_deg_s, yaw_deg, cls.drag_1_m)
    names = [name for name, other in VEHICLES.items() if any(other.can(kind.path) for kind in MANOEUVRES)]
    raise InputError(f"{cls.noun} can neither hold nor sway", where="VEHICLE", do=f"choose from {', '.join(names)}")


def _named(leg: Leg) -> dict[str, Any]:
    return {"yaw_deg": leg.yaw_deg, "pitch_deg": leg.pitch_deg, "roll_deg": leg.roll_deg}


def _level_but(up: Array, yaw: Array) -> Rotation:
    """Return attitudes with headings yaw (n,) and z axes along up (n, 3)."""
    ahead, left = np.cos(yaw) * up[:, 0] + np.sin(yaw) * up[:, 1], np.cos(yaw) * up[:, 1] - np.sin(yaw) * up[:, 0]
    pitch = np.arctan2(ahead, up[:, 2])
    roll = np.arctan2(-left, np.hypot(ahead, up[:, 2]))
    return Rotation.from_euler("ZYX", np.column_stack([yaw, pitch, roll]))
