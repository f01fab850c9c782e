"""Diagnoses as results: of one recording, of several, or of an array's sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self

from diagnosis.result import Diagnosis
from diagnosis.several.result import PooledDiagnosis
from magbench.api.displayed import Displayed, values_of

if TYPE_CHECKING:
    import pandas as pd

    from reports.plots.style import Figure
    from reports.presentation.diagnosis import PresentedDiagnosis
    from reports.presentation.pooled import PresentedPool
    from reports.presentation.stated_iron import StatedIron


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
