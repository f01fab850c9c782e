"""The one table of columns: name, unit, meaning and group of everything a file holds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import pyarrow as pa

from sim.dataset.recording import Recording

XYZ = ("x", "y", "z")
GYRO = tuple(f"gyro_{a}_rad_s" for a in XYZ)
ACCEL = tuple(f"accel_{a}_m_s2" for a in XYZ)
ATTITUDE = tuple(f"att_q{a}" for a in "wxyz")
POSITION = tuple(f"pos_{a}_m" for a in ("east", "north", "up"))
TRUE_FIELD = tuple(f"true_field_{a}_nT" for a in XYZ)
TRUE_ATTITUDE = tuple(f"true_q{a}" for a in "wxyz")
TRUE_POSITION = tuple(f"true_pos_{a}_m" for a in ("east", "north", "up"))
RECORDING_GROUPS = ("time", "mag", "gyro", "accel", "attitude", "position", "temperature", "current", "phase")
GROUPS = (*RECORDING_GROUPS, "channel", "truth", "effect")

_TRUTH = re.compile(r"true_|effect[1-9]?_")
_EFFECT = re.compile(r"effect([1-9]?)_(.+)_[xyz]_nT")
_FIXED = {"time_s": "time", "temperature_degC": "temperature", "phase": "phase"} | {
    name: group
    for group, names in (("gyro", GYRO), ("accel", ACCEL), ("attitude", ATTITUDE), ("position", POSITION))
    for name in names
}
_NUMBERED = {"mag": re.compile(r"mag([1-9]?)_[xyz]_nT"), "current": re.compile(r"current_([1-9]\d*)_A")}


@dataclass(frozen=True)
class Column:
    """One column of a file; `group` is one of `GROUPS`, `unit` is 1 for pure numbers and empty for text."""

    name: str
    unit: str
    meaning: str
    group: str


def is_truth(name: str) -> bool:
    """Whether only a simulator knows the column: `true_…` and `effect…`."""
    return _TRUTH.match(name) is not None


def group_of(name: str) -> str:
    """Group of a column by its name; what is in no table is a channel."""
    if is_truth(name):
        return "truth" if name.startswith("true_") else "effect"
    if name in _FIXED:
        return _FIXED[name]
    return next((group for group, pattern in _NUMBERED.items() if pattern.fullmatch(name)), "channel")


def mag_names(sensor: int | None = None) -> tuple[str, ...]:
    """The three columns of the magnetometer, or of sensor 1, 2, … of an array."""
    return tuple(f"mag{sensor or ''}_{a}_nT" for a in XYZ)


def effect_names(effect: str, sensor: int | None = None) -> tuple[str, ...]:
    """The three columns of an effect's contribution, at sensor 1, 2, … of an array."""
    return tuple(f"effect{sensor or ''}_{effect}_{a}_nT" for a in XYZ)


def numbers(group: str, names: Sequence[str]) -> tuple[int, ...]:
    """The numbers in use among `names`: sensors of an array (`mag1_…`) or motors (`current_1_A`), ascending."""
    found = (_NUMBERED[group].fullmatch(name) for name in names)
    return tuple(sorted({int(match[1]) for match in found if match and match[1]}))


def effects_among(names: Sequence[str]) -> tuple[str, ...]:
    """The effects labelled by the columns, in the order of the chain."""
    found = (_EFFECT.fullmatch(name) for name in names)
    return tuple(dict.fromkeys(match[2] for match in found if match))


def columns(*, sensors: int = 1, motors: int = 0, effects: Sequence[str] = ()) -> tuple[Column, ...]:
    """Every column of a simulated run, in the order of the file.

    sensors : magnetometers; from two on their columns are numbered from 1.
    effects : names in the order of the chain.
    """
    which: list[int | None] = [None] if sensors == 1 else list(range(1, sensors + 1))
    return (*_recorded(which, motors), *_known(), *_labels(which, effects))


def schema(table: Sequence[Column]) -> pa.Schema:
    """Arrow schema of columns: float64 (phase: dictionary of strings), unit and meaning in each field's metadata."""
    text = pa.dictionary(pa.int32(), pa.string())
    return pa.schema(
        pa.field(
            c.name,
            text if c.group == "phase" else pa.float64(),
            nullable=False,
            metadata={"unit": c.unit, "meaning": c.meaning},
        )
        for c in table
    )


def columns_of(recording: Recording) -> tuple[Column, ...]:
    """The columns that a recording fills, channels last."""
    sensors = 1 if recording.array_mag_nT is None else len(recording.array_mag_nT)
    motors = 0 if recording.current_A is None else recording.current_A.shape[1]
    optional = {
        "gyro": recording.gyro_rad_s,
        "accel": recording.accel_m_s2,
        "attitude": recording.att_q,
        "position": recording.pos_enu_m,
        "temperature": recording.temperature_degC,
        "phase": recording.phase,
    }
    table = columns(sensors=sensors, motors=motors)
    known = (c for c in table if not is_truth(c.name) and optional.get(c.group, recording.time_s) is not None)
    return (*known, *(Column(name, "", "channel of the log", "channel") for name in recording.channels))


def _recorded(which: Sequence[int | None], motors: int) -> list[Column]:
    table = [Column("time_s", "s", "time since the start", "time")]
    for k in which:
        of = f" of sensor {k}" if k else ""
        table += _vector(mag_names(k), "nT", f"measured field{of}, body frame (FLU)", "mag")
    table += _vector(GYRO, "rad/s", "measured body rate, body frame", "gyro")
    table += _vector(ACCEL, "m/s^2", "measured specific force, body frame", "accel")
    table += _vector(ATTITUDE, "1", "navigation's attitude, quaternion w x y z, body to world (ENU)", "attitude")
    table += _vector(POSITION, "m", "navigation's position, ENU", "position")
    table += [Column("temperature_degC", "degC", "measured temperature of the magnetometer", "temperature")]
    table += [Column(f"current_{i}_A", "A", f"measured current of motor {i}", "current") for i in range(1, motors + 1)]
    return [*table, Column("phase", "", "phase of the motion", "phase")]


def _known() -> list[Column]:
    return [
        *_vector(TRUE_FIELD, "nT", "undisturbed field, body frame", "truth"),
        *_vector(TRUE_ATTITUDE, "1", "true attitude, quaternion w x y z, body to world (ENU)", "truth"),
        *_vector(TRUE_POSITION, "m", "true position of the vehicle, ENU", "truth"),
    ]


def _labels(which: Sequence[int | None], effects: Sequence[str]) -> list[Column]:
    table: list[Column] = []
    for k in which:
        at = f" at sensor {k}" if k else ""
        for effect in effects:
            table += _vector(effect_names(effect, k), "nT", f"contribution of {effect}{at}, body frame", "effect")
    return table


def _vector(names: Sequence[str], unit: str, meaning: str, group: str) -> list[Column]:
    return [Column(name, unit, f"{meaning}: {_component(name)}", group) for name in names]


def _component(name: str) -> str:
    quaternion = re.search(r"_q([wxyz])$", name)
    return quaternion[1] if quaternion else re.findall(r"_(x|y|z|east|north|up)_", name)[-1]
