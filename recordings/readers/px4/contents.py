"""What a ULog file holds: topics as columns, parameters with their changes."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from recordings.readers.px4.formats import TopicLayout
from scenarios.arrays import Array

Bytes = NDArray[np.uint8]


class MissingUlogFieldError(LookupError):
    """A topic without a field that belongs to the topic: the log's formats are damaged, or of an unknown release."""


@dataclass(eq=False)
class UlogTopic:
    """The samples of one topic and instance: column names, and the columns as the log's own types.

    Parameters
    ----------
    name, instance : the topic, as in `battery_status`, and its number from 0. layout : of a sample's bytes.
    at : (n,) the offsets of the samples in the file's bytes, `data`.
    """

    name: str
    instance: int
    layout: TopicLayout
    data: Bytes
    at: array[int] = field(default_factory=lambda: array("Q"))

    @property
    def label(self) -> str:
        """The name in channels: `battery_status`, of later instances `battery_status[1]`."""
        return f"{self.name}[{self.instance}]" if self.instance else self.name

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the numeric fields, such as `timestamp` and `q[0]`."""
        return self.layout.dtype.names or ()

    @cached_property
    def rows(self) -> NDArray[Any]:
        """The samples (n,) as a structured array."""
        windows = sliding_window_view(self.data, self.layout.size)
        return np.ascontiguousarray(windows[np.array(self.at, np.int64)]).view(self.layout.dtype)[:, 0]

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.at)

    def __contains__(self, name: str) -> bool:
        """Return whether the topic has a field of this name."""
        return name in self.names

    def column(self, name: str) -> NDArray[Any]:
        """Return a field (n,) in its own type."""
        return np.ascontiguousarray(self._field(name))

    def vectors(self, *names: str) -> Array:
        """Return fields as the columns of an array (n, k)."""
        return np.column_stack([self._field(name).astype(np.float64) for name in names])

    def times_s(self, name: str = "timestamp") -> Array:
        """Return a field of microseconds in seconds, (n,)."""
        return np.asarray(self._field(name).astype(np.float64) * 1e-6)

    def _field(self, name: str) -> NDArray[Any]:
        if name not in self:
            raise MissingUlogFieldError(f"its topic {self.label} has no field {name}")
        return np.asarray(self.rows[name])


@dataclass(frozen=True)
class ParameterChange:
    """A parameter's new value within the log; time_s : of the last sample before the change."""

    time_s: float
    name: str
    value: float


@dataclass(eq=False)
class ULog:
    """What a ULog file holds.

    Parameters
    ----------
    topics : (name, instance) -> topic with at least one sample. parameters : at the start of the log.
    changes : of parameters within the log, in the order of the file. release : of PX4, as in "1.15.2"; or "".
    damaged : bytes that are no message. cut : whether the file ends within a message.
    """

    topics: dict[tuple[str, int], UlogTopic] = field(default_factory=dict)
    parameters: dict[str, float] = field(default_factory=dict)
    changes: list[ParameterChange] = field(default_factory=list)
    release: str = ""
    damaged: int = 0
    cut: bool = False

    def instances(self, name: str) -> tuple[UlogTopic, ...]:
        """Return the topics of a name, by instance."""
        return tuple(topic for key, topic in sorted(self.topics.items()) if key[0] == name)

    def first(self, *names: str) -> UlogTopic | None:
        """Return the lowest instance of the first of the topics that the log holds."""
        return next((topic for name in names for topic in self.instances(name)), None)
