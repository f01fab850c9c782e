"""Results of the public functions with a table and a picture, which are computed on demand."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import fields
from html import escape
from typing import TYPE_CHECKING, Any

from validation.text import figure

if TYPE_CHECKING:
    import pandas as pd

    from reports.plots.style import Figure


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


def values_of(found: Any) -> dict[str, Any]:
    """A result's fields by name."""
    return {item.name: getattr(found, item.name) for item in fields(found)}
