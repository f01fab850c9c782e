"""DataFlash logs as a test lays them out: bytes by ArduPilot's specification of the format, and a simulated flight."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from recordings import Recording
from scenarios.arrays import Array

CODES = {
    **{"b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d", "q": "q", "Q": "Q", "M": "B"},
    **{"n": "4s", "N": "16s", "Z": "64s", "c": "h", "C": "H", "e": "i", "E": "I", "L": "i"},
}
FIXED = {"c": 100, "C": 100, "e": 100, "E": 100, "L": 10_000_000}
"""Counts in a unit."""
HEAD = b"\xa3\x95"
DOWN = np.array([1.0, -1.0, -1.0])
START_S = 100.0


@dataclass
class Log:
    """Messages in the order of their times; a type is laid out by the first message of its name."""

    layouts: dict[str, tuple[int, str, str]] = field(default_factory=dict)
    messages: list[tuple[float, bytes]] = field(default_factory=list)

    def layout(self, name: str, form: str, columns: str) -> None:
        """Lay out a type, numbered from 130."""
        self.layouts[name] = (130 + len(self.layouts), form, columns)

    def add(self, name: str, time_s: float, *values: float | str) -> None:
        """Write a message; the time in the unit of the first column comes first, unless the type has no time."""
        number, form, columns = self.layouts[name]
        clock = columns.split(",")[0]
        timed = {"TimeUS": [round(time_s * 1e6)], "TimeMS": [round(time_s * 1e3)]}.get(clock, [])
        packed = [_packed(kind, value) for kind, value in zip(form, [*timed, *values], strict=True)]
        self.messages.append((time_s, HEAD + bytes([number]) + b"".join(packed)))

    def rows(self, name: str, times_s: Array, *columns: Array | float) -> None:
        """Write a message for each time."""
        full = np.broadcast_arrays(*columns, np.zeros(len(times_s)))[:-1]
        for time_s, *values in zip(times_s, *full, strict=True):
            self.add(name, float(time_s), *(float(value) for value in values))

    def parameters(self, time_s: float, **values: float) -> None:
        """Write PARM messages."""
        if "PARM" not in self.layouts:
            self.layout("PARM", "QNff", "TimeUS,Name,Value,Default")
        for name, value in values.items():
            self.add("PARM", time_s, name, value, 0.0)

    def data(self) -> bytes:
        """The whole log: the layouts, then the messages by time."""
        layouts = {"FMT": (0x80, "BBnNZ", "Type,Length,Name,Format,Columns")} | self.layouts
        heads = [
            HEAD
            + bytes([0x80])
            + struct.pack("<BB4s16s64s", number, 3 + _size(form), name.encode(), form.encode(), columns.encode())
            for name, (number, form, columns) in layouts.items()
        ]
        return b"".join([*heads, *(message for _, message in sorted(self.messages, key=lambda one: one[0]))])

    def write(self, path: Path) -> Path:
        """Write the log to a file."""
        path.write_bytes(self.data())
        return path


def _size(form: str) -> int:
    return struct.calcsize("<" + "".join(CODES[kind] for kind in form))


def _packed(kind: str, value: float | str) -> bytes:
    if isinstance(value, str):
        return struct.pack("<" + CODES[kind], value.encode())
    if kind in "fd":
        return struct.pack("<" + CODES[kind], value)
    return struct.pack("<" + CODES[kind], int(round(value * FIXED[kind]) if kind in FIXED else value))


def write_dataflash(recording: Recording, path: Path) -> None:
    """Write a recording as a log without parameters: the field cut to mG, the rest in single precision."""
    log, at_s = Log(), recording.time_s
    write_compass(log, at_s, recording.mag_nT)
    if recording.gyro_rad_s is not None and recording.accel_m_s2 is not None:
        warm = recording.temperature_degC if recording.temperature_degC is not None else 20.0
        log.layout("IMU", "QBfffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T")
        log.rows("IMU", at_s, 0, *(recording.gyro_rad_s * DOWN).T, *(recording.accel_m_s2 * DOWN).T, warm)
    if recording.att_q is not None:
        log.layout("XKQ", "QBffff", "TimeUS,C,Q1,Q2,Q3,Q4")
        log.rows("XKQ", at_s, 0, *ned_from_enu(recording.att_q).T)
    if recording.pos_enu_m is not None:
        east, north, up = recording.pos_enu_m.T
        log.layout("XKF1", "QBfff", "TimeUS,C,PN,PE,PD")
        log.rows("XKF1", at_s, 0, north, east, -up)
    if recording.current_A is not None:
        log.layout("ESC", "QBf", "TimeUS,Instance,Curr")
        for number, current_A in enumerate(recording.current_A.T):
            log.rows("ESC", at_s, number, current_A)
    log.write(path)


def write_compass(log: Log, at_s: Array, field_nT: Array, instance: int = 0, **more: Array | float) -> None:
    """Write MAG messages of a field (n, 3) in FLU: in FRD, cut toward zero to whole mG as C does."""
    if "MAG" not in log.layouts:
        log.layout("MAG", "QBhhhhhhhhhBI", "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S")
    whole = [np.trunc(np.broadcast_to(more.get(name, 0.0), (len(at_s), 3))).T for name in ("offset_mG", "motor_mG")]
    field_mG = np.trunc(field_nT * DOWN / 100)
    sampled_s = more.get("sampled_s", at_s)
    stamp = np.mod(np.round(np.asarray(sampled_s) * 1e6), 2.0**32)
    log.rows("MAG", at_s, instance, *field_mG.T, *whole[0], *whole[1], more.get("health", 1.0), stamp)


def product(p: Array, q: Array) -> Array:
    """Hamilton's product of quaternions w x y z, (..., 4)."""
    a, u, b, v = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    scalar = a * b - np.sum(u * v, axis=-1, keepdims=True)
    return np.concatenate([scalar, a * v + b * u + np.cross(u, v)], axis=-1)


def ned_from_enu(q: Array) -> Array:
    """FRD to NED of FLU to ENU (n, 4): half turns about the diagonal of north and east, and about the nose."""
    return product(product(np.array([0.0, 1.0, 1.0, 0.0]) / np.sqrt(2), q), np.array([0.0, 1.0, 0.0, 0.0]))


def rotated(q: Array, vectors: Array) -> Array:
    """Vectors (n, 3), or one, turned by unit quaternions (n, 4)."""
    pure = np.concatenate([np.zeros((*vectors.shape[:-1], 1)), vectors], axis=-1)
    return product(product(q, pure), q * np.array([1.0, -1.0, -1.0, -1.0]))[..., 1:]


@dataclass(frozen=True)
class Flight:
    """A body that turns about all axes in a uniform field: FLU, ENU, nT, rad/s."""

    time_s: Array
    q: Array
    rate_rad_s: Array
    field_nT: Array
    current_A: Array


FIELD_ENU = np.array([2000.0, 19_000.0, -45_000.0])


def flight(count: int = 400, interval_s: float = 0.1) -> Flight:
    """Yaw, pitch and roll swing at different rates; the rate follows from q* dq/dt = (0, omega / 2)."""
    time_s = START_S + interval_s * np.arange(count)
    step_s = 1e-4
    q, before, after = (_attitude(time_s + shift) for shift in (0.0, -step_s, step_s))
    rate = 2 * product(q * np.array([1.0, -1.0, -1.0, -1.0]), (after - before) / (2 * step_s))[:, 1:]
    inverse = q * np.array([1.0, -1.0, -1.0, -1.0])
    current = 8 + 6 * np.sin(0.9 * time_s)
    return Flight(time_s, q, rate, rotated(inverse, np.tile(FIELD_ENU, (count, 1))), current)


def _attitude(time_s: Array) -> Array:
    yaw, pitch, roll = 0.31 * time_s, 0.7 * np.sin(0.23 * time_s), 0.9 * np.sin(0.37 * time_s + 1)
    about_z, about_y, about_x = (
        np.column_stack([np.cos(angle / 2), *(np.sin(angle / 2) * unit for unit in axis)])
        for angle, axis in zip((yaw, pitch, roll), np.eye(3)[::-1], strict=True)
    )
    return product(product(about_z, about_y), about_x)
