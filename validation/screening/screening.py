"""Screening of a recording for faults of its magnetometers, before a fit and in an inspection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from calib import Calibration, Reference, Status
from recordings import Recording
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.screening.axes import axes_and_frame, axes_with_frame
from validation.screening.axes_alike import alike, unwired
from validation.screening.fault import Fault, Mask
from validation.screening.full_scale import full_scale
from validation.screening.offset_steps import offset_steps
from validation.screening.sentinel import sentinels
from validation.screening.stuck import frozen, held, stuck
from validation.screening.wrapped import wrapped
from validation.text import sentence

Screen = Callable[[Recording], Sequence[Fault]]
SCREENS: tuple[Screen, ...] = (sentinels, wrapped, frozen, held, stuck, full_scale, alike, unwired, offset_steps)
"""Screens in the order of use: each sees what the screens before it have left in and mended; the axes come last."""


@dataclass(frozen=True, eq=False)
class ScreenedRecording:
    """A recording without its faulty rows, and the faults; rows are counted in the recording as given.

    keep : rows (n,) of the recording as given that are left in.
    """

    recording: Recording
    faults: tuple[Fault, ...]
    keep: Mask

    def summary(self) -> list[dict[str, Any]]:
        """Return the faults as plain values for JSON."""
        return [fault.summary() for fault in self.faults]

    def of_sensor(self, sensor: int) -> ScreenedRecording:
        """Return a single sensor (0-based) of an array, with the faults of that sensor."""
        faults = tuple(fault for fault in self.faults if fault.sensor in (None, sensor))
        return replace(self, recording=self.recording.sensor(sensor), faults=faults)

    def judged(self, calibration: Calibration, sensor: int | None = None) -> Calibration:
        """Return a calibration of the screened recording with the faults in its reason.

        An "ok" becomes "unobservable" where a fault that makes every estimate doubtful stays in the recording.
        sensor : index of the calibrated sensor in an array; None for the whole recording.
        """
        concerned = [fault for fault in self.faults if sensor is None or fault.sensor in (None, sensor)]
        if not concerned:
            return calibration
        status = calibration.status
        reason = "; ".join([*(fault.told for fault in concerned), *([status.reason] if status.reason else [])])
        doubtful = status.kind == "ok" and any(fault.doubtful for fault in concerned)
        return replace(calibration, status=Status("unobservable" if doubtful else status.kind, reason))


def screening_lines(screening: ScreenedRecording) -> list[str]:
    """Return a sentence for each fault, and one for the frame that the recording was taken in."""
    frame = axes_with_frame(screening.recording)[1]
    return [*(sentence(fault.told) for fault in screening.faults), *([] if frame.wrong else [frame.text])]


def screen(recording: Recording, reference: Reference | None = None) -> ScreenedRecording:
    """Screen a recording; of an array, every sensor, and a row with a fault of any sensor is left out.

    reference : the field; its vertical part distinguishes mirrored axes from a place in the other hemisphere.
    """
    screens: tuple[Screen, ...] = (*SCREENS, partial(axes_and_frame, reference=reference))
    if recording.array_mag_nT is None:
        keep, mag_nT, faults = _screened(recording, None, screens)
        return ScreenedRecording(_taken(replace(recording, mag_nT=mag_nT), keep), faults, keep)
    every = [_screened(recording.sensor(k), k, screens) for k in range(len(recording.array_mag_nT))]
    array = np.stack([mag_nT for _, mag_nT, _ in every])
    keep = np.logical_and.reduce([keep for keep, _, _ in every])
    faults = tuple(fault for _, _, found in every for fault in found)
    if np.count_nonzero(keep) < POLICY.least_kept:
        keep, faults = np.ones(len(recording), np.bool_), tuple(_left_in(fault) for fault in faults)
    whole = replace(recording, mag_nT=array[0], array_mag_nT=array)
    return ScreenedRecording(_taken(whole, keep), faults, keep)


def _taken(recording: Recording, keep: Mask) -> Recording:
    return recording if keep.all() else recording.taken(keep)


def _screened(
    recording: Recording, sensor: int | None, screens: Sequence[Screen]
) -> tuple[Mask, Array, tuple[Fault, ...]]:
    """Return rows to keep (n,), the field (n, 3) with mended values, and the faults of a magnetometer."""
    keep, mag_nT = np.ones(len(recording), np.bool_), recording.mag_nT
    found: list[Fault] = []
    for look in screens:
        if np.count_nonzero(keep) < POLICY.least_kept:
            break
        for fault in look(_taken(replace(recording, mag_nT=mag_nT), keep)):
            kept = np.flatnonzero(keep)
            if fault.mended_nT is not None:
                mag_nT = mag_nT.copy()
                mag_nT[kept] = fault.mended_nT
            fault = replace(fault, sensor=sensor)
            if fault.remedy == "left out" and np.count_nonzero(~fault.rows) < POLICY.least_kept:
                fault = _left_in(fault)
            found.append(fault.among(kept, len(recording)))
        for fault in found:
            if fault.remedy == "left out":
                keep = keep & ~fault.rows
    return keep, mag_nT, tuple(found)


def _left_in(fault: Fault) -> Fault:
    """Return a fault whose rows stay, since too few others would be left."""
    return replace(fault, remedy="none", doubtful=True) if fault.remedy == "left out" else fault
