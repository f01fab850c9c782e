"""Terms of recorded inputs in the measurement: motor currents, throttle, temperature.

m = S h + b + sum_j k_j (p_j - p_j0) + B dh/dt,  p_j an input behind a first-order lag, p_j0 its reference
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from calib.numerics.lag import lagged
from recordings import Recording
from recordings.channels import TEMPERATURE, current_name
from scenarios.arrays import Array
from scenarios.errors import InputError

CURRENT_SUM = "current_sum_A"
"""The input that is the sum of all motor currents, of a recording with several."""
UNIT = re.compile(r"_(A|degC|V|rad_s|Pa|W)$")
"""Unit at the end of an input's name; an input without is a number, such as a throttle of 0 to 1."""
GAIN = re.compile(r"_[xyz]_nT(_per_\w+)?$")
"""End of the name of a gain among the parameters."""


@dataclass(frozen=True, eq=False)
class InputTerm:
    """Field of an input: gain_nT (3,), body frame, per unit of the channel, times the input minus `reference`.

    lag_s : time constant by which the field follows the channel; 0: at once.
    """

    channel: str
    gain_nT: Array
    reference: float = 0.0
    lag_s: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the three gains among the parameters, with their unit."""
        return gain_names(self.channel)

    def field(self, recording: Recording) -> Array:
        """Field (n, 3) of the input, nT; InputError for a recording without the channel."""
        return np.asarray(self.moved(recording)[:, None] * self.gain_nT)

    def moved(self, recording: Recording) -> Array:
        """The input (n,) minus its reference, behind the lag; InputError for a recording without the channel."""
        signal = input_signal(recording, self.channel)
        if signal is None:
            what = f"has no {self.channel}, whose field the calibration takes off"
            raise InputError(what, where="recording", do=f"record {self.channel}, or calibrate without it")
        return delayed(signal - self.reference, recording.time_s, self.lag_s)


def gain_names(channel: str) -> tuple[str, ...]:
    """Names of the gains of an input, such as current_1_A_x_nT_per_A."""
    unit = UNIT.search(channel)
    return tuple(f"{channel}_{axis}_nT" + (f"_per_{unit[1]}" if unit else "") for axis in "xyz")


def delayed(signal: Array, time_s: Array, lag_s: float) -> Array:
    """A signal (n,) behind a first-order lag, of samples in any order."""
    if lag_s <= 0.0:
        return signal
    order = np.argsort(time_s, kind="stable")
    out = np.empty(len(signal))
    out[order] = lagged(np.ascontiguousarray(signal[order]), time_s[order], lag_s)
    return out


def input_signal(recording: Recording, channel: str) -> Array | None:
    """An input (n,) by the name of its column, or CURRENT_SUM; None where it was not recorded."""
    if recording.current_A is not None:
        if channel == CURRENT_SUM:
            return np.asarray(recording.current_A.sum(axis=1))
        own = {current_name(motor): k for k, motor in enumerate(recording.motors)}
        if channel in own:
            return np.asarray(recording.current_A[:, own[channel]])
    if channel == TEMPERATURE:
        return recording.temperature_degC
    return recording.channels.get(channel)
