"""How a log is to be read: columns, unit, axes, frame, place and date, as stated by the user or kept beside the log."""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Self

from recordings.columns import mag_names
from recordings.files import write_text
from recordings.units import UNITS, ColumnMap, parse_maps
from scenarios.errors import InputError
from scenarios.files import read_text
from scenarios.nesting import parsed_toml

FRAMES = ("flu", "frd")
"""Body frames: x forward, y left, z up, the recording's own; x forward, y right, z down."""
KEPT = ".magbench.toml"
"""The end of the name of the file in which the options of a log are kept."""
_listener: ContextVar[Callable[[str], object] | None] = ContextVar("listener", default=None)


@dataclass(frozen=True)
class Reading:
    """What is stated of a log; what is not stated is guessed from names and values.

    Parameters
    ----------
    maps : `mag_x_nT=bx,unit=uT[,scale=F]` texts, one a column, see `recordings.units.parse_maps`.
    mag : the three columns of the magnetometer, x, y and z, or two, x and y; a list, or a text with commas.
    unit : of these columns, or of the columns that were guessed: nT, uT, mG, G, ..., or `count` for raw counts.
    axes : the log's axes that form x, y and z of the body, as "y,x,-z" or a list; of the magnetometer alone.
    frame : the body frame of magnetometer, gyro and accelerometer in the log: "flu", or "frd", which is turned.
    place : latitude and longitude in degrees, and the altitude in m; date : of the log, "2024-05-01".
    stream : the word that marks the magnetometer's rows in a log of several sensors.
    """

    maps: tuple[str, ...] = ()
    mag: tuple[str, ...] = ()
    unit: str | None = None
    axes: str | Sequence[str] | None = None
    frame: str | None = None
    place: tuple[float, ...] | None = None
    date: datetime.date | None = None
    stream: str | None = None

    def __post_init__(self) -> None:
        """Take texts apart; raises InputError for what cannot be."""
        own = {"maps": _texts(self.maps), "mag": _texts(self.mag), "place": _place(self.place)}
        for name, value in (own | {"date": _date(self.date), "axes": _axes(self.axes)}).items():
            object.__setattr__(self, name, value)
        if len(self.mag) not in (0, 2, 3):
            raise InputError(f"{len(self.mag)} columns", where="--mag", do="give three, x,y,z, or two, x,y")
        if self.unit is not None and self.unit not in (*UNITS["mag"], COUNT):
            do = f"choose among {', '.join((*UNITS['mag'], COUNT))}"
            raise InputError(f"{self.unit!r} is no unit of a field", where="--unit", do=do)
        if not isinstance(self.stream, str | None):
            raise InputError(f"{self.stream!r} is no word", where="--stream", do="give the word of the sensor's rows")
        if self.frame is not None and self.frame not in FRAMES:
            raise InputError(f"{self.frame!r} is no frame", where="--frame", do=f"choose among {', '.join(FRAMES)}")
        if self.axes is not None:
            turned_axes(str(self.axes))

    def __bool__(self) -> bool:
        return self != Reading()

    @classmethod
    def of(cls, maps: Sequence[str] = (), reading: Self | None = None) -> Self:
        """Return the reading with further maps."""
        own = reading or cls()
        return replace(own, maps=(*own.maps, *_texts(maps)))

    @classmethod
    def for_file(cls, path: Path, maps: Sequence[str] = (), reading: Self | None = None) -> Self:
        """Return what is stated of a log, else what is kept beside the file."""
        stated = cls.of(maps, reading)
        return stated or cls.kept_beside(path) or stated

    @property
    def column_maps(self) -> tuple[ColumnMap, ...]:
        """The maps, those of `mag` included; InputError for a column that both give."""
        unit = "" if self.unit in (None, COUNT) else f",unit={self.unit}"
        own = (f"{target}={name}{unit}" for target, name in zip(mag_names(), self.mag, strict=False))
        return parse_maps((*self.maps, *own))

    @property
    def stated(self) -> dict[str, str]:
        """The options of the command line that state the reading."""
        given = {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) not in (None, ())}
        return {"--map" if name == "maps" else f"--{name}": _as_text(value) for name, value in given.items()}

    @classmethod
    def kept_beside(cls, path: Path) -> Self | None:
        """Return what is kept beside a log; None where nothing is, InputError for a damaged file."""
        file = kept_file(path)
        if not file.is_file():
            return None
        do = "correct or remove it"
        try:
            found = cls(**parsed_toml(read_text(file, do), KEPT, do))
        except (TypeError, ValueError, InputError) as error:
            raise InputError(f"cannot be used: {error}", where=str(file), do=do) from None
        report(f"read as kept in {file.name}: {_listed(found)} (--forget removes it)")
        return found

    def keep(self, path: Path) -> bool:
        """Write the reading beside a log; returns whether the folder allowed that."""
        own = [(f.name, getattr(self, f.name)) for f in fields(self)]
        text = "".join(f"{name} = {_as_toml(value)}\n" for name, value in own if value not in (None, ()))
        try:
            write_text(kept_file(path), f"# How {path.name} is read; written by magbench.\n{text}")
        except InputError:
            return False
        return True


COUNT = "count"
"""The unit of raw counts: the gain is not known."""


def kept_file(path: Path) -> Path:
    """Return the file in which the options of a log are kept."""
    return path.with_name(path.name + KEPT)


def turned_axes(text: str) -> tuple[tuple[int, float], ...]:
    """Return (axis of the log, sign) for x, y and z of the body; InputError unless each axis is used once."""
    signed = [re.fullmatch(r"\s*([+-]?)([xyz])\s*", word.lower()) for word in text.split(",")]
    found = [("xyz".index(one[2]), -1.0 if one[1] == "-" else 1.0) for one in signed if one]
    if len(signed) != 3 or sorted(axis for axis, _ in found) != [0, 1, 2]:
        do = "name the log's axes that form x, y and z of the body, as y,x,-z"
        raise InputError(f"{text!r} does not name each axis once", where="--axes", do=do)
    return tuple(found)


@contextmanager
def listening(listener: Callable[[str], object]) -> Iterator[None]:
    """Within, `listener` is told how each log is read, each line once."""
    told: set[str] = set()

    def once(line: str) -> None:
        if line not in told:
            told.add(line)
            listener(line)

    token = _listener.set(once)
    try:
        yield
    finally:
        _listener.reset(token)


def report(*lines: str) -> None:
    """Tell who listens, if anybody does."""
    listener = _listener.get()
    if listener is not None:
        for line in lines:
            listener(line)


def _texts(value: str | Sequence[str]) -> tuple[str, ...]:
    names = value.split(",") if isinstance(value, str) else tuple(value)
    if not all(isinstance(name, str) for name in names):
        raise InputError(f"{value!r} holds what is no name", where="columns", do="give names as texts")
    return tuple(name.strip() for name in names)


def _axes(value: object) -> str | None:
    if isinstance(value, list | tuple):
        return ",".join(map(str, value))
    return None if value is None else str(value)


def _place(value: str | Sequence[float] | None) -> tuple[float, ...] | None:
    if value is None:
        return None
    parts = value.split(",") if isinstance(value, str) else value
    do = "give latitude and longitude in degrees, and if known the altitude in m: 47.37,8.54,400"
    try:
        numbers = tuple(float(part) for part in parts)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{value!r} is no place", where="--place", do=do) from None
    inside = len(numbers) in (2, 3) and abs(numbers[0]) <= 90 and -180 <= numbers[1] <= 360
    if not inside or (len(numbers) == 3 and not -12_000 <= numbers[2] <= 600_000):
        raise InputError(f"{value!r} is no place", where="--place", do=do)
    return numbers


def _date(value: str | datetime.date | None) -> datetime.date | None:
    if value is None or isinstance(value, datetime.date):
        return value.date() if isinstance(value, datetime.datetime) else value
    try:
        return datetime.date.fromisoformat(value)
    except (TypeError, ValueError):
        raise InputError(f"{value!r} is no date", where="--date", do="write it as 2024-05-01") from None


def _as_text(value: Any) -> str:
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _as_toml(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_as_toml, value))}]"
    if isinstance(value, float | datetime.date):
        return str(value)
    escaped = str(value).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _listed(reading: Reading) -> str:
    return " ".join(f"{option} {value}" for option, value in reading.stated.items())
