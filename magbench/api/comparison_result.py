"""A comparison of calibrators as a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from magbench.api.displayed import Displayed, values_of
from reports.pages.comparison import Comparison

if TYPE_CHECKING:
    import pandas as pd

    from reports.plots.style import Figure


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
