"""The table of signals and columns: name, unit, meaning and group of everything that a file holds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import pyarrow as pa

from recordings.channels import MOTOR_NUMBER, TEMPERATURE
from recordings.recording import Recording

XYZ = ("x", "y", "z")
GYRO = tuple(f"gyro_{a}_rad_s" for a in XYZ)
ACCEL = tuple(f"accel_{a}_m_s2" for a in XYZ)
ATTITUDE = tuple(f"att_q{a}" for a in "wxyz")
POSITION = tuple(f"pos_{a}_m" for a in ("east", "north", "up"))
TRUE_FIELD = tuple(f"true_field_{a}_nT" for a in XYZ)
TRUE_ATTITUDE = tuple(f"true_q{a}" for a in "wxyz")
TRUE_POSITION = tuple(f"true_pos_{a}_m" for a in ("east", "north", "up"))

_TRUTH = re.compile(r"true_|effect[1-9]?_")
_EFFECT = re.compile(r"effect([1-9]?)_(.+)_[xyz]_nT")


@dataclass(frozen=True)
class Column:
    """A column of a file; `group` is an entry of GROUPS, `unit` is 1 for pure numbers and empty for text."""

    name: str
    unit: str
    meaning: str
    group: str


@dataclass(frozen=True)
class Signal:
    """A quantity that a recording holds: the attribute of Recording, the columns in a file, their unit and meaning.

    Where a recording may hold several (magnetometers, motors), {} stands in `columns` for the number and in `meaning`
    for the text `several`; `number` is the regular expression of the numbers.
    """

    group: str
    field: str
    columns: tuple[str, ...]
    unit: str
    meaning: str
    number: str = ""
    several: str = ""

    def names(self, number: int | None = None) -> tuple[str, ...]:
        """Return the names of the columns, with the number where there are several."""
        return tuple(name.format(number or "") for name in self.columns)

    def table(self, number: int | None = None) -> list[Column]:
        """Return the columns with their meanings."""
        meaning = self.meaning.format(self.several.format(number) if number else "")
        names = self.names(number)
        parts = [f": {_component(name)}" if len(names) > 1 else "" for name in names]
        return [Column(name, self.unit, meaning + part, self.group) for name, part in zip(names, parts, strict=True)]

    def number_in(self, name: str) -> str | None:
        """Return the number in a column's name, empty without a number; None if the name is not of the signal."""
        for column in self.columns:
            match = re.fullmatch(re.escape(column).replace(r"\{\}", f"({self.number})"), name)
            if match:
                return match[1] if self.number else ""
        return None


SIGNALS = (
    Signal("time", "time_s", ("time_s",), "s", "time since the start"),
    Signal(
        *("mag", "mag_nT", tuple(f"mag{{}}_{a}_nT" for a in XYZ), "nT", "measured field{}, body frame (FLU)"),
        number="[1-9]?",
        several=" of sensor {}",
    ),
    Signal("gyro", "gyro_rad_s", GYRO, "rad/s", "measured body rate, body frame"),
    Signal("accel", "accel_m_s2", ACCEL, "m/s^2", "measured specific force, body frame"),
    Signal("attitude", "att_q", ATTITUDE, "1", "navigation's attitude, quaternion w x y z, body to world (ENU)"),
    Signal("position", "pos_enu_m", POSITION, "m", "navigation's position, ENU"),
    Signal("temperature", "temperature_degC", (TEMPERATURE,), "degC", "measured temperature of the magnetometer"),
    Signal(
        *("current", "current_A", ("current_{}_A",), "A", "measured current{}"),
        number=MOTOR_NUMBER,
        several=" of motor {}",
    ),
    Signal("phase", "phase", ("phase",), "", "phase of the motion"),
)
"""The quantities that a recording holds, in the order of a file; every further column is a channel."""
SIGNAL = {signal.group: signal for signal in SIGNALS}
RECORDING_GROUPS = tuple(SIGNAL)
RUN = Column("run", "1", "number of the run in its dataset", "run")
"""Distinguishes the runs of a split dataset that are read together; no instrument gives this column."""
NAMES_KEPT = 1 << 14
"""Names of columns whose group is remembered: logs of vehicles have thousands, and each is asked for several times."""
GROUPS = (RUN.group, *RECORDING_GROUPS, "channel", "truth", "effect")


def is_truth(name: str) -> bool:
    """Return whether only a simulator knows the column: `true_…` and `effect…`."""
    return _TRUTH.match(name) is not None


@lru_cache(1 << 14)
@lru_cache(maxsize=NAMES_KEPT)
def group_of(name: str) -> str:
    """Return the group of a column by its name; a name in no table is a channel."""
    if name == RUN.name:
        return RUN.group
    if is_truth(name):
        return "truth" if name.startswith("true_") else "effect"
    return next((signal.group for signal in SIGNALS if signal.number_in(name) is not None), "channel")


def mag_names(sensor: int | None = None) -> tuple[str, ...]:
    """Return the three columns of the magnetometer, or of sensor 1, 2, … of an array."""
    return SIGNAL["mag"].names(sensor)


def effect_names(effect: str, sensor: int | None = None) -> tuple[str, ...]:
    """Return the three columns of an effect's contribution, at sensor 1, 2, … of an array."""
    return tuple(f"effect{sensor or ''}_{effect}_{a}_nT" for a in XYZ)


def numbers(group: str, names: Sequence[str]) -> tuple[int, ...]:
    """Return the numbers in names, ascending: sensors of an array (`mag1_…`) or motors (`current_1_A`)."""
    found = (SIGNAL[group].number_in(name) for name in names)
    return tuple(sorted({int(number) for number in found if number}))


def labelled_effects(names: Sequence[str]) -> tuple[str, ...]:
    """Return the effects whose contributions are columns, in the order of the chain."""
    found = (_EFFECT.fullmatch(name) for name in names)
    return tuple(dict.fromkeys(match[2] for match in found if match))


def columns(
    *, sensors: int = 1, motors: Sequence[int] = (), channels: Sequence[Column] = (), effects: Sequence[str] = ()
) -> tuple[Column, ...]:
    """Return every column of a simulated run, in the order of the file.

    sensors : magnetometers; from two on their columns are numbered from 1. motors : their numbers.
    channels : columns of the vehicle's own. effects : names in the order of the chain.
    """
    which: list[int | None] = [None] if sensors == 1 else list(range(1, sensors + 1))
    every: dict[str, Sequence[int | None]] = {"mag": which, "current": motors}
    recorded = [
        column for signal in SIGNALS for number in every.get(signal.group, [None]) for column in signal.table(number)
    ]
    return (*recorded, *channels, *_known(), *_labels(which, effects))


def schema(table: Sequence[Column]) -> pa.Schema:
    """Return the Arrow schema of columns, with unit and meaning in each field's metadata.

    float64; the phase is a dictionary of strings, the number of a run int64.
    """
    types = {"phase": pa.dictionary(pa.int32(), pa.string()), RUN.group: pa.int64()}
    return pa.schema(
        pa.field(
            c.name,
            types.get(c.group, pa.float64()),
            nullable=False,
            metadata={"unit": c.unit, "meaning": c.meaning},
        )
        for c in table
    )


def columns_of(recording: Recording) -> tuple[Column, ...]:
    """Return the columns that a recording fills, channels last."""
    sensors = 1 if recording.array_mag_nT is None else len(recording.array_mag_nT)
    held = {signal.group for signal in SIGNALS if getattr(recording, signal.field) is not None}
    own = [Column(name, "", "channel of the log", "channel") for name in recording.channels]
    table = columns(sensors=sensors, motors=recording.motors, channels=own)
    return tuple(column for column in table if column.group in held or column.group == "channel")


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
