"""Page of a corrected recording: the strength before and after, what was applied, what to do next."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from reports.pages.section import DrawnSection
from reports.pages.template import render_page
from reports.plots.calibration import draw_strength_before_after
from reports.plots.field import draw_clouds
from reports.presentation.correction import PresentedCorrection, measured
from validation.calibrating.calibration_file import AppliedFile


def correction_page(found: PresentedCorrection, applied: AppliedFile) -> str:
    """Return the page as self-contained HTML."""
    content = {"found": found, "date": applied.recording.origin.date, "sections": list(_sections(found, applied))}
    return render_page("correction.html", content)


def _sections(found: PresentedCorrection, applied: AppliedFile) -> Iterator[DrawnSection]:
    time_s = applied.recording.time_s
    for number, (key, corrected_nT) in enumerate(applied.found.items(), start=1):
        before_nT, after_nT = (one.reshape(len(one), -1) for one in (measured(applied, key), corrected_nT))
        mean_nT = found.changes[key].mean_nT[1]
        strength = partial(draw_strength_before_after, time_s, before_nT, after_nT, mean_nT, "mean after")
        of = f", {key}" if len(applied.found) > 1 else ""
        yield DrawnSection.of(f"Strength before and after{of}", "", strength, f"strength{number}")
        if not applied.scalar:
            clouds = {"measured": before_nT, "corrected": after_nT}
            text = "Body frame. The dashed circle and the wire sphere have the mean strength after the correction."
            yield DrawnSection.of(
                f"Field on the sphere{of}", text, partial(draw_clouds, clouds, mean_nT), f"sphere{number}"
            )
