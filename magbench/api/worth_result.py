"""What `magbench.worth` returns."""

from __future__ import annotations

from html import escape

from validation.cross_validation.summary import headline
from validation.cross_validation.workflow import CrossValidation


class WorthResult(tuple[CrossValidation, ...]):
    """The cross-validation of each sensor, in words."""

    def __repr__(self) -> str:
        """A sentence a pair of models, the recommended model, and the legs held out."""
        return "\n".join(headline(one) for one in self)

    def _repr_html_(self) -> str:
        return "".join(f"<p>{escape(line)}</p>" for line in repr(self).splitlines())
