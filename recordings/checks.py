"""The checks that every recording passes before anything is computed from its columns, whoever wrote the file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.columns import (
    ACCEL,
    ATTITUDE,
    GYRO,
    POSITION,
    TRUE_ATTITUDE,
    TRUE_FIELD,
    TRUE_POSITION,
    effect_names,
    group_of,
    is_truth,
    labelled_effects,
    mag_names,
    numbers,
)
from recordings.gaps import check_outage, filled, unit_quaternions
from recordings.importer import RawColumns
from recordings.likely_units import MOST_HARD_IRON_NT, SAMPLED, half_extent, in_earth
from recordings.streams import Interpolation
from recordings.units import likely_unit
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.text import figure

MIN_SAMPLES = 10
MIN_INTERVAL_S = 1e-9
"""No magnetometer is faster; smaller steps of time come from a wrong unit or from damage."""
FIELD_RANGE_NT = (1_000.0, 500_000.0)
Named = Mapping[str, NDArray[Any]]


def check_columns(raw: RawColumns) -> Named:
    """Return the columns with every cell filled; time must increase, the field be finite, vectors be complete.

    A column logged at a lower rate than the field, that is with empty cells between its values, is interpolated
    linearly in time (an attitude along the shorter arc) and held at the ends. In columns that a calibrator uses a gap
    may last MAX_GAP_INTERVALS of the column's own intervals; a longer gap is an outage and refused. A channel without
    any value counts as not measured. Rows are counted from 1, without the header.
    Raises InputError with file, column and row of the first violation.
    """
    path, named = raw.path, raw.named
    _check_length(path, len(named["time_s"]), 1)
    _check_time(path, named["time_s"])
    for name in (name for names in _sensors(named) for name in names):
        _check_finite(path, name, named[name])
    for names in (GYRO, ACCEL, ATTITUDE):
        _check_complete(path, named, names)
    return dict(_filled(path, named))


def check_field(raw: RawColumns, named: Named) -> Named:
    """Return the columns; InputError for too few samples, and for a field that is constant or cannot be in nT."""
    path = raw.path
    _check_length(path, len(named["time_s"]), MIN_SAMPLES)
    for names in _sensors(named):
        columns = [named[name] for name in names[: len(raw.origin.axes)]]
        _check_moving(path, names, columns)
        if raw.origin.unit == "nT":
            step = max(1, len(columns[0]) // SAMPLED)
            _check_strength(path, names, np.column_stack([column[::step] for column in columns]))
    return named


def check_truth(raw: RawColumns) -> Named:
    """Return all columns; InputError unless the truth, and the label of every effect, is complete and finite."""
    path, named = raw.path, raw.named
    sensors = numbers("mag", tuple(named)) or (None,)
    labels = (effect_names(effect, k) for effect in labelled_effects(tuple(named)) for k in sensors)
    truth = [*TRUE_FIELD, *TRUE_ATTITUDE, *TRUE_POSITION, *(name for label in labels for name in label)]
    missing = next((name for name in truth if name not in named), None)
    if missing is not None:
        what = f"holds no truth, or not all of it: there is no column {missing}"
        raise InputError(what, where=str(path), do="give a run that `magbench simulate` wrote")
    for name in truth:
        _check_finite(path, name, named[name])
    return named


def _sensors(named: Named) -> list[tuple[str, ...]]:
    """Return the three columns of every magnetometer."""
    return [mag_names(sensor) for sensor in numbers("mag", tuple(named)) or (None,)]


def _check_length(path: Path, samples: int, least: int) -> None:
    if samples < least:
        what = f"holds {samples} samples, at least {max(least, MIN_SAMPLES)} are needed"
        raise InputError(what, where=str(path), do="give a longer recording")


def _check_time(path: Path, time_s: Array) -> None:
    """Raise InputError for the first row whose time is not finite or does not increase."""
    _check_finite(path, "time_s", time_s)
    step = np.diff(time_s)
    wrong = np.flatnonzero(step < MIN_INTERVAL_S)
    if not len(wrong):
        return
    before, found = (float(time_s[row]) for row in (wrong[0], wrong[0] + 1))
    if found < before:
        what, do = f"goes back to {found!r}", "sort the rows by time, or give one recording a file"
    elif found == before:
        what, do = f"repeats the time {found!r}", "remove repeated rows, or give a time of higher resolution"
    else:
        what, do = f"comes {found - before:g} s after the last", "give the unit with --map time_s=<column>,unit=…"
    more = f", as do {len(wrong) - 1} more" if len(wrong) > 1 else ""
    raise InputError(f"row {wrong[0] + 2} {what}{more}", where=f"{path}: time_s", do=do)


def _check_complete(path: Path, named: Named, names: Sequence[str]) -> None:
    """Raise InputError unless a vector has all components or none."""
    missing = [name for name in names if name not in named]
    if missing and len(missing) < len(names):
        present = next(name for name in names if name in named)
        do = f"add it, name it with --map {missing[0]}=…, or rename {present} to keep it as a channel"
        raise InputError(f"there is no column {missing[0]} beside {present}", where=str(path), do=do)


def _check_finite(path: Path, name: str, values: Array) -> None:
    finite = np.isfinite(values)
    if not finite.all():
        wrong = ~finite
        count, row = int(np.count_nonzero(wrong)), int(np.argmax(wrong)) + 1
        kind = "infinite" if np.isinf(values[row - 1]) else "missing"
        what = f"{count} of {len(values)} values are missing or infinite, the first in row {row} is {kind}"
        raise InputError(what, where=f"{path}: {name}", do="remove these rows")


def _filled(path: Path, named: Named) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield every recorded column without an empty cell; the components of a complete vector are filled together."""
    recorded = {name: group_of(name) for name in named if not is_truth(name)}
    vectors = [names for names in (GYRO, ACCEL, ATTITUDE, POSITION) if all(name in recorded for name in names)]
    within = {name for names in vectors for name in names}
    for names in (*vectors, *((name,) for name in recorded if name not in within)):
        group = recorded[names[0]]
        if group == "phase":
            yield names[0], named[names[0]]
        elif group == "channel":
            yield from _filled_channel(named, names[0])
        else:
            yield from zip(names, _filled_vector(path, names, named, group == "attitude").T, strict=True)


def _filled_channel(named: Named, name: str) -> Iterator[tuple[str, Array]]:
    """Yield a channel without empty or infinite cells; a channel without any value is left out."""
    known = np.isfinite(named[name])
    if known.any():
        yield name, filled(named["time_s"], known, named[name][:, None])[:, 0]


def _filled_vector(path: Path, names: Sequence[str], named: Named, rotation: bool) -> Array:
    for name in names:
        if np.isinf(named[name]).any():
            _check_finite(path, name, named[name])
    values = np.column_stack([named[name] for name in names])
    known = np.asarray(np.isfinite(values).all(axis=1), np.bool_)
    if not known.any():
        where = f"{path}: {', '.join(names)}"
        raise InputError("no row has a value in every one of them", where=where, do="remove the columns")
    if rotation:
        values = unit_quaternions(path, names, values, known)
    check_outage(path, names[0], named["time_s"], known)
    return filled(named["time_s"], known, values, Interpolation.CHORD if rotation else Interpolation.LINEAR)


def _check_moving(path: Path, names: Sequence[str], columns: Sequence[Array]) -> None:
    stuck = [name for name, column in zip(names, columns, strict=False) if (column == column[0]).all()]
    if len(stuck) == len(columns):
        what, do = "all three axes are constant: the sensor did not measure or did not move", "give another recording"
        raise InputError(what, where=f"{path}: {', '.join(stuck)}", do=do)
    if stuck:
        what = f"is {columns[names.index(stuck[0])][0]:g} in every row: the axis is stuck"
        do = "check the sensor's axis, or map another column with --map"
        raise InputError(what, where=f"{path}: {stuck[0]}", do=do)


def _check_strength(path: Path, names: Sequence[str], some_nT: Array) -> None:
    strength = float(np.median(np.linalg.norm(some_nT, axis=1)))
    low, high = FIELD_RANGE_NT
    turned_nT = float(half_extent(some_nT).max())
    if low <= strength <= high or (strength < MOST_HARD_IRON_NT and in_earth(turned_nT)):
        return
    unit = likely_unit(strength)
    guess = f"it looks like {unit}" if unit else "it may be raw counts"
    option = f"unit={unit}" if unit else "scale=<nT a count>"
    what = f"median |m| is {figure(strength, 4)}, not between {low:.0f} and {high:.0f} nT: {guess}"
    do = f"give the unit with --map {names[0]}=<column>,{option} and the like for the other axes"
    raise InputError(what, where=f"{path}: {', '.join(names)}", do=do)
