"""What the functions of `magbench` return: results that show themselves, as a table and as a picture."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from html import escape
from typing import Any, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from calib.reference import Reference
from calib.result import Calibration
from diagnosis.result import Diagnosis
from recordings import Recording
from reports.plots.diagnosis import draw_gap
from reports.plots.field import draw_clouds, draw_sphere
from reports.plots.inspection import draw_coverage
from reports.plots.style import Figure, styled_data_url
from reports.text.diagnosis import parameter_rows
from reports.text.inspection import finding_rows
from validation.inspection.inspection import Inspection
from validation.scoring.outcome import Outcome


class Displayed(ABC):
    """A result with a table and a picture; a notebook shows both."""

    @abstractmethod
    def to_frame(self) -> pd.DataFrame:
        """The result as a table."""

    @abstractmethod
    def plot(self) -> Figure:
        """The result as a picture."""

    def _repr_html_(self) -> str:
        picture = f'<img src="{styled_data_url(self.plot)}" style="max-width: 100%">'
        return f"<p>{escape(repr(self))}</p>\n{picture}\n{self.to_frame().to_html()}"


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class CalibrationResult(Calibration, Displayed):
    """A calibration with the recording and the reference that it was fitted to."""

    recording: Recording
    reference: Reference

    @classmethod
    def of(cls, found: Calibration, recording: Recording, reference: Reference) -> Self:
        """The calibration that a calibrator gave, on what it was given."""
        return cls(**values_of(found), recording=recording, reference=reference)

    @property
    def corrected_nT(self) -> NDArray[np.float64]:
        """The recording's field after correction (n, 3), body frame."""
        return self.apply(self.recording)

    def to_frame(self) -> pd.DataFrame:
        """Offset and matrix, a row an axis."""
        table = pd.DataFrame(self.matrix, index=list("xyz"), columns=[f"matrix_{axis}" for axis in "xyz"])
        table.insert(0, "offset_nT", self.offset_nT)
        return table

    def plot(self) -> Figure:
        """Raw and corrected field against the sphere of the field's strength."""
        clouds = {"raw": self.recording.mag_nT, f"corrected: {self.name}": self.corrected_nT}
        return draw_clouds(clouds, self.reference.strength_nT)


class RunResult(Outcome, Displayed):
    """A simulated run with every calibrator's answer and scores."""

    @classmethod
    def of(cls, found: Outcome) -> Self:
        """The outcome, shown."""
        return cls(**values_of(found))

    def to_frame(self) -> pd.DataFrame:
        """The scores, a row a calibrator, best first, and the raw measurement's last."""
        scores = {name: {s.name: s.value for s in self.scores[name]} for name in self.rows()}
        table = pd.DataFrame.from_dict(scores, orient="index")
        fitted = (self.calibrations.get(name) for name in scores)
        table.insert(0, "status", [fit.status.kind if fit else "-" for fit in fitted])
        return table

    def plot(self) -> Figure:
        """Raw field and the best corrected one against the sphere."""
        return draw_sphere(self)


class DiagnosisResult(Diagnosis, Displayed):
    """Where a recording and a model disagree, and what is missing."""

    @classmethod
    def of(cls, found: Diagnosis) -> Self:
        """The diagnosis, shown."""
        return cls(**values_of(found))

    def to_frame(self) -> pd.DataFrame:
        """The parameters of the missing effects with the ends of their 95 % intervals."""
        heads = ["effect", "parameter", "value", "low", "high", "unit"]
        return pd.DataFrame([(one.name, *row) for one in self.named for row in parameter_rows(one)], columns=heads)

    def plot(self) -> Figure:
        """The gap over time, before and after."""
        return draw_gap(self)


class InspectionResult(Inspection, Displayed):
    """What a first look at a recording found."""

    @classmethod
    def of(cls, found: Inspection) -> Self:
        """The inspection, shown."""
        return cls(**values_of(found))

    def to_frame(self) -> pd.DataFrame:
        """The findings, a row each."""
        return pd.DataFrame(finding_rows(self), columns=["what", "mark", "value", "unit", "in words"])

    def plot(self) -> Figure:
        """Where the field pointed in the sensor's frame."""
        return draw_coverage(self.sensors[0])


def values_of(found: Any) -> dict[str, Any]:
    """A result's fields by name."""
    return {item.name: getattr(found, item.name) for item in fields(found)}
