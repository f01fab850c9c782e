"""Calibrations as results: with the recording they were fitted to, an assessment, a table and a picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

from calib.reference import Reference
from calib.result import Calibration
from magbench.api.displayed import Displayed, values_of
from recordings import Recording
from validation.calibrating.fitting import sensor_fits, sensor_recordings
from validation.calibrating.selection import usual_calibrators
from validation.screening.screening import ScreenedRecording, screen

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from numpy.typing import NDArray

    from reports.plots.style import Figure
    from reports.presentation.calibration import PresentedCalibrations
    from validation.assessment.assessment import Assessment
    from validation.calibrating.base_station import WithoutChange
    from validation.calibrating.calibrator_entry import CalibratorEntry
    from validation.calibrating.output_unit import OutputUnit
    from validation.cross_validation.claimed_std import Claim
    from validation.known_figures.figures import KnownFigure


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class CalibrationResult(Calibration, Displayed):
    """A calibration with the recording and the reference that it was fitted to."""

    recording: Recording
    reference: Reference

    @classmethod
    def of(cls, found: Calibration, recording: Recording, reference: Reference) -> Self:
        """A calibrator's calibration with its input."""
        return cls(**values_of(found), recording=recording, reference=reference)

    @property
    def corrected_nT(self) -> NDArray[np.float64]:
        """The recording's field after correction (n, 3), body frame."""
        return self.apply(self.recording)

    def to_frame(self) -> pd.DataFrame:
        """Offset and matrix, a row an axis; NaN without an estimate."""
        import pandas as pd

        table = pd.DataFrame(self.matrix, index=list("xyz"), columns=[f"matrix_{axis}" for axis in "xyz"])
        table.insert(0, "offset_nT", self.offset_nT)
        return table if self.has_estimate else table * float("nan")

    def plot(self) -> Figure:
        """Raw and corrected field against the sphere of the field's strength."""
        from reports.plots.field import draw_clouds

        clouds = {"raw": self.recording.mag_nT}
        if self.has_estimate:
            clouds[f"corrected: {self.name}"] = self.corrected_nT
        return draw_clouds(clouds, self.reference.strength_nT)


class Calibrations(dict[str, CalibrationResult], Displayed):
    """Calibrations by name, of an array `name@sensor`, with the screened recording and the reference of all."""

    def __init__(
        self, results: Mapping[str, CalibrationResult], screening: ScreenedRecording, reference: Reference
    ) -> None:
        super().__init__(results)
        self.screening, self.recording, self.reference = screening, screening.recording, reference
        self.unit: OutputUnit | None = None
        self.tolerance_deg: float | None = None
        self.named = True
        self.change: WithoutChange | None = None

    @classmethod
    def of(
        cls,
        recording: Recording,
        reference: Reference,
        chosen: Sequence[CalibratorEntry],
        quiet: Callable[[Recording], WithoutChange] | None = None,
    ) -> Self:
        """The calibrations of a screened recording by every chosen calibrator, without any by the usual ones.

        quiet : takes the day's change off the screened recording.
        """
        screening = screen(recording, reference)
        change = None if quiet is None else quiet(screening.recording)
        screening = screening if change is None else replace(screening, recording=change.recording)
        named, chosen = bool(chosen), chosen or usual_calibrators(screening.recording, reference)
        views = {key: one for entry in chosen for key, one in sensor_recordings(recording, entry.name).items()}
        results = {}
        for fit in sensor_fits(screening.recording, reference, chosen):
            judged = screening.judged(fit.calibration, fit.sensor)
            results[fit.key] = CalibrationResult.of(judged, views[fit.key], reference)
        found = cls(results, screening, reference)
        found.change, found.named = change, named
        return found

    def __repr__(self) -> str:
        """The verdict."""
        from validation.assessment.wording import verdict

        return verdict(self.assessment)

    def claims(self) -> dict[str, Claim]:
        """The offset's scatter over legs against its claimed standard deviation, where a calibrator claims one."""
        from validation.cross_validation.claimed_std import claims_of

        return claims_of(self, self.recording, self.reference)

    @cached_property
    def assessment(self) -> Assessment:
        """How good the calibrations are: heading error with interval, held-out strength, use, quality, trust."""
        from validation.assessment.assessment import assess

        return assess(self, self.screening, self.reference, self.tolerance_deg)

    @property
    def exported(self) -> tuple[str, ...]:
        """The keys of what is exported: all calibrators that were named, else the recommended one on every sensor."""
        name = "" if self.named else self.assessment.recommended.partition("@")[0]
        return tuple(key for key in self if not name or key.partition("@")[0] == name)

    def known_figures(self) -> dict[str, tuple[KnownFigure, ...]]:
        """The figures of other programs, with their limits, on the recording of each calibration."""
        from validation.known_figures import known_figures

        parts = {name: fit.recording for name, fit in self.items()}
        alone = self.recording.array_mag_nT is None
        seen = {name: self.recording if alone else part for name, part in parts.items()}
        return {name: known_figures(fit, seen[name], self.reference) for name, fit in self.items()}

    def presented(self, title: str = "calibration") -> PresentedCalibrations:
        """Words and rows, as page, terminal and notebook show them."""
        from reports.presentation.calibration import PresentedCalibrations
        from validation.screening.screening import screening_lines

        doubts = screening_lines(self.screening) if self.screening.faults else ()
        return PresentedCalibrations.of(title, self, self.recording, self.reference, self.assessment, doubts)

    def to_frame(self) -> pd.DataFrame:
        """A row a calibrator: status, heading error with its interval, held-out strength, offset."""
        import pandas as pd

        return pd.DataFrame([fit.row() for fit in self.presented().fits])

    def plot(self) -> Figure:
        """The strength before and after the recommended calibration; the raw one alone where none is recommended."""
        from reports.plots.calibration import draw_strength_before_after
        from reports.plots.recording import draw_recording

        best = self.get(self.assessment.recommended)
        if best is None:
            return draw_recording(self.recording)
        measured = best.recording
        return draw_strength_before_after(
            measured.time_s, measured.mag_nT, best.corrected_nT, self.reference.strength_nT
        )
