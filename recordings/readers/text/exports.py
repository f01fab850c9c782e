"""A maker's table under a recording's names: units, frames, clocks that wrap, and the attitude where gravity agrees."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa

from recordings.body_frame import enu_from_ned, flu_from_frd
from recordings.column_words import ColumnName
from recordings.columns import SIGNAL
from recordings.decode import NotNumbersError, numbers_of
from recordings.readers.base import FileContents
from recordings.readers.navigation import enu_of_angles
from recordings.readers.quaternions import of_angles, of_matrices, product
from recordings.readers.text.makers import MAKERS, Maker, Three
from recordings.reading import COUNT
from recordings.units import UNITS
from scenarios.arrays import Array

Given = Mapping[str, str]
"""The file's names of columns by their bare names, see `_bare`."""
LEAST_UP = 0.9
"""Median cosine between up and the specific force in the world, below which an attitude means another turn."""
TICK_S, TICKS, PACKETS = 1e-4, 2.0**32, 2.0**16
"""Xsens' clock of 10 kHz, where the clock wraps, and where the counter of packets does."""
_RATE = re.compile(rb"Update Rate:\s*([\d.]+)\s*Hz")
_WORLD = re.compile(rb"Coordinate system:\s*(ENU|NED|NWU)")
_HALF = math.sqrt(0.5)
WORLDS = {b"ENU": (1.0, 0.0, 0.0, 0.0), b"NED": (0.0, _HALF, _HALF, 0.0), b"NWU": (_HALF, 0.0, 0.0, _HALF)}
"""Turns to east, north, up, w x y z."""
_DOT = re.compile(rb"^(sep=.\s+)?DeviceTag:", re.IGNORECASE)
DOT_TICK_S, DOT_RATE, DOT_Q = 1e-6, "deg/s", ("quat_w", "quat_x", "quat_y", "quat_z")
"""Of Xsens DOT, otherwise than of MT Manager: a tick of the clock, the unit of the rate, and the quaternion."""
MATRIX = tuple(f"mat[{row}][{column}]" for row in (1, 2, 3) for column in (1, 2, 3))


def as_exported(contents: FileContents, head: bytes) -> FileContents:
    """Return a table under a recording's names, turned, where a maker's columns are there; else as it is.

    head : the first bytes of the file, whose comments tell Xsens' rate and world.
    """
    table = contents.table
    given = {_bare(name): name for name in reversed(table.column_names)}
    maker = next((one for one in MAKERS if any(mark <= given.keys() for mark in one.mark)), None)
    if maker is None or (maker.name == "SBG" and _unit(table, given["magx"]).replace(".", "") != "au"):
        return contents
    with np.errstate(over="ignore", invalid="ignore"):  # damaged cells: what is not finite is screened later
        return _Export(maker, table, given, head).contents(contents)


def _bare(name: str) -> str:
    """Return a name in lower case without units, blanks, the node or group before it, and signs at a component.

    `ImuGroup.UncompMag[0]` and `UncompMag.x` are uncompmagx, `6253.4220:scaledMagX` is scaledmagx.
    """
    bare = re.sub(r"\(.*?\)|\[[^\]]*[a-z/][^\]]*\]|\s", "", name.lower())
    bare = re.sub(r"^\w*group\.|^.*:(?=scaled)|yawpitchroll\.", "", bare)
    component = re.fullmatch(r"((?:uncomp)?(?:mag|accel?|gyro)|angularrate)(?:\.([xyz])|\[([012])\])", bare)
    return component[1] + (component[2] or "xyz"[int(component[3])]) if component else bare


def _unit(table: pa.Table, name: str) -> str:
    return ((table.schema.field(name).metadata or {}).get(b"unit") or b"").decode()


@dataclass(frozen=True)
class _Export:
    """A maker's table while its columns become a recording's."""

    maker: Maker
    table: pa.Table
    given: Given
    head: bytes

    def contents(self, contents: FileContents) -> FileContents:
        """Return the columns of the recording, then every other column as it was."""
        maker, found = self.maker, self._columns()
        if not found:
            return contents
        taken = {self.given[name] for name in self._taken() if name in self.given} | found.keys()
        arrays = {name: pa.array(values, from_pandas=True) for name, values in found.items()}
        rest = {name: self.table.column(name) for name in self.table.column_names if name not in taken}
        turned = "axes turned from forward, right, down" if maker.down else "the unit's axes as logged"
        return replace(
            contents,
            tables={"": pa.table({**arrays, **rest})},
            notes=(*contents.notes, f"{maker.name}'s export: {maker.note}; {turned}", *self._told(found)),
            frame="frd" if maker.down else "",
            unit=COUNT if maker.unit == COUNT else "nT",
        )

    def _columns(self) -> dict[str, Array]:
        """Return the columns of the recording; empty where the magnetometer's are words."""
        maker = self.maker
        mag = self._vector("mag", maker.mag, maker.unit)
        gyro = self._vector("gyro", maker.gyro, DOT_RATE if self._is_dot else maker.gyro_unit)
        accel = self._vector("accel", maker.accel, maker.accel_unit)
        accel = -accel if accel is not None and maker.upside_down else accel
        groups = {"mag": mag, "gyro": gyro, "accel": accel, "attitude": self._attitude(accel)}
        time = self._time()
        found: dict[str, Array] = {} if time is None else {"time_s": time}
        for group, values in groups.items():
            found |= {} if values is None else dict(zip(SIGNAL[group].names(), values.T, strict=True))
        return found if mag is not None else {}

    def _numbers(self, name: str) -> Array | None:
        try:
            return numbers_of(self.table.column(self.given[name])) if name in self.given else None
        except (NotNumbersError, pa.ArrowException):
            return None

    def _block(self, names: tuple[str, ...]) -> Array | None:
        columns = [self._numbers(name) for name in names]
        known = [column for column in columns if column is not None]
        return np.column_stack(known) if names and len(known) == len(names) else None

    def _vector(self, kind: str, forms: tuple[Three, ...], unit: str) -> Array | None:
        """Return the first vector (n, 3) that is there, in a recording's unit, forward, left, up."""
        for names in forms:
            block = self._block(names)
            if block is not None:
                told = ColumnName(self.given[names[0]]).unit(kind) or unit
                factor = UNITS[kind].get(told, (1.0, 0.0))[0]
                return factor * (flu_from_frd(block) if self.maker.down else block)
        return None

    def _attitude(self, accel: Array | None) -> Array | None:
        """Return the attitude, FLU in ENU, where the maker's convention lifts the specific force up."""
        found = self._down() if self.maker.down else self._up()
        return found if found is not None and accel is not None and _cosine_up(found, accel) > LEAST_UP else None

    @property
    def _is_dot(self) -> bool:
        return bool(_DOT.match(self.head))

    def _angles(self) -> Array | None:
        """Return roll, pitch, yaw (n, 3) in rad."""
        kinds = ((self.maker.angles, np.pi / 180), (self.maker.radians, 1.0))
        blocks = ((self._block(names), unit) for forms, unit in kinds for names in forms)
        return next((unit * block for block, unit in blocks if block is not None), None)

    def _down(self) -> Array | None:
        """Return the attitude of angles, or of a quaternion, of FRD in NED."""
        angles, q = self._angles(), self._block(self.maker.quaternion)
        return enu_of_angles(*angles.T) if angles is not None else None if q is None else enu_from_ned(q)

    def _up(self) -> Array | None:
        """Return the attitude of a quaternion, of angles Rz(yaw) Ry(pitch) Rx(roll) or of a matrix in a stated world.

        Xsens DOT states none: east, north, up is its only world.
        """
        stated = _WORLD.search(self.head)
        world = WORLDS[stated[1] if stated else b"ENU"]
        if not stated and not self._is_dot:
            return None
        found = next((q for names in (self.maker.quaternion, DOT_Q) if (q := self._block(names)) is not None), None)
        angles, matrix = self._angles(), self._block(MATRIX)
        if found is None and angles is not None:
            found = of_angles(angles)
        if found is None and matrix is not None:
            found = of_matrices(matrix.reshape(-1, 3, 3))
        return None if found is None else product(np.array(world), found)

    def _time(self) -> Array | None:
        """Return the times in s, of Xsens from its clock or else its counter and rate; None without any."""
        for name, unit in self.maker.times.items():
            stamps = self._numbers(name)
            if stamps is not None:
                return stamps * UNITS["time"][ColumnName(self.given[name]).unit("time") or unit][0]
        return self._counted()

    def _counted(self) -> Array | None:
        """Return the times of Xsens' clock, else of its counter of packets and the rate that is told."""
        ticks, rate = self._numbers("sampletimefine"), _RATE.search(self.head)
        if ticks is not None and np.isfinite(ticks).all():
            return _unwrapped(ticks, TICKS) * (DOT_TICK_S if self._is_dot else TICK_S)
        packets = self._numbers("packetcounter")
        if packets is None or rate is None or not np.isfinite(packets).all():
            return None
        return _unwrapped(packets, PACKETS) / max(float(rate[1].decode().strip(".") or 1), 1e-3)

    def _taken(self) -> set[str]:
        """Return the bare names of the columns that stand for the recording's."""
        used = (self.maker.mag, self.maker.gyro, self.maker.accel)
        vectors = [next((names for names in forms if names[0] in self.given), ()) for forms in used]
        return {name for names in vectors for name in names} | {*self.maker.times, "sampletimefine"}

    def _told(self, found: Mapping[str, Array]) -> tuple[str, ...]:
        forms = (*self.maker.angles, *self.maker.radians, self.maker.quaternion, DOT_Q, MATRIX)
        logged = any(set(names) <= self.given.keys() for names in forms if names)
        if "att_qw" in found:
            return ("the attitude takes its heading from this same magnetometer unless GNSS gave it",)
        return ("the attitude has no known world, or does not lift gravity up: left as channels",) if logged else ()


def _cosine_up(q: Array, accel: Array) -> float:
    """Return the median cosine between up and the specific force (n, 3) turned by quaternions, body to world."""
    w, x, y, z = q.T
    up = np.column_stack([2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z])
    size = np.linalg.norm(up, axis=1) * np.linalg.norm(accel, axis=1)
    cosine = np.sum(up * accel, axis=1) / np.maximum(size, 1e-9)
    finite = cosine[np.isfinite(cosine)]
    return float(np.median(finite)) if len(finite) else 0.0


def _unwrapped(counts: Array, period: float) -> Array:
    """Return a counter that wraps at a period, continued: a step back by more than half is a turn."""
    turns = np.cumsum(np.diff(counts, prepend=counts[:1]) < -period / 2)
    return np.asarray(counts + period * turns)
