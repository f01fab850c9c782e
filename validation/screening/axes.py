"""Axes and frame: a magnetometer whose axes are not those of gyro, accelerometer or attitude, and a log in FRD."""

from __future__ import annotations

import numpy as np

from calib import Reference
from recordings import Recording
from validation.axes.estimate import Axes, axes_of, field_down
from validation.axes.frame import BodyFrame, frame_of
from validation.axes.wording import axes_verdict
from validation.screening.fault import Fault, Mask


def axes_and_frame(recording: Recording, reference: Reference | None = None) -> list[Fault]:
    """Return wrong axes, and a frame other than FLU; no row is left out.

    Left-handed axes make every estimate doubtful where more than an accelerometer tells the handedness. A turn
    does not: offset and strength hold in the sensor's own axes, and a method with gyro or attitude fits the turn.
    """
    axes, frame = axes_with_frame(recording, reference)
    nowhere = np.zeros(len(recording), np.bool_)
    found = [] if axes is None else _axes(axes, nowhere)
    if frame.wrong:
        found.append(Fault("frame", frame.clause, nowhere, "none"))
    return found


def axes_with_frame(recording: Recording, reference: Reference | None = None) -> tuple[Axes | None, BodyFrame]:
    """Return the axes as gyro, accelerometer and attitude tell them, None without any, and the body frame."""
    if recording.gyro_rad_s is None and recording.accel_m_s2 is None and recording.att_q is None:
        return None, BodyFrame("", "", stated=recording.origin.frame)
    axes = axes_of(
        recording.time_s,
        recording.mag_nT,
        gyro=recording.gyro_rad_s,
        accel=recording.accel_m_s2,
        q=recording.att_q,
        down=field_down(reference),
        stated=recording.origin.frame,
    )
    return axes, frame_of(recording.accel_m_s2, recording.att_q, axes)


def _axes(axes: Axes, nowhere: Mask) -> list[Fault]:
    verdict = axes_verdict(axes)
    if verdict.kind not in ("turned", "left_handed", "reversed"):
        return []
    text = verdict.text
    if verdict.kind == "turned":
        text += "; offset and strength hold without it"
    doubtful = verdict.kind == "left_handed" and axes.handedness_known
    return [Fault(verdict.kind, text, nowhere, "none", doubtful)]
