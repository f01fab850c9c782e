"""A file of gates as a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from magbench.api.displayed import Displayed
from validation.gates.gate_outcome import GateOutcome

if TYPE_CHECKING:
    import pandas as pd

    from reports.plots.style import Figure


@dataclass(frozen=True, repr=False)
class GateResult(Displayed):
    """The outcomes of a file of gates; `strict`: an inconclusive gate counts as failed."""

    outcomes: tuple[GateOutcome, ...]
    strict: bool = False

    def __repr__(self) -> str:
        """How many gates failed or are inconclusive."""
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
