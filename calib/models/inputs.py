"""Candidate columns of a measurement model: currents, throttle, motor outputs, temperature, eddy currents.

m = S h + b + sum_j k_j (p_j - p_j0) + B dh/dt
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from calib.input_terms import CURRENT_SUM, InputTerm, delayed, input_signal
from recordings import Recording
from recordings.channels import TEMPERATURE, THROTTLE, current_name, motor_output_name
from scenarios.arrays import Array

Kind = Literal["battery", "motors", "throttle", "outputs", "temperature"]
KINDS: tuple[Kind, ...] = get_args(Kind)
BATTERY = re.compile(r"bat(tery)?[^.]*([._]|\]\.)(curr(ent)?(_a)?|cur)", re.IGNORECASE)
"""A battery's current under a log's own name, such as BAT.Curr or battery_status.current_a."""
LEAST_SPAN = 0.02
"""Change of an input, in parts of its size, below which its field cannot be told from the offset."""
LEAST_WARMING_DEGC = 1.0
"""Change of a temperature below which no field is looked for."""
SPAN_PERCENT = (2.5, 97.5)
"""Percentiles that an input's change is taken between."""
ALIKE = 1.0 - 1e-6
"""Correlation from which on two inputs are one."""


@dataclass(frozen=True, eq=False)
class InputGroup:
    """Inputs that a model takes together: channels, signals (n, m) in their units, references (m,), and one lag."""

    kind: Kind
    channels: tuple[str, ...]
    signals: Array
    references: tuple[float, ...]
    lag_s: float = 0.0

    @property
    def called(self) -> str:
        """The group in words."""
        return self.channels[0] if len(self.channels) == 1 else f"{self.channels[0]} to {self.channels[-1]}"

    @property
    def span(self) -> Array:
        """Change (m,) of each input."""
        low, high = np.percentile(self.signals, SPAN_PERCENT, axis=0)
        return np.asarray(high - low)

    @property
    def varies(self) -> bool:
        """Whether an input changes enough for a field to be told from the offset."""
        if self.kind == "temperature":
            return bool(self.span[0] >= LEAST_WARMING_DEGC)
        return bool((self.span > LEAST_SPAN * np.abs(self.signals).max(axis=0)).any())

    def moved(self, time_s: Array) -> Array:
        """Inputs (n, m) minus their references, behind the lag."""
        columns = zip(self.signals.T, self.references, strict=True)
        return np.asarray(np.column_stack([delayed(signal - at, time_s, self.lag_s) for signal, at in columns]))

    def terms(self, gains_nT: Array) -> tuple[InputTerm, ...]:
        """The terms with gains (m, 3)."""
        rows = zip(self.channels, gains_nT, self.references, strict=True)
        return tuple(InputTerm(channel, gain, at, self.lag_s) for channel, gain, at in rows)


def axis_columns(signals: Array) -> Array:
    """Columns (n, 3, 3 m) of signals (n, m), each along x, y and z."""
    return np.asarray(np.einsum("nm,ij->nimj", signals, np.eye(3)).reshape(len(signals), 3, -1))


def input_groups(recording: Recording, kinds: Container[str] = KINDS) -> tuple[InputGroup, ...]:
    """What a recording offers, the simplest first: a battery's current, throttle, temperature, then each motor."""
    found: list[InputGroup] = []
    for kind, channels in _offered(recording):
        if kind not in kinds:
            continue
        signals = [input_signal(recording, channel) for channel in channels]
        known = [np.asarray(one) for one in signals if one is not None and np.isfinite(one).all()]
        if len(known) < len(channels) or _repeats(found, known):
            continue
        references = tuple(round(float(one.mean()), 1) if kind == "temperature" else 0.0 for one in known)
        found.append(InputGroup(kind, channels, np.column_stack(known), references))
    return tuple(found)


def _offered(recording: Recording) -> Iterator[tuple[Kind, tuple[str, ...]]]:
    """Kind and channels of each group, in the order in which they are tried."""
    each = tuple(current_name(motor) for motor in recording.motors)
    outputs = tuple(sorted(filter(_is_output, recording.channels), key=lambda name: int(name.rsplit("_", 1)[1])))
    if each:
        yield "battery", each if len(each) == 1 else (CURRENT_SUM,)
    for channel in recording.channels:
        if BATTERY.fullmatch(channel):
            yield "battery", (channel,)
    if THROTTLE in recording.channels:
        yield "throttle", (THROTTLE,)
    if recording.temperature_degC is not None:
        yield "temperature", (TEMPERATURE,)
    if len(each) > 1:
        yield "motors", each
    if outputs:
        yield "outputs", outputs


def _is_output(channel: str) -> bool:
    number = channel.rsplit("_", 1)[-1]
    return number.isdigit() and channel == motor_output_name(int(number))


def _repeats(found: list[InputGroup], signals: list[Array]) -> bool:
    """Whether a single signal is one that an earlier group has."""
    if len(signals) != 1:
        return False
    earlier = [one.signals[:, 0] for one in found if len(one.channels) == 1]
    return any(abs(correlation(signals[0], other)) > ALIKE for other in earlier)


def correlation(one: Array, other: Array) -> float:
    """Correlation of two signals (n,); 0 where one is constant."""
    a, b = one - one.mean(), other - other.mean()
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(a @ b) / size if size > 0 else 0.0
