"""A vehicle's log in words: samples, frame, place, field and the calibration in force."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from recordings.applied import AppliedCalibration
from recordings.recording import Origin, Recording
from validation.text import counted, figure

AXES = ("east", "north", "up")


def log_lines(form: str, recording: Recording, rate_hz: float, field_enu_nT: Sequence[float] | None) -> Iterator[str]:
    """Yield a line for each thing that a log tells of itself; field_enu_nT : of its place and date, None if unknown."""
    origin = recording.origin
    yield f"{form}: {_samples(recording, rate_hz)}{_named(origin)}"
    if origin.frame:
        turned = "" if origin.frame == "flu" else ", turned to flu (x forward, y left, z up)"
        yield f"body frame of the log: {origin.frame}{turned}"
    if origin.place is not None:
        yield f"place {_place(origin.place)}, date {origin.date or 'not in the log (give --date)'}"
    if field_enu_nT is not None:
        parts = ", ".join(f"{axis} {figure(value, 5)}" for axis, value in zip(AXES, field_enu_nT, strict=True))
        yield f"field there: {figure(math.hypot(*field_enu_nT), 5)} nT ({parts}), IGRF"
    if origin.applied is not None:
        yield _calibration(origin.applied)


def _samples(recording: Recording, rate_hz: float) -> str:
    length_s = float(recording.time_s[-1] - recording.time_s[0])
    timed = f" in {figure(length_s)} s, {figure(rate_hz)} Hz" if recording.origin.timed else ", without times"
    return f"{counted(len(recording), 'sample')}{timed}, in {recording.origin.unit}"


def _named(origin: Origin) -> str:
    """Return the magnetometer that was read, and how to read another."""
    others = [name for name in origin.magnetometers if name != origin.magnetometer]
    named = f", magnetometer {origin.magnetometer}" if origin.magnetometer else ""
    return named + (f" (--stream reads another: {', '.join(others)})" if others else "")


def _place(place: Sequence[float]) -> str:
    latitude, longitude, *height = place
    above = f", {figure(height[0])} m" if height else ""
    return f"{latitude:.5f}, {longitude:.5f}{above}"


def _calibration(applied: AppliedCalibration) -> str:
    """Return the calibration that the autopilot had in force, in its own body field: h = M (m - b)."""
    offset = ", ".join(figure(float(value), 4) for value in applied.offset_nT)
    rows = "; ".join(" ".join(f"{value:.4f}" for value in row) for row in applied.matrix)
    done = "undone" if applied.undone else "not in these columns: they are raw"
    return f"calibration in force ({applied.autopilot}, compass {applied.compass}), {done}: b ({offset}) nT, M [{rows}]"
