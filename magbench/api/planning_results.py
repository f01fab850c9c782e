"""What `magbench.bound`, `what_if` and `plan` return, as tables and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from magbench.api.displayed import Displayed, values_of
from validation.bound import summary as bound_words
from validation.bound.query import BoundAnswer, WhatIf
from validation.planning import next_leg_summary as leg_words
from validation.planning import summary as plan_words
from validation.planning.next_leg import LegSequence
from validation.planning.plan import Plan

if TYPE_CHECKING:
    import pandas as pd

    from reports.plots.style import Figure


class BoundResult(BoundAnswer, Displayed):
    """The least errors that any method can reach."""

    @classmethod
    def of(cls, found: BoundAnswer) -> Self:
        """A bound, displayed."""
        return cls(**values_of(found))

    def __repr__(self) -> str:
        """The offset's least error, the unobservable directions, and what would make them observable."""
        return bound_words.headline(self)

    def to_frame(self) -> pd.DataFrame:
        """Least standard deviations of offset and matrix, a row an axis."""
        import pandas as pd

        table = pd.DataFrame(self.bound.matrix_std, index=list("xyz"), columns=[f"S_{axis}_std" for axis in "xyz"])
        table.insert(0, "offset_std_nT", self.bound.offset_std_nT)
        return table

    def plot(self) -> Figure:
        """The least error of each of the offset's components."""
        from reports.plots.bound import draw_components

        return draw_components(self)


class WhatIfResult(WhatIf, Displayed):
    """The bound at several values of one key of a scenario."""

    def __repr__(self) -> str:
        """How the least error changes over the values."""
        return bound_words.what_if_headline(self)

    def to_frame(self) -> pd.DataFrame:
        """The least errors, a row a value."""
        import pandas as pd

        return pd.DataFrame(bound_words.what_if_rows(self), columns=bound_words.what_if_heads(self))

    def plot(self) -> Figure:
        """The least error of the offset over the values."""
        from reports.plots.bound import draw_offset

        return draw_offset(self)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class PlanResult(Plan, Displayed):
    """The best calibration manoeuvre of a vehicle with its scenario; `written`: plan.json."""

    written: dict[str, Any] | None = None

    def __repr__(self) -> str:
        """The predicted error, its ratio to the limit of the tilts, and what the trials found."""
        return plan_words.headline(self)

    def rows(self) -> list[tuple[str, ...]]:
        """The attitudes to show, a row each, with `HEADS`."""
        return plan_words.rows(self)

    def to_frame(self) -> pd.DataFrame:
        """The attitudes to show, a row each."""
        import pandas as pd

        return pd.DataFrame(self.rows(), columns=plan_words.HEADS)

    def plot(self) -> Figure:
        """Yaw, pitch and roll over time."""
        from reports.plots.plan import draw_angles

        return draw_angles(self)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class OnwardResult(LegSequence, Displayed):
    """The legs to fly after a recording; `written`: plan.json."""

    written: dict[str, Any] | None = None

    def __repr__(self) -> str:
        """The gain of the legs, and when they no longer pay."""
        return leg_words.headline(self)

    def rows(self) -> list[tuple[str, ...]]:
        """The attitudes of the legs, a row each, with `HEADS`."""
        return leg_words.rows(self)

    def to_frame(self) -> pd.DataFrame:
        """The attitudes of the legs, a row each."""
        import pandas as pd

        return pd.DataFrame(self.rows(), columns=plan_words.HEADS)

    def plot(self) -> Figure:
        """The error after each leg."""
        from reports.plots.plan import draw_gains

        return draw_gains(self)


def plan_result(found: Plan | LegSequence, written: dict[str, Any] | None) -> PlanResult | OnwardResult:
    """A plan or the legs after a recording, displayed."""
    cls = PlanResult if isinstance(found, Plan) else OnwardResult
    return cls(**values_of(found), written=written)
