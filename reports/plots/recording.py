"""The plot of a recording: components and strength of the measured field over time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from recordings.recording import Recording
from reports.palette import INK, XYZ
from reports.plots.style import legend_at_right, panels, time_scale
from validation.signals.thinning import envelope


def draw_recording(recording: Recording) -> Figure:
    """Draw x, y and z of the measured field, body frame, and its strength over time."""
    figure, (parts, whole) = panels(4.6, 2, sharex=True)
    scale, unit = (1e3, "µT") if recording.origin.unit == "nT" else (1.0, "counts")
    span, span_unit = time_scale(recording.time_s)
    strength = np.linalg.norm(recording.mag_nT, axis=1)[:, None]
    time, thin = envelope(recording.time_s / span, np.hstack([recording.mag_nT, strength]) / scale)
    for k, name in enumerate("xyz"):
        parts.plot(time, thin[:, k], color=XYZ[k], label=name)
    whole.plot(time, thin[:, 3], color=INK)
    parts.set_title("measured field, body frame (x forward, y left, z up)")
    whole.set_title("strength")
    for axis in (parts, whole):
        axis.set_ylabel(unit)
    legend_at_right(parts)
    whole.set_xlabel(f"time ({span_unit})")
    return figure
