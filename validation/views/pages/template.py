"""The reports' HTML templates."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2

from validation.text import digits

TEMPLATES = Path(__file__).parent.parent / "templates"


def rendered(name: str, values: Mapping[str, Any]) -> str:
    """The page that a template makes of these values; a value that the template wants and does not get is an error."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
    )
    environment.filters["digits"] = digits
    return environment.get_template(name).render(values)
