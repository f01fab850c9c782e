"""Channels of a recording declared as motor currents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from recordings import Recording
from recordings.channels import current_name
from scenarios.errors import InputError


def with_actuators(recording: Recording, names: Sequence[str], path: Path) -> Recording:
    """The recording with some channels appended to its motor currents, numbered after them.

    Raises InputError for an unknown channel.
    """
    columns = [] if recording.current_A is None else list(recording.current_A.T)
    last = max(recording.motors, default=0)
    motors = (*recording.motors, *range(last + 1, last + 1 + len(names)))
    for name in names:
        if name not in recording.channels:
            do = "the channels are " + (", ".join(recording.channels) or "none")
            raise InputError(f"there is no channel {name!r}", where=f"{path}: --actuator", do=do)
        columns.append(recording.channels[name])
    return replace(recording, current_A=np.stack(columns, axis=1), motor_numbers=motors) if names else recording


def as_currents(recording: Recording) -> dict[str, str]:
    """Channels equal to a motor current, each with the name of the current."""
    if recording.current_A is None:
        return {}
    currents = list(zip(map(current_name, recording.motors), recording.current_A.T, strict=True))
    return {
        channel: name
        for channel, values in recording.channels.items()
        for name, current_A in currents
        if np.array_equal(values, current_A)
    }
