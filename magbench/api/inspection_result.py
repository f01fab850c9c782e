"""A first look at a recording as a result."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from magbench.api.displayed import Displayed, values_of
from validation.inspection.inspection import Inspection

if TYPE_CHECKING:
    import pandas as pd

    from reports.plots.style import Figure


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
