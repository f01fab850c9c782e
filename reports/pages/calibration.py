"""Page of the calibrations of a recording: verdict, figures with intervals, residual, coverage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from calib import Calibration, Reference
from recordings import Recording
from reports.pages.section import DrawnSection
from reports.pages.template import render_page
from reports.plots.calibration import draw_strength_before_after
from reports.plots.field import draw_clouds
from reports.plots.inspection import draw_directions
from reports.presentation.calibration import CHANNEL_HEADS, PHASE_HEADS, PresentedCalibrations, of_sensor


def calibration_page(
    found: PresentedCalibrations,
    results: Mapping[str, Calibration],
    recording: Recording,
    reference: Reference,
    written: Sequence[str] = (),
) -> str:
    """Return the page as self-contained HTML; written : what was written where, a line each."""
    best = None if found.best is None else results[found.best]
    sections = [] if best is None else list(_sections(best, of_sensor(recording, found.best or ""), reference))
    heads = {"phase_heads": PHASE_HEADS, "channel_heads": CHANNEL_HEADS}
    return render_page(
        "calibration.html",
        {"found": found, "date": recording.origin.date, "sections": sections, "written": written, **heads},
    )


def _sections(best: Calibration, recording: Recording, reference: Reference) -> Iterator[DrawnSection]:
    corrected_nT = best.apply(recording)
    strength = partial(
        draw_strength_before_after, recording.time_s, recording.mag_nT, corrected_nT, reference.strength_nT
    )
    yield DrawnSection.of("Strength before and after", f"Corrected by {best.name}.", strength, "strength")
    clouds = {"raw": recording.mag_nT, f"corrected: {best.name}": corrected_nT}
    text = "Body frame. The dashed circle and the wire sphere have the strength of the Earth's field."
    yield DrawnSection.of("Field on the sphere", text, partial(draw_clouds, clouds, reference.strength_nT), "sphere")
    sound = corrected_nT[np.isfinite(corrected_nT).all(axis=1)]
    text = (
        "Directions of the corrected field in the body frame; each half of the sphere is a disc of equal area. Blue: "
        "cells with samples. The calibration is uncertain along directions in large white areas."
    )
    yield DrawnSection.of("Coverage of the sphere", text, partial(draw_directions, sound), "coverage")
