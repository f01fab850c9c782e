"""What the public functions return: results with a table and a picture, which are computed on demand."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, Self

from diagnosis.result import Diagnosis
from diagnosis.several.result import PooledDiagnosis
from reports.pages.comparison import Comparison
from validation.gates.gate_outcome import GateOutcome
from validation.inspection.inspection import Inspection
from validation.scoring.outcome import Outcome
from validation.text import figure

if TYPE_CHECKING:
    import pandas as pd

    from reports.plots.style import Figure
    from reports.presentation.diagnosis import PresentedDiagnosis
    from reports.presentation.pooled import PresentedPool
    from reports.presentation.stated_iron import StatedIron


class Displayed(ABC):
    """A result with a table and a picture; a notebook shows both."""

    @abstractmethod
    def to_frame(self) -> pd.DataFrame:
        """The result as a table."""

    @abstractmethod
    def plot(self) -> Figure:
        """The result as a picture."""

    def _repr_html_(self) -> str:
        from reports.plots.style import styled_data_url

        picture = f'<img src="{styled_data_url(self.plot)}" style="max-width: 100%">'
        return f"<p>{escape(repr(self))}</p>\n{picture}\n{self.to_frame().to_html(float_format=figure)}"


class RunResult(Outcome, Displayed):
    """A simulated run with every calibrator's calibration and scores."""

    @classmethod
    def of(cls, found: Outcome) -> Self:
        """The outcome of a run, displayed."""
        return cls(**values_of(found))

    def to_frame(self) -> pd.DataFrame:
        """The scores, a row a calibrator, best first, and the raw measurement's last."""
        import pandas as pd

        scores = {name: {s.name: s.value for s in self.scores[name]} for name in self.rows()}
        table = pd.DataFrame.from_dict(scores, orient="index")
        fitted = (self.calibrations.get(name) for name in scores)
        table.insert(0, "status", [fit.status.kind if fit else "-" for fit in fitted])
        return table

    def plot(self) -> Figure:
        """Raw field and the best corrected one against the sphere."""
        from reports.plots.field import draw_sphere

        return draw_sphere(self)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ComparisonResult(Comparison, Displayed):
    """Calibrators compared over many trials, by the seed of the design."""

    seed: int

    @classmethod
    def of(cls, found: Comparison, seed: int) -> Self:
        """A comparison, displayed."""
        return cls(**values_of(found), seed=seed)

    def __repr__(self) -> str:
        """The answer."""
        return self.sentence

    def summary(self) -> dict[str, Any]:
        """The answer and every figure as plain values: comparison.json."""
        from reports.outputs.comparison import summary

        return summary(self, self.seed)

    def to_frame(self) -> pd.DataFrame:
        """A row a point, calibrator and score: median with its interval, failures, ratio to the bound."""
        import pandas as pd

        return pd.DataFrame(self.summary()["table"])

    def plot(self) -> Figure:
        """The deciding score of every calibrator at the first point."""
        from reports.plots.comparison import draw_distributions

        return draw_distributions(self.table, self.answers[0].score, 0)


@dataclass(frozen=True, repr=False)
class GateResult(Displayed):
    """The outcomes of a file of gates; `strict`: an undecided gate counts as failed."""

    outcomes: tuple[GateOutcome, ...]
    strict: bool = False

    def __repr__(self) -> str:
        """How many gates failed or are undecided."""
        from reports.text.gates import headline

        return headline(self.outcomes)

    @property
    def failed(self) -> tuple[GateOutcome, ...]:
        """The gates that fail a build."""
        failing = {"fail", "inconclusive"} if self.strict else {"fail"}
        return tuple(outcome for outcome in self.outcomes if outcome.verdict in failing)

    def to_frame(self) -> pd.DataFrame:
        """A row a gate: verdict, measured, limit, trials, smallest defect seen."""
        import pandas as pd

        from reports.text.gates import HEADS, gate_rows

        return pd.DataFrame(gate_rows(self.outcomes), columns=HEADS)

    def plot(self) -> Figure:
        """The trials of the first failed gate, else of the first, against its limit."""
        from reports.plots.gates import draw_gate_course

        return draw_gate_course((*self.failed, *self.outcomes)[0])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class DiagnosisResult(Diagnosis, Displayed):
    """Where a recording and a model disagree, and the missing effects.

    stated : the answer on a calibration that was stated in place of a model.
    """

    stated: tuple[StatedIron, ...] = ()

    @classmethod
    def of(cls, found: Diagnosis, stated: Sequence[StatedIron] = ()) -> Self:
        """A diagnosis, displayed."""
        return cls(**values_of(found), stated=tuple(stated))

    @cached_property
    def presented(self) -> PresentedDiagnosis:
        """Words, rows and series, as report, viewer and terminal show them."""
        from reports.presentation.diagnosis import PresentedDiagnosis

        return PresentedDiagnosis.of(self).beside(self.stated)

    def to_frame(self) -> pd.DataFrame:
        """The parameters of the missing effects with the ends of their 95 % intervals."""
        import pandas as pd

        from reports.presentation.diagnosis import PARAMETER_HEADS

        rows = [(cause.name, *row) for cause in self.presented.causes for row in cause.parameters]
        return pd.DataFrame(rows, columns=["effect", *PARAMETER_HEADS])

    def plot(self) -> Figure:
        """The gap over time, before and after."""
        from reports.plots.diagnosis import draw_gap

        return draw_gap(self.presented)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class PooledDiagnosisResult(PooledDiagnosis, Displayed):
    """The diagnosis of several recordings of one instrument, or of an array's sensors.

    stated : the answer of each recording on a calibration that was stated in place of a model.
    """

    stated: tuple[StatedIron, ...] = ()

    @classmethod
    def of(cls, found: PooledDiagnosis, stated: Sequence[StatedIron] = ()) -> Self:
        """A pooled diagnosis, displayed."""
        return cls(**values_of(found), stated=tuple(stated))

    @cached_property
    def presented(self) -> PresentedPool:
        """Words, rows and series, as report, viewer and terminal show them."""
        from reports.presentation.pooled import PresentedPool

        return PresentedPool.of(self).beside(self.stated)

    def to_frame(self) -> pd.DataFrame:
        """The parameters of the effects, pooled and in every recording, with their 95 % intervals."""
        import pandas as pd

        from reports.presentation.diagnosis import PARAMETER_HEADS

        heads = ["effect", self.scope.noun, "evidence", *PARAMETER_HEADS]
        return pd.DataFrame([(one.name, *row) for one in self.presented.common for row in one.rows], columns=heads)

    def plot(self) -> Figure:
        """The gap of every recording over time, before and after."""
        from reports.plots.pooled import draw_gaps

        return draw_gaps(self.presented)


def diagnosis_result(
    found: Diagnosis | PooledDiagnosis, stated: Sequence[StatedIron] = ()
) -> DiagnosisResult | PooledDiagnosisResult:
    """A diagnosis of one or of several recordings, displayed."""
    if isinstance(found, Diagnosis):
        return DiagnosisResult.of(found, stated)
    return PooledDiagnosisResult.of(found, stated)


class InspectionResult(Inspection, Displayed):
    """The findings of a first look at a recording."""

    @classmethod
    def of(cls, found: Inspection) -> Self:
        """An inspection, displayed."""
        return cls(**values_of(found))

    def to_frame(self) -> pd.DataFrame:
        """The findings, a row each."""
        import pandas as pd

        from reports.text.inspection import finding_rows

        return pd.DataFrame(finding_rows(self), columns=["what", "mark", "value", "unit", "in words"])

    def plot(self) -> Figure:
        """The directions of the field in the sensor's frame."""
        from reports.plots.inspection import draw_coverage

        return draw_coverage(self.sensors[0])


def values_of(found: Any) -> dict[str, Any]:
    """A result's fields by name."""
    return {item.name: getattr(found, item.name) for item in fields(found)}
