"""Tables that the makers of inertial units export, with the units and frames that their formats fix."""

from __future__ import annotations

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
from recordings.reading import COUNT
from recordings.units import UNITS
from scenarios.arrays import Array

Three = tuple[str, str, str]
Given = Mapping[str, str]
"""The file's names of columns by their bare names: lower case, without blanks and brackets."""
LEAST_UP = 0.9
"""Median cosine between up and the specific force in the world, below which an attitude means another turn."""
TICK_S, TICKS, PACKETS = 1e-4, 2.0**32, 2.0**16
"""Xsens' clock of 10 kHz, where the clock wraps, and where the counter of packets does."""
_RATE = re.compile(rb"Update Rate:\s*([\d.]+)\s*Hz")
_ENU = re.compile(rb"Coordinate system:\s*ENU")


@dataclass(frozen=True)
class Maker:
    """A maker's export: bare names of columns, of which the first vector that is there counts.

    mark : one of these sets of columns is there. unit : of the magnetometer where its columns tell none. gyro, accel :
    vectors and their unit. angles : roll, pitch, yaw in degrees, FRD in NED. quaternion : w x y z. down : whether the
    axes are forward, right, down. times : columns of time and the unit of each.
    """

    name: str
    mark: tuple[frozenset[str], ...]
    mag: tuple[Three, ...]
    unit: str
    gyro: tuple[Three, ...]
    gyro_unit: str
    accel: tuple[Three, ...]
    accel_unit: str
    times: Mapping[str, str]
    down: bool
    angles: tuple[Three, ...] = ()
    quaternion: tuple[str, ...] = ()
    note: str = ""


def _three(*forms: str) -> tuple[Three, ...]:
    return tuple((form.format("x"), form.format("y"), form.format("z")) for form in forms)


MAKERS = (
    Maker(
        name="Xsens",
        mark=(frozenset({"packetcounter", "mag_x"}),),
        mag=_three("mag_{}"),
        unit=COUNT,
        gyro=_three("gyr_{}"),
        gyro_unit="rad/s",
        accel=_three("acc_{}"),
        accel_unit="m/s^2",
        times={},
        down=False,
        quaternion=("quat_q0", "quat_q1", "quat_q2", "quat_q3"),
        note="the magnetometer is in units of the field at the factory: the gain is not known",
    ),
    Maker(
        name="VectorNav",
        mark=(frozenset({"uncompmagx"}), frozenset({"magx", "accelx", "angularratex"})),
        mag=_three("uncompmag{}", "mag{}"),
        unit="G",
        gyro=_three("angularrate{}", "uncompgyro{}", "gyro{}"),
        gyro_unit="rad/s",
        accel=_three("accel{}", "uncompaccel{}", "uncompacc{}", "acc{}"),
        accel_unit="m/s^2",
        times={"timestartup": "ns", "time": "s"},
        down=True,
        angles=(("roll", "pitch", "yaw"),),
        note="the uncompensated magnetometer first: without it the unit's own calibration is in the field",
    ),
    Maker(
        name="SBG",
        mark=(frozenset({"magx", "accelx", "status"}),),
        mag=_three("mag{}"),
        unit=COUNT,
        gyro=_three("gyro{}"),
        gyro_unit="deg/s",
        accel=_three("accel{}"),
        accel_unit="m/s^2",
        times={"timestamp": "us"},
        down=True,
        angles=(("roll", "pitch", "yaw"),),
        note="the magnetometer is in arbitrary units, with the unit's own calibration",
    ),
    Maker(
        name="DJI",
        mark=(frozenset({"imu_atti:magx"}), frozenset({"imu_atti:mag:x"})),
        mag=_three("imu_atti:mag{}", "imu_atti:mag:{}"),
        unit=COUNT,
        gyro=_three("imu_atti:gyro{}", "imu_atti:gyro:{}"),
        gyro_unit="deg/s",
        accel=_three("imu_atti:accel{}", "imu_atti:accel:{}"),
        accel_unit="g",
        times={"clock:offsettime": "s", "offsettime": "s"},
        down=True,
        quaternion=tuple(f"imu_atti:quat{part}" for part in "wxyz"),
        note="the unit of the magnetometer is not agreed on: read as counts",
    ),
)
"""Frames and units of the tables of MT Manager, VectorNav's SDK, sbgBasicLogger and DatCon."""


def as_exported(contents: FileContents, head: bytes) -> FileContents:
    """Return a table under a recording's names, turned, where a maker's columns are there; else as it is.

    head : the first bytes of the file, whose comments tell Xsens' rate and world.
    """
    table = contents.table
    given = {_bare(name): name for name in reversed(table.column_names)}
    maker = next((one for one in MAKERS if any(mark <= given.keys() for mark in one.mark)), None)
    if maker is None or (maker.name == "SBG" and _unit(table, given["magx"]) != "au"):
        return contents
    with np.errstate(over="ignore", invalid="ignore"):  # damaged cells: what is not finite is screened later
        return _Export(maker, table, given, head).contents(contents)


def _bare(name: str) -> str:
    return re.sub(r"\(.*?\)|\[[^\]]*[a-z/][^\]]*\]|\s", "", name.lower())


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
        gyro = self._vector("gyro", maker.gyro, maker.gyro_unit)
        accel = self._vector("accel", maker.accel, maker.accel_unit)
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
        angles = next((block for names in self.maker.angles if (block := self._block(names)) is not None), None)
        q = self._block(self.maker.quaternion)
        if angles is not None:
            found = enu_of_angles(*np.radians(angles).T)
        elif q is None or not (self.maker.down or _ENU.search(self.head)):
            return None
        else:
            found = enu_from_ned(q) if self.maker.down else q
        return found if accel is not None and _cosine_up(found, accel) > LEAST_UP else None

    def _time(self) -> Array | None:
        """Return the times in s, of Xsens from its clock or else its counter and rate; None without any."""
        for name, unit in self.maker.times.items():
            stamps = self._numbers(name)
            if stamps is not None:
                return stamps * UNITS["time"][ColumnName(self.given[name]).unit("time") or unit][0]
        ticks, rate = self._numbers("sampletimefine"), _RATE.search(self.head)
        if ticks is not None and np.isfinite(ticks).all():
            return _unwrapped(ticks, TICKS) * TICK_S
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
        angles = any(set(names) <= self.given.keys() for names in self.maker.angles)
        logged = angles or (bool(self.maker.quaternion) and set(self.maker.quaternion) <= self.given.keys())
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
