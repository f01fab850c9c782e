"""ArduPilot's calibration of a compass as it changes within a log, undone with the parameters in force at each time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recordings.readers.ardupilot.compass import calibration_names, compass_calibration
from recordings.readers.ardupilot.motor_term import Drive, motor_names, motor_term
from recordings.readers.ardupilot.parameters import Parameters
from scenarios.arrays import Array

STEP_MG = 1.0
"""Steps of logged fields and offsets."""


@dataclass(frozen=True, eq=False)
class AppliedInLog:
    """The calibration of a compass at the times of its samples.

    Parameters
    ----------
    parameters : of the log. compass : its number in them, from 1. times_s : (n,) of the samples.
    motors_first : whether the firmware adds the motors' term before the soft iron.
    """

    parameters: Parameters
    compass: int
    times_s: Array
    motors_first: bool = False

    @cached_property
    def _changes_s(self) -> Array:
        return self.parameters.changes_s(calibration_names(self.compass))

    def undone(
        self, field_mG: Array, motor_mG: Array, logged_mG: Array | None = None
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return R raw, mG (n, 3), of fields (n, 3), and where (n,) logged offsets differ from the parameters.

        motor_mG : k p (n, 3). logged_mG : offsets (n, 3) that the log gives with each sample.
        """
        piece = np.searchsorted(self._changes_s, self.times_s, "right")
        raw_mG, learned = np.empty_like(field_mG), np.zeros(len(field_mG), np.bool_)
        for k in np.unique(piece):
            here = piece == k
            in_force = self.parameters.at([-np.inf, *self._changes_s][k], calibration_names(self.compass))
            calibration = compass_calibration(in_force, self.compass, motors_first=self.motors_first)
            logged = None if logged_mG is None else logged_mG[here]
            offset_mG, learned[here] = _offsets(calibration.offset_mG, logged, int(np.sum(here)))
            raw_mG[here] = calibration.raw_mG(field_mG[here], motor_mG[here], offset_mG)
        return raw_mG, learned

    def motor_term(self, drive: Drive) -> tuple[Array, str]:
        """Return the motors' term by the parameters, mG (n, 3), and a line where the log lacks what it follows."""
        names = motor_names(self.compass)
        changes_s = self.parameters.changes_s(names)
        piece = np.searchsorted(changes_s, self.times_s, "right")
        found, lacking = np.zeros((len(self.times_s), 3)), ""
        for k in np.unique(piece):
            in_force = self.parameters.at([-np.inf, *changes_s][k], names)
            found[piece == k], told = motor_term(in_force, self.compass, self.times_s[piece == k], drive)
            lacking = lacking or told
        return found, lacking

    @property
    def notes(self) -> list[str]:
        """A line where the calibration changed between the samples."""
        if len(np.unique(np.searchsorted(self._changes_s, self.times_s, "right"))) < 2:
            return []
        count = len(self._changes_s)
        return [f"compass {self.compass}: its calibration changed in the log ({count} times): undone piece by piece"]


def _offsets(stated_mG: Array, logged_mG: Array | None, count: int) -> tuple[Array, NDArray[np.bool_]]:
    """Return the offsets of each sample (n, 3), and where (n,) the logged ones differ from the stated offsets.

    Logged offsets are cut to whole mG, and come as the middle of what was cut; where they fit the parameter, the
    parameter is the finer value.
    """
    stated = np.tile(stated_mG, (count, 1))
    if logged_mG is None:
        return stated, np.zeros(count, np.bool_)
    other = np.any(np.abs(np.trunc(logged_mG) - stated) >= STEP_MG, axis=1)
    return np.where(other[:, None], logged_mG, stated), other
