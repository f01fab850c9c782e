"""A simulated run as a result: its scores as a table, its field as a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from magbench.api.displayed import Displayed, values_of
from validation.scoring.outcome import Outcome

if TYPE_CHECKING:
    import pandas as pd

    from reports.plots.style import Figure


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
