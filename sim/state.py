"""A block of the truth, as input of the effects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from recordings.channels import current_name, motors_of
from scenarios.arrays import Array
from scenarios.errors import InputError

MOTION = frozenset({"attitude", "rate", "position"})
"""Inputs of an effect from the motion; all further inputs are channels."""
SPARSEST = 4
"""Even samples for each recorded sample, beyond which a recording is mostly gaps and is not resampled."""


@dataclass(frozen=True)
class State:
    """The vehicle and its surroundings at one magnetometer's n sample times (a block of a run).

    ================  ============  ====================================================================
    time_s            (n,)          since the start of the run, evenly spaced
    interval_s        float         sample interval
    pos_enu_m         (n, 3)        of the magnetometer (lever arm included)
    R_wb              (n, 3, 3)     body (FLU) to world (ENU)
    rate_rad_s        (n, 3)        body rate, body frame
    field_enu_nT      (3,)          undisturbed Earth field
    field_nT          (n, 3)        undisturbed field in the body frame, R_wb^T field_enu_nT
    field_rate_nT_s   (n, 3)        its time derivative in the body frame, -rate x field
    channels          name -> (n,)  whatever else is simulated or recorded, by the name of its column, unit included:
                                    temperature_degC of the magnetometer, current_1_A, ..., any column of a log
    attitude          str           where R_wb comes from: the simulator's truth, or a recording's navigation
    ================  ============  ====================================================================
    """

    time_s: Array
    interval_s: float
    pos_enu_m: Array
    R_wb: Array
    rate_rad_s: Array
    field_enu_nT: Array
    field_nT: Array
    field_rate_nT_s: Array
    channels: Mapping[str, Array] = field(default_factory=dict)
    attitude: Literal["truth", "navigation"] = "truth"

    def __len__(self) -> int:
        return len(self.time_s)

    def channel(self, name: str) -> Array:
        """A channel (n,); InputError with the list of known channels."""
        if name not in self.channels:
            raise missing_channel(name, self.channels)
        return self.channels[name]

    @cached_property
    def motors(self) -> tuple[int, ...]:
        """The numbers of the motors whose currents are known."""
        return motors_of(self.channels)

    @cached_property
    def current_A(self) -> Array:
        """The currents (n, m) of `motors`, m = 0 without any."""
        columns = [self.channels[current_name(motor)] for motor in self.motors]
        return np.column_stack(columns) if columns else np.zeros((len(self), 0))

    def current_of(self, motor: int) -> Array:
        """Current (n,) of a motor by number, or for 0 the sum of all; InputError for an unknown motor."""
        return self.channel(current_name(motor)) if motor else np.asarray(self.current_A.sum(axis=1))


def missing_channel(name: str, there: Mapping[str, object]) -> InputError:
    """Error for an effect on an unknown channel."""
    return InputError(f"needs the channel {name!r}", do="the channels are " + (", ".join(there) or "none"))
