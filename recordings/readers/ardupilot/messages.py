"""The messages of a DataFlash log by type and instance, as numpy columns that are read when they are asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.files import system_errors_about
from recordings.readers.ardupilot.index import MessageLayout, Starts, layouts_of, message_starts, scaled
from scenarios.arrays import Array
from scenarios.errors import InputError

CLOCKS = {"TimeUS": 1e-6, "TimeMS": 1e-3}
"""The names of a message's time of writing, newest first, and their units in s."""
GPS_CLOCKS = {"TimeUS": 1e-6, "T": 1e-3}
"""Of GPS messages: their TimeMS counts from the start of the week."""
INSTANCES = ("I", "Inst", "Instance", "C", "IMU")
"""The names of the value that tells a sensor, or an estimator's core, from others of its kind."""
TEXTS = "nNZ"
WHOLE = "bBhHiIMqQ"
"""The format characters of texts, and of whole numbers."""


@dataclass(frozen=True, eq=False)
class Messages:
    """The messages of a type, or of one instance of the type.

    Parameters
    ----------
    layout : of the type. view : every place of the file as if a message began there. starts : (n,) where they do.
    """

    layout: MessageLayout
    view: NDArray[Any]
    starts: Starts

    def __len__(self) -> int:
        """The number of messages."""
        return len(self.starts)

    def __contains__(self, field: str) -> bool:
        """Whether the messages hold a value of this name."""
        return field in self.layout.kinds

    def numbers(self, field: str) -> Array:
        """Return a value of every message (n,), fixed-point numbers in their unit."""
        return scaled(self.view[field][self.starts], self.layout.kinds[field])

    def vector(self, *fields: str) -> Array:
        """Return several values of every message: (n, k)."""
        return np.column_stack([self.numbers(field) for field in fields])

    def words(self, field: str) -> list[str]:
        """Return a text of every message, "" where the value is a number."""
        if self.layout.kinds[field] not in TEXTS:
            return [""] * len(self)
        return [bytes(word).split(b"\0")[0].decode("latin-1") for word in self.view[field][self.starts].tolist()]

    def whole(self, field: str) -> bool:
        """Return whether a value is logged as a whole number."""
        return self.layout.kinds[field] in WHOLE

    @property
    def clock(self) -> tuple[str, float]:
        """The name of the time of writing and its unit in s, "" where the messages have none."""
        clocks = GPS_CLOCKS if self.layout.name.startswith("GPS") else CLOCKS
        return next(((name, unit_s) for name, unit_s in clocks.items() if name in self), ("", 0.0))

    @property
    def instance_field(self) -> str:
        """The name of the value that tells instances apart, "" where there is none."""
        return next((name for name in INSTANCES if self.layout.kinds.get(name, "") in ("B", "b")), "")

    def instances(self) -> dict[int, Messages]:
        """Return the messages of each instance, by its number; 0 alone where the type has none."""
        if not self.instance_field:
            return {0: self}
        number = self.view[self.instance_field][self.starts]
        return {int(one): self.where(number == one) for one in np.unique(number)}

    def where(self, chosen: NDArray[np.bool_]) -> Messages:
        """Return the messages that are chosen (n,)."""
        return replace(self, starts=self.starts[chosen])


@dataclass(frozen=True, eq=False)
class Dataflash:
    """The messages of a log by the names of their types; types without a message are not listed.

    Parameters
    ----------
    types : name -> messages. stray : how many bytes of the log belong to no message.
    """

    types: Mapping[str, Messages]
    stray: int

    def times_s(self, messages: Messages) -> Array:
        """Return the times of writing (n,), s since the autopilot started.

        Messages without a time get the time between those that stand before and after them in the file.
        """
        name, unit_s = messages.clock
        if name:
            return messages.numbers(name) * unit_s
        timed = max(self.types.values(), key=lambda one: len(one) if one.clock[0] else 0)
        name, unit_s = timed.clock
        if not name:
            return np.full(len(messages), np.nan)
        return np.interp(messages.starts, timed.starts, timed.numbers(name) * unit_s)

    def instances(self, name: str) -> dict[int, Messages]:
        """Return the messages of each instance of a type: by a value of theirs, or of NAME, NAME2, NAME3 from 0."""
        own = self.types[name].instances() if name in self.types else {}
        others = {
            number - 1: self.types[f"{name}{number}"] for number in range(2, 10) if f"{name}{number}" in self.types
        }
        return {**others, **own} if len(own) > 1 or not others else {**own, **others}


def read_dataflash(path: Path) -> Dataflash:
    """Return the messages of a log; the file is mapped to memory. InputError for a log that lays out no message."""
    with system_errors_about(path, "check the path and the permissions"):
        data = np.memmap(path, np.uint8, mode="r")
    layouts = layouts_of(data)
    starts, stray = message_starts(data, layouts)
    types = {
        layout.name: Messages(layout, _every_place(data, layout), starts[number])
        for number, layout in layouts.items()
        if len(starts[number])
    }
    if not types:
        raise InputError("holds no whole message of ArduPilot", where=str(path), do="copy the log again")
    return Dataflash(types, stray)


def _every_place(data: NDArray[np.uint8], layout: MessageLayout) -> NDArray[Any]:
    """Return the file as messages (n,) that begin at every byte, without a copy."""
    return np.ndarray((len(data) - layout.length + 1,), layout.dtype, data, strides=(1,))
