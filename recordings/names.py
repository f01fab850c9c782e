"""The columns of a foreign log by their names: time, magnetometer, gyro, accelerometer, attitude, temperature."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import pyarrow as pa

from recordings.channels import TEMPERATURE
from recordings.column_words import DERIVED, FILLERS, NO_MEASUREMENT, RAW, SPELT, TIMES, WORDS, ColumnName
from recordings.columns import ACCEL, ATTITUDE, GYRO, SIGNAL, group_of, mag_names
from recordings.reading import Reading
from recordings.units import UNITS, ColumnMap
from scenarios.errors import InputError

VECTORS: dict[str, tuple[str, ...]] = {"accel": ACCEL, "gyro": GYRO, "mag": mag_names()}
KINDS_IN_ORDER = (*VECTORS, "attitude", "temperature")
"""What is looked for; the magnetometer after the other vectors: a bare x, y, z is the magnetometer's."""
RISING = 0.99
"""Share of steps ahead above which the first of four columns without names is the time."""
LAST_WORDS = ("stamp", "timestamp", "time")
"""Last words of a column of time, as `header.stamp`."""
STAMPS = ("timestamp", "elapsed")
"""Words of a column of time anywhere in its name, as `Shimmer_Timestamp_Unix_CAL`."""
_BARE = re.compile(r"column_\d+")


@dataclass(frozen=True)
class NamedVector:
    """Columns that may be a vector: the other words of their names, and the columns by component."""

    words: frozenset[str]
    columns: Mapping[str, str]

    @property
    def rank(self) -> int:
        """Raw before plain before corrected values."""
        return 0 if self.words & RAW else 2 if self.words & DERIVED else 1

    @property
    def parts(self) -> str:
        """The components, "xyz" where all are there."""
        return "".join(self.columns)


def guessed_maps(table: pa.Table, maps: Sequence[ColumnMap]) -> tuple[ColumnMap, ...]:
    """Return the columns that a log's names suggest beside those that are mapped or have a recording's names.

    Units are those of the names or of the file; None where they say nothing. Beside a magnetometer under a recording's
    names no more than the time is looked for. Raises InputError where two magnetometers are as likely.
    """
    own = {group_of(name) for name in _unmapped(table, maps)} & SIGNAL.keys()
    known = own | {group_of(one.target) for one in maps}
    found = () if "time" in known else _time(table, _unmapped(table, maps))
    for kind in KINDS_IN_ORDER if "mag" not in own else ():
        names = [name for name in _unmapped(table, (*maps, *found)) if _is_free(table, name)]
        found += () if kind in known else _of_kind(kind, table, names)
    return found


def _unmapped(table: pa.Table, maps: Sequence[ColumnMap]) -> list[str]:
    mapped = {one.source for one in maps}
    return [name for name in table.column_names if name not in mapped]


def _is_free(table: pa.Table, name: str) -> bool:
    """Return whether a column is of numbers and has no name of a recording's."""
    return group_of(name) == "channel" and _is_number(table.column(name).type)


def _of_kind(kind: str, table: pa.Table, names: Sequence[str]) -> tuple[ColumnMap, ...]:
    """Return the maps of one quantity, () for none."""
    if kind == "attitude":
        return _attitude(names)
    if kind == "temperature":
        return _temperature(table, names)
    targets = dict(zip("xyz", VECTORS[kind], strict=True))
    return tuple(
        ColumnMap(targets[part], name, _unit(table, name, kind)) for part, name in _vector(kind, names).items()
    )


def stated_maps(table: pa.Table, reading: Reading) -> tuple[ColumnMap, ...]:
    """Return the stated maps; columns of `mag` without a stated unit take that of their name."""
    named = () if reading.unit is not None else reading.mag
    return tuple(
        replace(one, unit=_unit(table, one.source, "mag"))
        if one.source in named and one.source in table.column_names
        else one
        for one in reading.column_maps
    )


def _is_number(kind: pa.DataType) -> bool:
    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind))


def _unit(table: pa.Table, name: str, kind: str) -> str | None:
    """Return the unit of a column, from the file's row of units or the column's name."""
    stated = ((table.schema.field(name).metadata or {}).get(b"unit") or b"").decode().strip()
    own = SPELT[kind].get(stated.lower()) or (stated if stated in UNITS[kind] else None)
    return own or ColumnName(name).unit(kind)


def _time(table: pa.Table, names: Iterable[str]) -> tuple[ColumnMap, ...]:
    """Return the map of the column of time: stamps, the best word of TIMES, or the first of four rising columns."""
    found = {name: rank for name in names if (rank := _time_rank(table, name)) is not None}
    if found:
        best = min(found, key=lambda name: found[name])
        return (ColumnMap("time_s", best, None if found[best] < 0 else _unit(table, best, "time")),)
    bare = [name for name in table.column_names if _BARE.fullmatch(name)]
    return (ColumnMap("time_s", bare[0]),) if len(bare) == 4 and _rises(table.column(bare[0])) else ()


def _time_rank(table: pa.Table, name: str) -> int | None:
    """Return how likely a column is the time, the likeliest -1; None for another column."""
    kind, parts = table.column(name).type, ColumnName(name.rpartition(".")[2] or name)
    if pa.types.is_timestamp(kind):
        return -1
    whole = "_".join(parts.plain or parts.words)
    if not _is_number(kind) or not parts.words:
        return None
    if whole in TIMES:
        return TIMES.index(whole)
    if parts.words[0] in TIMES[:4] or parts.words[-1] in LAST_WORDS:
        return len(TIMES)
    return len(TIMES) + 1 if set(STAMPS) & set(parts.words) else None


def _rises(column: pa.ChunkedArray) -> bool:
    values = column.to_numpy()
    return bool(_is_number(column.type) and len(values) > 1 and (values[1:] >= values[:-1]).mean() > RISING)


def _vector(kind: str, names: Sequence[str]) -> Mapping[str, str]:
    """Return the columns of a vector by component, of a magnetometer also x and y alone; empty for none."""
    found = _named_vectors(kind, names)
    whole = [one for one in found if one.parts == "xyz"]
    if kind != "mag":
        return whole[0].columns if whole else {}
    whole = whole or [one for one in found if one.parts == "xy"]
    best = min((one.rank for one in whole), default=0)
    likely = [one for one in whole if one.rank == best]
    if len(likely) > 1:
        raise _several(likely)
    return likely[0].columns if likely else _unnamed(names)


def _unnamed(names: Sequence[str]) -> dict[str, str]:
    """Return two or three columns without names, or the only vector, as x, y and z where there are no others."""
    parts = [ColumnName(name).component("xyz") for name in names]
    rests = {part[1] for part in parts if part is not None}
    if None not in parts and len(parts) == 3 and len(rests) == 1 and not next(iter(rests)) & {*WORDS, *NO_MEASUREMENT}:
        return {part[0]: name for part, name in zip(parts, names, strict=True) if part is not None}
    bare = [name for name in names if _BARE.fullmatch(name)]
    return dict(zip("xyz", bare, strict=False)) if len(bare) == len(names) in (2, 3) else {}


def _named_vectors(kind: str, names: Sequence[str]) -> list[NamedVector]:
    """Return the vectors of a kind whose columns share all words but the component; those named by kind, if any."""
    groups: dict[frozenset[str], dict[str, str]] = {}
    for name in names:
        found = ColumnName(name).component("xyz")
        if found is not None and _is_of(kind, found[1]):
            groups.setdefault(found[1], {}).setdefault(found[0], name)
    vectors = [
        NamedVector(words, {part: columns[part] for part in "xyz" if part in columns})
        for words, columns in groups.items()
    ]
    named = [one for one in vectors if one.words & WORDS.keys() and len(one.columns) > 1]
    return named or vectors


def _is_of(kind: str, words: frozenset[str]) -> bool:
    """Return whether the words beside a component are of a kind; a magnetometer's may say nothing."""
    if words & NO_MEASUREMENT:
        return False
    kinds = {WORDS[word] for word in words & WORDS.keys()}
    kinds -= {"mag"} if words & {"rate", "rotation"} else set()
    return kinds == {kind} or (kind == "mag" and not kinds and words <= FILLERS | RAW | DERIVED)


def _several(likely: Sequence[NamedVector]) -> InputError:
    listed = [",".join(one.columns.values()) for one in likely]
    what = f"there are {len(likely)} magnetometers: {'; '.join(listed[:6])}"
    return InputError(what, do=f"choose one, as --mag {listed[0]}")


def _attitude(names: Sequence[str]) -> tuple[ColumnMap, ...]:
    """Return the maps of a quaternion w x y z: qw qx qy qz, quat_w ..., or q0 q1 q2 q3 with w first."""
    found: dict[str, str] = {}
    for name in names:
        words = ColumnName(name).words
        numbered = re.fullmatch(r"(?:.*_)?q_?([0-3])", "_".join(words))
        part = ColumnName(name).component("wxyz")
        if numbered:
            found.setdefault("wxyz"[int(numbered[1])], name)
        elif part is not None and part[1] & {"q", "quat", "quaternion", "orientation"}:
            found.setdefault(part[0], name)
    if set(found) != set("wxyz"):
        return ()
    return tuple(ColumnMap(target, found[part]) for target, part in zip(ATTITUDE, "wxyz", strict=True))


def _temperature(table: pa.Table, names: Sequence[str]) -> tuple[ColumnMap, ...]:
    words = {name: ColumnName(name).words for name in names}
    found = [name for name, own in words.items() if own and own[0] in ("temp", "temperature", "degc") and len(own) < 4]
    if len(found) != 1:
        return ()
    return (ColumnMap(TEMPERATURE, found[0], _unit(table, found[0], "temperature")),)
