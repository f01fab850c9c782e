"""What the functions of `magbench.api_bounds` return, as tables and pictures."""

from __future__ import annotations

from typing import Self

import pandas as pd

from magbench.results import Displayed, values_of
from reports.plots.bound import draw_components
from reports.plots.plan import draw_angles, draw_gains
from reports.plots.style import Figure
from validation.bound import summary as answer
from validation.bound.query import BoundAnswer
from validation.planning import next_leg_summary as onward_words
from validation.planning import summary as words
from validation.planning.next_leg import LegSequence
from validation.planning.plan import Plan


class BoundResult(BoundAnswer, Displayed):
    """The least errors that any method can reach."""

    @classmethod
    def of(cls, found: BoundAnswer) -> Self:
        """The answer, shown."""
        return cls(**values_of(found))

    def __repr__(self) -> str:
        """What the offset can be told to, what is not told apart, and what would help."""
        return answer.headline(self)

    def to_frame(self) -> pd.DataFrame:
        """Least standard deviations of offset and matrix, a row an axis."""
        table = pd.DataFrame(self.bound.matrix_std, index=list("xyz"), columns=[f"S_{axis}_std" for axis in "xyz"])
        table.insert(0, "offset_std_nT", self.bound.offset_std_nT)
        return table

    def plot(self) -> Figure:
        """The least error of each of the offset's components."""
        return draw_components(self)


class PlanResult(Plan, Displayed):
    """The manoeuvre that calibrates a vehicle best, and the scenario that flies it."""

    @classmethod
    def of(cls, found: Plan) -> Self:
        """The plan, shown."""
        return cls(**values_of(found))

    def __repr__(self) -> str:
        """What it promises, how far that is from the limit, and what the trials found."""
        return words.headline(self)

    def to_frame(self) -> pd.DataFrame:
        """The attitudes to show, a row each."""
        return pd.DataFrame(words.rows(self), columns=words.HEADS)

    def plot(self) -> Figure:
        """Yaw, pitch and roll over time."""
        return draw_angles(self)


class OnwardResult(LegSequence, Displayed):
    """What to fly after a recording."""

    @classmethod
    def of(cls, found: LegSequence) -> Self:
        """The legs, shown."""
        return cls(**values_of(found))

    def __repr__(self) -> str:
        """What the legs gain, and when they no longer pay."""
        return onward_words.headline(self)

    def to_frame(self) -> pd.DataFrame:
        """The attitudes of the legs, a row each."""
        return pd.DataFrame(onward_words.rows(self), columns=words.HEADS)

    def plot(self) -> Figure:
        """The error after each leg."""
        return draw_gains(self)
