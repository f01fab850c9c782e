"""Two types: Recording, what an instrument gives, and Truth, what only a simulator knows."""

from __future__ import annotations

import datetime
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.applied import AppliedCalibration
from scenarios.arrays import Array
from scenarios.errors import InputError


@dataclass(frozen=True)
class Origin:
    """How the columns of a log became a recording.

    Parameters
    ----------
    notes : a line for each guess and each change of the rows, for the user.
    unit : of the magnetometer's columns in the recording: nT, or "count" where the gain is not known.
    timed : whether times were logged; else the samples count as a second apart.
    axes : that were measured, "xyz", or "xy" where z is filled with zeros.
    frame : the log's body frame, "flu" or "frd", which was turned to FLU; empty where it was not stated.
    magnetometer : the name of the magnetometer that was read, in a log of several; magnetometers : of all.
    place : latitude and longitude in degrees and altitude in m, and date : where the log tells them.
    start_s : seconds since 1970 (UTC) at time_s = 0; None where the log tells no time of day.
    applied : the calibration that the autopilot had in force; None where the log tells of none.
    """

    notes: tuple[str, ...] = ()
    unit: str = "nT"
    timed: bool = True
    axes: str = "xyz"
    frame: str = ""
    magnetometer: str = ""
    magnetometers: tuple[str, ...] = ()
    place: tuple[float, ...] | None = None
    date: datetime.date | None = None
    start_s: float | None = None
    applied: AppliedCalibration | None = None


STATED = Origin()
"""Of columns under the contract's names and in its units."""


@dataclass(frozen=True, repr=False)
class Recording:
    """A recording of n samples, all that a calibrator sees. A quantity that was not measured is None.

    =================  ============  =================================================================
    time_s             (n,)          increasing
    mag_nT             (n, 3)        measured field, body frame (FLU)
    gyro_rad_s         (n, 3)        body rate
    accel_m_s2         (n, 3)        specific force, body frame
    att_q              (n, 4)        navigation's attitude, w x y z, body to world (ENU)
    pos_enu_m          (n, 3)        navigation's position
    temperature_degC   (n,)
    current_A          (n, m)        motor currents, of the motors of `motors`
    phase              (n,) str
    channels           name -> (n,)  any other numeric column
    array_mag_nT       (k, n, 3)     the sensors of an array; mag_nT is then the first sensor
    motor_numbers      (m,)          of the motors in current_A; empty: 1 to m
    origin                           how the log was read
    =================  ============  =================================================================
    """

    time_s: Array
    mag_nT: Array
    gyro_rad_s: Array | None = None
    accel_m_s2: Array | None = None
    att_q: Array | None = None
    pos_enu_m: Array | None = None
    temperature_degC: Array | None = None
    current_A: Array | None = None
    phase: NDArray[np.str_] | None = None
    channels: dict[str, Array] = field(default_factory=dict)
    array_mag_nT: Array | None = None
    motor_numbers: tuple[int, ...] = ()
    origin: Origin = STATED

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        """Return one line: samples, length, and the quantities recorded besides the field."""
        sensors = 1 if self.array_mag_nT is None else len(self.array_mag_nT)
        of = "one magnetometer" if sensors == 1 else f"{sensors} magnetometers"
        length_s = float(self.time_s[-1] - self.time_s[0]) if len(self) else 0.0
        more = [item.name for item in fields(self)[2:-4] if getattr(self, item.name) is not None]
        named = f"; {', '.join([*more, *self.channels])}" if more or self.channels else ""
        return f"Recording: {len(self)} samples of {of} in {length_s:.6g} s{named}"

    def in_nT(self, where: str = "recording") -> Recording:
        """Return the recording; InputError where the field is in counts of unknown unit."""
        if self.origin.unit != "nT":
            what = "the field is in counts of unknown unit"
            raise InputError(
                what, where=where, do="give --unit uT and the like, or nT a count as --map mag_x_nT=x,scale=F"
            )
        return self

    @property
    def motors(self) -> tuple[int, ...]:
        """The number of each motor in current_A."""
        if self.current_A is None:
            return ()
        return self.motor_numbers or tuple(range(1, self.current_A.shape[1] + 1))

    def sensor(self, index: int) -> Recording:
        """Return the recording of a single sensor of an array (0-based)."""
        if self.array_mag_nT is None:
            raise IndexError("the recording has one magnetometer, not an array")
        return replace(self, mag_nT=self.array_mag_nT[index], array_mag_nT=None)

    def taken(self, samples: slice | NDArray[np.bool_]) -> Recording:
        """Return the recording of a part of the samples, in order."""
        along: dict[str, Any] = {"array_mag_nT": np.s_[:, samples]}
        own = {item.name: getattr(self, item.name) for item in fields(self)}
        parts = {name: v[along.get(name, samples)] for name, v in own.items() if isinstance(v, np.ndarray)}
        return replace(self, **parts, channels={name: values[samples] for name, values in self.channels.items()})


@dataclass(frozen=True, repr=False)
class Truth:
    """The truth of a simulated recording.

    field_nT (n, 3): undisturbed field, body frame; q (n, 4): attitude; pos_enu_m (n, 3);
    effects: name -> (n, 3), or (k, n, 3) for an array: contributions in the order of the chain;
    parameters: the parquet metadata's true parameters.
    field_nT + sum(effects) = mag_nT on every sample, to rounding.
    """

    field_nT: Array
    q: Array
    pos_enu_m: Array
    effects: dict[str, Array]
    parameters: dict[str, Any]

    def __repr__(self) -> str:
        """Return one line: samples and effects."""
        return f"Truth: {len(self.field_nT)} samples; {', '.join(self.effects) or 'no effects'}"
